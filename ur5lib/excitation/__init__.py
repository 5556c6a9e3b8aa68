"""What recordings have shown of an arm's parameters, and what other recordings would show."""
