"""An emulated laboratory: the simulated arm in real time, behind the interfaces of real devices."""
