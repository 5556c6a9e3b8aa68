"""Snakemake reads a study as `ur5 check` does.

Its own reader runs code in a file, where the file has the key `__use_yte__`, and no option of
Snakemake's prevents that: https://github.com/snakemake/snakemake/pull/2269. It reads what
`--configfile` names before it looks at the Snakefile, but after the profile. Therefore the profiles
call `read_studies_as_data`, which puts another reader in the place of Snakemake's, here alone.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from snakemake.common import configfile
from snakemake.exceptions import WorkflowError

from ur5lib.errors import InputError

if TYPE_CHECKING:
    from ur5lib.study.reading import PlainData


def read_studies_as_data(read_before: Iterable[Path] = ()) -> None:
    """Let Snakemake read studies by `read_plain`, from now on.

    The profiles call it before `--configfile` is read, the Snakefile before config.yaml is.
    read_before: studies that Snakemake has read itself, if no profile has called this.
    Raises WorkflowError where `read_plain` refuses one of them.
    """
    if configfile._load_configfile is _data:
        return
    configfile._load_configfile = _data
    for path in read_before:
        _data(path)


def _data(path: str | Path) -> "PlainData":
    """Return a study as plain data. Raises WorkflowError."""
    try:
        # loads extensions, in which there may be errors
        from ur5lib.study.reading import read_plain

        return read_plain(Path(path))
    except InputError as error:
        raise WorkflowError(f"the study has errors\n{error}") from None
