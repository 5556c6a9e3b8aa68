"""A recording's rows of those tables for which no other recording is needed."""

from typing import Any

from ur5lib.report.reference import read_reference
from ur5lib.report.tables.making import declarations, lazy_results, make_table
from ur5lib.tables import csv_text, write_json


def tabulate_recording(input: Any, output: Any, params: Any) -> None:
    kinds = {
        kind: lazy_results(kind, [paths] if isinstance(paths, str) else paths)
        for kind, paths in input.items()
        if kind != "reference"
    }
    printed = read_reference(input.get("reference")).printed
    tables = {
        name: csv_text(make_table(name, kinds, printed))
        for name, declared in declarations().items()
        if declared.first in kinds
    }
    write_json(tables, output.rows)
