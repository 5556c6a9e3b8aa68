"""The emulated lab: devices of the virtual test stand that speak their real protocols."""
