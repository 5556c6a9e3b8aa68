"""Recordings of a finished study as files of other programs: `ur5 convert`."""
