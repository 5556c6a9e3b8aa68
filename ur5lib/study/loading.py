"""Snakemake reads a study as `ur5 check` does.

Its own reader runs code that a file holds, where the file has the key `__use_yte__`, and no option
of Snakemake's prevents that.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from snakemake.common import configfile
from snakemake.exceptions import WorkflowError
from snakemake.settings import types

from ur5lib.errors import InputError

if TYPE_CHECKING:
    from ur5lib.study.reading import PlainData


def read_studies_as_data(read_before: Iterable[Path] = ()) -> None:
    """Let Snakemake read studies by `read_plain`, from now on.

    The profiles call it before `--configfile` is read, the Snakefile before config.yaml is.
    read_before: studies that Snakemake has read itself, if no profile has called this.
    Raises WorkflowError where `read_plain` refuses one of them.
    """
    if configfile.load_configfile is _data:
        return
    for place in (configfile, types):
        assert place.load_configfile, "where Snakemake reads a study from"
        place.load_configfile = _data
    for path in read_before:
        _data(path)


def _data(path: str | Path) -> "PlainData":
    """Return a study as plain data. Raises WorkflowError."""
    try:
        from ur5lib.study.reading import (
            read_plain,
        )  # loads extensions, in which there may be errors

        return read_plain(Path(path))
    except InputError as error:
        raise WorkflowError(f"the study has errors\n{error}") from None
