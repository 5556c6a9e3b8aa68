"""The provenance of the results, as an RO-Crate: recordings, settings, software and results."""

from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd

from ur5lib.report.page.crate import run_crate
from ur5lib.strict import read_yaml
from ur5lib.workspace.places import CITATION, SNAKEFILE


class DescribedRun(NamedTuple):
    """The metadata of a study's results, and the Snakefile that made them."""

    crate: dict[str, Any]
    workflow: str


def describe_run(
    title: str,
    report: list[Path],
    raw: list[Path],
    extensions: list[Path],
    files: pd.DataFrame,
    tables: list[Path],
    figures: list[Path],
) -> DescribedRun:
    """Return the metadata of a study's results, the content of ro-crate-metadata.json, and the
    Snakefile; files: checksums of the recordings' files.
    """
    folder = report[0].parent
    results, used = (
        [*map(str, one)] for one in ([*report, *tables, *figures], [*raw, *extensions])
    )
    checksums = dict(zip(files["file"], files["sha256"], strict=True))
    workflow = SNAKEFILE.read_text(encoding="utf-8")
    citation = read_yaml(CITATION)
    return DescribedRun(run_crate(folder, title, used, results, citation, checksums), workflow)
