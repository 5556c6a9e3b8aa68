"""Jobs of the workflow: rules run their steps in warm processes."""
