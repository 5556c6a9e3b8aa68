"""What recordings tell of an arm: closed loop, rotors, friction, inertial parameters."""
