"""Tables of results from summaries that a test makes up."""

from typing import Any

import pandas as pd

from ur5lib.report.reference import Printed
from ur5lib.report.tables.making import declarations, make_table


def table(name: str, printed: Printed | None = None, **summaries: Any) -> pd.DataFrame:
    """A table from summaries by recording or arm, for each kind of result."""
    return make_table(name, summaries, printed)


def empty(name: str) -> pd.DataFrame:
    _, declared = declarations().tables()[name]
    return pd.DataFrame(columns=declared.columns)
