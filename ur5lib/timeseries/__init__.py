"""Arrays of samples: filters, derivatives, Kalman smoothing, metrics, segments."""
