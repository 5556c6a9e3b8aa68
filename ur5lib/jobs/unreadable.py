"""Recordings that cannot be read: their files say why, and the rest of a study goes on.

The step that reads a recording writes the reason into each of its output files. Later steps of the
same recording copy it to their outputs; steps of several recordings go on without this recording.
"""

import json
from collections.abc import Mapping
from pathlib import Path

from ur5lib.errors import UnreadableError

Files = Mapping[str, str | list[str]]  # of a job, by name
MARK = '{"unreadable": '
MAX_BYTES = 10_000  # a file with a reason is at most this large


def marked(reason: str) -> str:
    """Return the text that is written into an output in place of its content; reason: why the
    recording cannot be read.
    """
    return f"{MARK}{json.dumps(reason)}}}\n"


def reason(path: str) -> str:
    """Return the reason that `marked` wrote into a recording's file, "" if the recording can be
    read.
    """
    file = Path(path)
    if not file.is_file() or file.stat().st_size > MAX_BYTES:
        return ""
    if not file.read_bytes().startswith(MARK.encode()):
        return ""
    return str(json.loads(file.read_text(encoding="utf-8"))["unreadable"])


def readable(files: Files) -> tuple[Files, dict[str, str]]:
    """Return the files of a job without those of unreadable recordings, and the reasons by name.

    Raises UnreadableError if the job's own recording is unreadable. If all of several are, the job
    runs as in a study without recordings.
    """
    kept, absent = dict[str, str | list[str]](), dict[str, str]()
    for name, paths in files.items():
        if isinstance(paths, str):
            if why := reason(paths):
                raise UnreadableError(why)
            kept[name] = paths
            continue
        reasons = {path: why for path in paths if (why := reason(path))}
        absent |= {Path(path).parent.name: why for path, why in reasons.items()}
        kept[name] = [path for path in paths if path not in reasons]
    return kept, absent


def unreadable(results: Path) -> dict[str, str]:
    """Return the recordings of a study that cannot be read, each with the reason."""
    files = *results.glob("recordings/*/quality.json"), *results.glob("postures/*/postures.json")
    return {path.parent.name: why for path in sorted(files) if (why := reason(str(path)))}
