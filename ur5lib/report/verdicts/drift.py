"""Whether an arm changes over time."""

from ur5lib.report.cells import days
from ur5lib.report.document import Verdict
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, capital, say
from ur5lib.report.verdicts.drawings import bars
from ur5lib.report.views import health

TOPIC = "Drift over time"


def verdict(results: Results) -> Verdict | None:
    """Judge by whether anything changed; None with too few dates."""
    dates = results.tables["health"]
    if dates.empty:
        return None
    changes = health.ranked(results)
    worst = changes.groupby("joint")["share"].max()
    joints = range(1, 7)
    sentence = say("health.unchanged")
    if len(changes):
        sentence = capital(health.change(next(changes.itertuples())))
    return Verdict(
        topic=TOPIC,
        state="usable" if len(changes) else "good",
        sentence=sentence,
        evidence=_evidence(results, len(changes)),
        drawing=bars({str(joint): float(worst.get(joint, 0.0)) for joint in joints}),
        caption=say("health.caption"),
    )


def _evidence(results: Results, changes: int) -> Sentence:
    """Return the number of dates, tests and changes, and the chance of a false one."""
    dates = results.tables["health"]
    tested = dates.dropna(subset="joint").groupby(["robot", "joint", "quantity"]).ngroups
    first, last = dates["date"].min(), dates["date"].max()
    words = {"days": dates["date"].nunique(), "span": days(first, last, "to"), "tested": tested}
    return say("health.evidence", changes=changes, **words)
