"""Many short recordings of one arm, each read like the first of its form."""

import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

import numpy as np

from ur5lib.chain.recordings import Arm, Recordings
from ur5lib.commands.into import LAST
from ur5lib.errors import InputError
from ur5lib.importing.after import Ends, links
from ur5lib.importing.entry import place_of_file
from ur5lib.importing.in_memory import read, recordings_of
from ur5lib.study.model import Recording, Study

COMPARED = 50  # files, in which no other may begin or end as near
HEAD_BYTES = 1 << 16  # of a table, which have the line of its columns


class Episodes:
    """Reads files of an arm, in order; known: entries of files that a study has, which stay as they
    are.

    Where one is proven to follow the last one (`importing.after`), `after` of its entry is LAST.
    """

    def __init__(self, arm: Arm, known: Iterable[Recording] = ()) -> None:
        self.arm = arm
        self._forms = dict[bytes, Study]()
        self._known = {one.path.resolve(): one for one in known}
        self._ends = dict[str, Ends]()  # of the last files, by their paths

    def __call__(self, path: Path) -> Recordings:
        """Return the recording, or recordings, of a file; something may touch the arm there.

        Raises InputError where it cannot be read.
        """
        if (entry := self._known.get(path.resolve())) is not None:
            return recordings_of(_study([entry]))
        runs = self._read(path)
        follows = len(runs) == 1 and self._follows(path, runs)
        return runs._with(after=LAST) if follows else runs

    def _read(self, path: Path) -> Recordings:
        form = _form_of(path)
        if form in self._forms:
            with suppress(InputError):  # another form with the same beginning
                return recordings_of(_moved(self._forms[form], path))
        runs = read(path, self.arm, role="contact")
        if len(runs) == 1:
            self._forms.setdefault(form, runs._study)
        return runs

    def _follows(self, path: Path, runs: Recordings) -> bool:
        """Return whether a recording follows that of the last file, and keep its ends."""
        last, self._ends[str(path)] = next(reversed(self._ends), ""), _ends_of(path, runs)
        self._ends = dict([*self._ends.items()][-COMPARED:])
        link = links(self._ends).get(str(path))
        return link is not None and link.before == last


def _ends_of(path: Path, runs: Recordings) -> Ends:
    q, quality = runs.q.to_numpy(), runs._timing(runs.names[0])
    began = np.nan if quality.start_epoch_s is None else quality.start_epoch_s
    stem = re.sub(r"\.\w+$", "", str(path))
    return Ends(stem, q[0], q[-1], began, began + quality.duration_s)


def _study(entries: list[Recording]) -> Study:
    return Study(study="episodes", title="Episodes", recordings=entries)


def _moved(study: Study, path: Path) -> Study:
    """Return a study of one recording with another file in its place."""
    (entry,) = study.recordings
    moved = entry.model_copy(update=place_of_file(path) | {"account": []})
    return study.model_copy(update={"recordings": [moved]})


def _form_of(path: Path) -> bytes:
    """Return what files of one form have in common: their ending, and a table's first line."""
    ending = path.suffix.lower().encode()
    if path.is_dir() or ending in (b".h5", b".hdf5", b".npz", b".parquet", b".mcap", b".db3"):
        return ending
    with path.open("rb") as file:
        first = file.read(HEAD_BYTES).partition(b"\n")[0]
    is_row = re.match(rb"\s*[-+.\d]", first)  # of a table without names
    return ending + (re.sub(rb"[-+.\deE]+", b"0", first) if is_row else first)
