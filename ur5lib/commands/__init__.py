"""What the commands of `ur5` do: one module for each, and what several of them need."""
