"""The virtual test stand: an arm with controller and sensors, simulated in MuJoCo."""
