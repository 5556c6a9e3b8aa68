"""Published recordings: their catalogue, and `ur5 fetch`."""
