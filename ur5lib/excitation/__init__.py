"""Which motion to record next: trajectories designed to determine an arm's parameters."""
