"""Whether an arm changes over time."""

from ur5lib.report.cells import sentence
from ur5lib.report.document import Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import bars
from ur5lib.report.views import health

TOPIC = "Drift over time"


def verdict(results: Results) -> Verdict | None:
    """Judge by whether anything changed; None where too few dates tell."""
    dates = results.tables["health"]
    if dates.empty:
        return None
    changes = health.ranked(results)
    worst = changes.groupby("joint")["share"].max()
    joints = range(1, 7)
    told = "No joint changed by more than chance explains."
    if len(changes):
        told = sentence(health.sentence(next(changes.itertuples())).removesuffix("."))
    return Verdict(
        topic=TOPIC,
        state="usable" if len(changes) else "good",
        sentence=told,
        evidence=_evidence(results, len(changes)),
        drawing=bars({str(joint): float(worst.get(joint, 0.0)) for joint in joints}),
        caption="Largest change by joint; a full bar is a change by 100 %.",
    )


def _evidence(results: Results, changes: int) -> str:
    """Return on how many dates the verdict rests, and how often it would be wrong."""
    dates = results.tables["health"]
    tested = dates.dropna(subset="joint").groupby(["robot", "joint", "quantity"]).ngroups
    days = dates["date"]
    return (
        f"Dates: {days.nunique()}, {health.span(days.min(), days.max())}. Quantities tested: "
        f"{tested}, changes: {changes}; chance of a false one: 5 %."
    )
