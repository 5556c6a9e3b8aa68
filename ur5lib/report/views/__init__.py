"""Views: functions that fill the report's tables, lists and paragraphs from a study's results."""
