"""Recording: the devices of a session, read live."""
