"""The study's tables of results, from the results of all recordings and arms."""

from typing import Any

from ur5lib.report.reference import read_reference
from ur5lib.report.tables.making import declarations, joined, lazy_results, make_table
from ur5lib.tables import write_csv


def make_tables(input: Any, output: Any, params: Any) -> None:
    declared = declarations()
    parts = output.keys() - declared.keys()  # tables that a step writes for each recording or arm
    kinds = {
        kind: lazy_results(kind, paths)
        for kind, paths in input.items()
        if kind != "reference" and kind not in parts
    }
    printed = read_reference(input.get("reference")).printed
    for name, path in output.items():
        whole = joined(input[name]) if name in parts else make_table(name, kinds, printed)
        write_csv(whole, path)
