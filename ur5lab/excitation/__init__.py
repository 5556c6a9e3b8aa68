"""Trajectories designed to determine an arm's parameters, to be recorded next."""
