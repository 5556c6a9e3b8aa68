"""The study's tables of results, from the results of all recordings and arms."""

from importlib import import_module
from typing import Any

import pandas as pd

from ur5lib.report.reference import read_reference
from ur5lib.report.study_results import StudyResults
from ur5lib.tables import write_csv


def make_tables(input: Any, output: Any, params: Any) -> None:
    results = StudyResults(dict(input.items()), read_reference(input.get("reference")).printed)
    for name, path in output.items():
        table = import_module(f"ur5lib.report.tables.{name}")
        write_csv(pd.DataFrame(table.rows(results), columns=table.COLUMNS), path)
