"""Steps of the workflow: rules run their scripts in warm processes."""
