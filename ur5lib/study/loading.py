"""Makes Snakemake read a study as `ur5 check` does.

Snakemake's own reader runs code in a file with the key `__use_yte__`, which no option prevents:
https://github.com/snakemake/snakemake/pull/2269. It reads the files of `--configfile` before the
Snakefile, but after the profile. Therefore the profiles call `read_studies_as_data`.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from snakemake.exceptions import WorkflowError

from ur5lib.errors import InputError
from ur5lib.jobs.snakemake_inside import replace_reader

if TYPE_CHECKING:
    from ur5lib.study.reading import PlainData


def read_studies_as_data(read_before: Iterable[Path] = ()) -> None:
    """Make Snakemake read studies by `read_plain` from now on.

    The profiles call it before `--configfile` is read, the Snakefile before config.yaml is read.
    read_before: studies that Snakemake itself has already read, if no profile called this. Raises
    WorkflowError where `read_plain` refuses one of them.
    """
    if replace_reader(_data):
        for path in read_before:
            _data(path)


def _data(path: str | Path) -> "PlainData":
    """Return a study as plain data. Raises WorkflowError where `read_plain` refuses its file."""
    try:
        # loads extensions, which may have errors
        from ur5lib.study.reading import read_plain

        return read_plain(Path(path))
    except InputError as error:
        raise WorkflowError(f"the study has errors\n{error}") from None
