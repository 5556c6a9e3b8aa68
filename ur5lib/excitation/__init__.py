"""What recordings have told of an arm's parameters, and what others would."""
