"""What a reader sees: the page of a report, its words, and how both are written."""
