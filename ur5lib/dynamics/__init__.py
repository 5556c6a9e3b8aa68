"""Batched kinematics and dynamics: the only room that imports torch."""
