"""Published recordings that users can fetch themselves: which there are, and `ur5 fetch`."""
