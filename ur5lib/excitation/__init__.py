"""What recordings have shown of an arm's parameters, and what others would."""
