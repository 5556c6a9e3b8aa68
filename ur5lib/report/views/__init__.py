"""Views: the rows that sections of the page read, selected from a study's results."""
