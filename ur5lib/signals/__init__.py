"""Device clocks, resampling, smoothed motion, IMU."""
