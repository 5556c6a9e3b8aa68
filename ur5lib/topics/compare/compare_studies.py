"""What differs from the results of other studies, one row for each number that is compared."""

from pathlib import Path

import pandas as pd

from ur5lib.topics.compare.comparison import CHANGE_COLUMNS, compare, rows


def compare_studies(own: list[Path], others: list[Path]) -> pd.DataFrame:
    """Return the comparisons of a study with other studies, as rows of changes.csv.

    own: tables of this study; others: tables of the other studies.
    """
    ours, theirs = ({path.parents[1]: None for path in paths} for paths in (own, others))
    found = [
        row
        for after in ours
        for before in theirs
        for row in rows(before.name, compare(before, after))
    ]
    return pd.DataFrame(found, columns=CHANGE_COLUMNS)
