"""The health of an arm: how each joint's friction, constant, offset and noise change over time."""
