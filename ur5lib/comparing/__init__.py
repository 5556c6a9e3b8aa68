"""Two results compared: what changed by more than its error."""
