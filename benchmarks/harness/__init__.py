"""What all estimators of the benchmark share: inputs, tuning, the way to a force, scores."""
