"""Doubles of a laboratory's devices: they emulate them on 127.0.0.1 by their real protocols."""
