"""What lies in results/, and what the workflow's steps do with it."""
