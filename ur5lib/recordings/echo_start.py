"""Whether a file has messages that a command of ROS printed, by its beginning."""

import re
from pathlib import Path

ECHOED = "ros-echo"  # their format in a study
MESSAGE_FORMATS = ("rosbag", ECHOED)  # with joints by name
ENDINGS = (".yaml", ".yml", ".txt", ".log", ".csv")
HEAD_BYTES = 4096
HEADER = re.compile(rb"^header: *\r?\n\s+(seq|stamp):", re.MULTILINE)
LINE = re.compile(  # with --csv: stamp, frame, names of joints, numbers
    rb"\d{1,10},\d{1,9},[^,\n]*(,[A-Za-z_]\w*){2,16}(,[-+.\deE]+){2}"
)


def is_echoed(path: Path) -> bool:
    """Return whether a file has echoed messages."""
    if path.suffix.lower() not in ENDINGS or not path.is_file():
        return False
    with path.open("rb") as stream:
        head = stream.read(HEAD_BYTES)
    return bool(HEADER.search(head) or LINE.match(head))
