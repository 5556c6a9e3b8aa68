"""Bytes from a TCP connection, with their time of arrival."""

import socket
import time

from ur5lib.recorder.device import DeviceLost

CHUNK = 1 << 16  # bytes read at a time


def receive(connection: socket.socket, address: str) -> tuple[float, bytes]:
    """Return the host's time.monotonic [s] and the available bytes of a connection, at least one.

    address: of the device, for messages. Raises DeviceLost when the connection fails or is closed.
    """
    try:
        data = connection.recv(CHUNK)
    except OSError as error:
        raise DeviceLost(f"{address}: {error}") from error
    if not data:
        raise DeviceLost(f"{address} has closed the connection")
    return time.monotonic(), data
