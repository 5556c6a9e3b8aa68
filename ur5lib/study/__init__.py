"""What a study may say, and what is said where it errs."""
