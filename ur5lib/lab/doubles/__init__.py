"""Doubles of a laboratory's devices, which speak their real protocols on 127.0.0.1."""
