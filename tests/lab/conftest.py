"""What tests of devices share."""

import fcntl
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture(scope="module")
def controller_ports() -> Iterator[None]:
    """The ports that ur_rtde expects of a controller, for one process at a time."""
    with open(Path(tempfile.gettempdir()) / "ur5-controller-ports.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield
