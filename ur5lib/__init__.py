"""Dynamics, friction and contact force of Universal Robots arms, from recordings."""
