"""Identification from recordings: closed loop, rotors, friction, inertial parameters, payload."""
