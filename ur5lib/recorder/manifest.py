"""The manifest of a recording: its devices, their losses, and the files' checksums."""

import platform
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ur5lib.recorder.capture import Status
from ur5lib.tables import checksum, write_json

NAME = "manifest.json"
CLOCK = "time.monotonic of the host, plus its difference to seconds since 1970 at the start"


def write_manifest(
    folder: Path,
    identities: Mapping[str, Mapping[str, Any]],
    statuses: Mapping[str, Status] | None,
    moved: str | None,
) -> None:
    """Write the manifest; statuses: at the end, None before; moved: the commanded motion."""
    entries = {name: dict(identity) for name, identity in identities.items()}
    for name, status in (statuses or {}).items():
        file = folder / f"{name}.csv"
        entries[name] |= {
            "file": file.name,
            "sha256": checksum(file) if file.is_file() else None,
            "samples": status.samples,
            "lost": status.lost,
            "recorded_rate_hz": round(status.rate(), 3),
            "ended": status.ended,
        }
    write_json(
        {
            "written": datetime.now(UTC).isoformat(timespec="seconds"),
            "complete": statuses is not None,
            "host": platform.node(),
            "clock": CLOCK,
            "ur5lib": version("ur5lib"),
            "motion": moved,
            "devices": entries,
        },
        folder / NAME,
    )
