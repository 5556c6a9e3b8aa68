"""What differs from the results of other studies."""

from collections.abc import Iterator

from ur5lib.report.document import Cell
from ur5lib.report.results import Body, Results, tabulated
from ur5lib.report.sentences import Sentence, say


def others(results: Results) -> list[str]:
    """Return the studies to which this one is compared."""
    return [*results.tables["changes"]["study"].unique()]


def summary(results: Results) -> Iterator[Sentence]:
    """Report for each other study how much changed, and in which topics."""
    for study in others(results):
        rows = results.rows("changes", study=study)
        changed = rows[rows["changed"] == "yes"]
        words = {"changed": len(changed), "count": len(rows)}
        yield say("changes.found", study=study, topics=[*changed["topic"].unique()], **words)


def topics(results: Results, study: str) -> Body:
    """Return how many numbers of each topic were compared, differ and changed."""
    rows = results.rows("changes", study=study)
    body = []
    for topic, part in rows.groupby("topic", sort=False):
        counts = [len(part), *((part[name] == "yes").sum() for name in ("differs", "changed"))]
        body.append([Cell(str(topic)), *(Cell(str(count)) for count in counts)])
    return Body(["topic", "compared", "beyond their error", "changed"], body)


def changed(results: Results, study: str) -> Body:
    """Return the numbers that changed, before and now."""
    rows = results.rows("changes", study=study, changed="yes")
    columns = {"topic": "topic", "what": "name", "before": "before", "now": "after"}
    return tabulated(rows.itertuples(index=False), columns)
