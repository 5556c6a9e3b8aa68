"""What differs from the results of other studies, one row for each number that is compared."""

from pathlib import Path
from typing import Any

import pandas as pd

from ur5lib.commands.compare import CHANGE_COLUMNS, compare, rows
from ur5lib.tables import write_csv


def compare_studies(input: Any, output: Any, params: Any) -> None:
    own, others = ({Path(p).parents[1]: None for p in paths} for paths in (input.own, input.others))
    found = [
        row
        for after in own
        for before in others
        for row in rows(before.name, compare(before, after))
    ]
    write_csv(pd.DataFrame(found, columns=CHANGE_COLUMNS), output.changes)
