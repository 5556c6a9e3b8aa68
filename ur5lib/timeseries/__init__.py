"""Arrays of samples: what every room stands on."""
