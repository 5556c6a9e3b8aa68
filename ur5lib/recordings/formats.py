"""The readers, by the name a study calls them."""

from collections.abc import Callable

from ur5lib.recordings import thesis_csv
from ur5lib.recordings.recording import RawRecording

READERS: dict[str, Callable[[str], RawRecording]] = {"thesis-csv": thesis_csv.read}
