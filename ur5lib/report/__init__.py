"""Reports: their tables, figures and page, from the results of a study."""
