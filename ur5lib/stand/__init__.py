"""The virtual test stand: an arm with its controller and sensors, simulated in MuJoCo."""
