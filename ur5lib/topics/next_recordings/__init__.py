"""What another recording of an arm is worth."""
