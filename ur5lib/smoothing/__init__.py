"""The joints' motion and its accelerations, from encoders and an IMU; nothing else uses it."""
