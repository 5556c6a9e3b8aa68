"""The study's tables of results, from the results of all recordings and arms."""

from typing import Any

from ur5lib.report.reference import read_reference
from ur5lib.report.tables.making import LazyResults, make_table
from ur5lib.tables import write_csv

ONCE = ("reference", "columns", "sentences")  # inputs that are not results


def make_tables(input: Any, output: Any, params: Any) -> None:
    kinds = {kind: LazyResults(kind, paths) for kind, paths in input.items() if kind not in ONCE}
    printed = read_reference(input.get("reference")).printed
    for name, path in output.items():
        write_csv(make_table(name, kinds, printed), path)
