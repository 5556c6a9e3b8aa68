"""The report's part on what changed since other studies."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results


def findings(results: Results) -> Iterator[str]:
    """Report for each other study how much changed, and in which topics."""
    for study in results.listed("changes", "study"):
        rows = results.rows("changes", study=study)
        changed = rows[rows["changed"] == "yes"]
        words = {"changed": len(changed), "count": len(rows)}
        yield say("changes.found", study=study, topics=[*changed["topic"].unique()], **words)


def topics(results: Results, study: str) -> pd.DataFrame:
    """Return how many numbers of each topic were compared, differ and changed."""
    rows = results.rows("changes", study=study)
    flags = {name: rows[name] == "yes" for name in ("differs", "changed")}
    counts = rows.assign(compared=True, **flags).groupby("topic", sort=False)
    return counts[["compared", *flags]].sum().reset_index()
