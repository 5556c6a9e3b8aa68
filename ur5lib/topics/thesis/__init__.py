"""The thesis that this project began with: its methods, and its printed numbers beside ours."""
