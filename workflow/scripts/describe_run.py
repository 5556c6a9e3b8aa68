"""What made the results: recordings, settings, software and their results, as an RO-Crate."""

import shutil
from pathlib import Path
from typing import Any

from ur5lib.lab.places import CITATION, SNAKEFILE
from ur5lib.report.page.crate import run_crate
from ur5lib.strict import read_yaml
from ur5lib.tables import read_csv, write_json


def describe_run(input: Any, output: Any, params: Any) -> None:
    folder = Path(output.crate).parent
    shutil.copyfile(SNAKEFILE, output.workflow)
    results = [*input.report, *input.tables, *input.figures]
    citation = read_yaml(CITATION)
    read = read_csv(input.files)
    known = dict(zip(read["file"], read["sha256"], strict=True))
    used = [*input.raw, *input.extensions]
    crate = run_crate(folder, params.title, used, results, citation, known)
    write_json(crate, output.crate)
