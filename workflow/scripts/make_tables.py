"""The study's tables of results, from the results of all recordings and arms."""

from io import StringIO
from typing import Any

from ur5lib.report.reference import read_reference
from ur5lib.report.tables.files import name_copies
from ur5lib.report.tables.making import (
    declarations,
    joined,
    joined_texts,
    lazy_results,
    make_table,
)
from ur5lib.tables import read_cells, read_json, write_csv, write_text


def make_tables(input: Any, output: Any, params: Any) -> None:
    declared = declarations()
    parts = output.keys() - declared.keys()  # tables that a step writes for each arm
    kinds = {
        kind: lazy_results(kind, paths)
        for kind, paths in input.items()
        if kind not in {"reference", "rows", *parts}
    }
    printed = read_reference(input.get("reference")).printed
    rows = [read_json(path) for path in input.rows]
    for name, path in output.items():
        if name in parts:
            write_csv(joined(input[name]), path)
        elif declared[name].first in kinds:
            write_csv(make_table(name, kinds, printed), path)
        else:
            text = joined_texts([tables[name] for tables in rows])
            if name == "quality":
                write_csv(name_copies(read_cells(StringIO(text))), path)
            else:
                write_text(text, path)
