"""The model of a study, and the messages about errors in it."""
