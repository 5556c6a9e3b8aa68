"""The report's part on what changed since other studies."""

import pandas as pd

from ur5lib.report.results import Results


def counted(results: Results) -> pd.DataFrame:
    """Return by study and topic how many numbers were compared, differ and changed."""
    rows = results.rows("changes")
    flags = {name: rows[name] == "yes" for name in ("differs", "changed")}
    counts = rows.assign(compared=True, **flags).groupby(["study", "topic"], sort=False)
    return counts[["compared", *flags]].sum().reset_index()


def changed(results: Results) -> pd.DataFrame:
    """Return the numbers that changed."""
    return results.rows("changes", changed="yes")
