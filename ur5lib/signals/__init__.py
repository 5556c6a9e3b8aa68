"""Device clocks, resampling, IMU calibration."""
