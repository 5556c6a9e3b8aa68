"""The recordings of a finished study, written in a format of other programs."""

from collections.abc import Callable, Iterator
from pathlib import Path

from ur5lib.errors import InputError
from ur5lib.exporting.contents import Contents, contents
from ur5lib.exporting.csv import write_csv_folder
from ur5lib.exporting.mat import write_mat
from ur5lib.exporting.mcap import write_mcap
from ur5lib.finished import FinishedStudy

WRITERS: dict[str, tuple[str, Callable[[Contents, Path], None]]] = {  # ending of a path, writer
    "mat": (".mat", write_mat),
    "csv": ("", write_csv_folder),
    "mcap": (".mcap", write_mcap),
}


def write_recordings(
    results: Path, names: list[str], to: str, into: Path | None = None
) -> Iterator[Path]:
    """Write recordings of a study, and yield the path of each: <into>/<recording>.<to>.

    results: results/<study>; names: of its recordings, none for all; to: a key of `WRITERS`; into:
    the folder, by default `exported` among the results. CSV is a folder itself. Raises InputError
    for missing results and files that cannot be written.
    """
    if to not in WRITERS:
        raise InputError(f"unknown format {to!r}; available: {', '.join(WRITERS)}")
    study, (ending, write) = FinishedStudy(results), WRITERS[to]
    for name in names or study.recordings:
        path = (into or results / "exported") / f"{name}{ending}"
        write(contents(study, name), path)
        yield path
