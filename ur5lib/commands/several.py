"""`ur5 report` of several studies: their page is written as a file."""

from collections.abc import Sequence
from pathlib import Path

from ur5lib.errors import InputError
from ur5lib.report.several import several_page
from ur5lib.tables import write_text


def write_several(studies: Sequence[Path], page: Path) -> Path:
    """Write the page of several studies and return it; what is no folder of results is left out.

    Raises InputError where none of the studies is built.
    """
    folders = [one for one in dict.fromkeys(studies) if (one / "results.json").is_file()]
    if not folders:
        next_ = f"ur5 run {studies[0].name}"
        raise InputError(f"none of {len(studies)} studies is built; next: {next_}")
    write_text(several_page(folders, page), page)
    return page
