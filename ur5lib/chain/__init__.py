"""The chain of steps in memory: recordings as read, and the model that is fitted to them."""
