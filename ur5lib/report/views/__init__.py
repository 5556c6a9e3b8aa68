"""What the report's tables, lists and sentences say, made from a study's results."""
