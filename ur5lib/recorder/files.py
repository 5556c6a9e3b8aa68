"""Files written while a device is recorded, at any time valid up to the last line."""

from pathlib import Path
from typing import Any, Protocol

from ur5lib.recorder.device import NewSamples

HOST_TIME = "host_time"


class Growing(Protocol):
    """A file to which a device's samples are appended while it is recorded."""

    def write(self, samples: Any, zero: float) -> None:
        """Append samples; zero: time of the host's clock when time.monotonic read zero [s]."""
        ...

    def close(self) -> None:
        """Close the file."""
        ...


class RowFile:
    """A CSV with a header and one row per sample, with all digits of its numbers.

    The host's time is the first column, or the last one where the device has its own `timestamp`.
    """

    def __init__(self, path: Path, columns: tuple[str, ...]) -> None:
        self._file = path.open("w", encoding="ascii")
        self._has_clock = columns[0] == "timestamp"
        names = (*columns, HOST_TIME) if self._has_clock else (HOST_TIME, *columns)
        self._file.write(",".join(names) + "\n")
        self._file.flush()

    def write(self, samples: NewSamples, zero: float) -> None:
        """Append samples."""
        rows = zip((zero + samples.received).tolist(), samples.values.tolist(), strict=True)
        for arrived, values in rows:
            cells = [*values, arrived] if self._has_clock else [arrived, *values]
            self._file.write(",".join(map(repr, cells)) + "\n")
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


class PacketFile:
    """A capture of a socket: one line `received_s,payload_hex` per packet."""

    def __init__(self, path: Path, columns: tuple[str, ...]) -> None:
        self._file = path.open("w", encoding="ascii")
        self._file.write(",".join(("received_s", *columns)) + "\n")
        self._file.flush()

    def write(self, samples: Any, zero: float) -> None:
        """Append packets (`realtime_arm.Packets`)."""
        for arrived, packet in zip(samples.received, samples.packets, strict=True):
            self._file.write(f"{zero + arrived:.6f},{packet.hex()}\n")
        self._file.flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()


def growing_file(path: Path, columns: tuple[str, ...]) -> Growing:
    """Return the file for samples with these columns."""
    return PacketFile(path, columns) if columns == ("payload_hex",) else RowFile(path, columns)
