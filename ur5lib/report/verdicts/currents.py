"""Whether friction and torque constants predict motor currents."""

from ur5lib.report.document import Number, Verdict
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.verdicts.errors import AgainstBaseline, by_joint, largest
from ur5lib.report.verdicts.states import HELD
from ur5lib.report.views.currents import unseen

TOPIC = "Friction and currents"
CONSTANT = "a constant current"


def verdict(results: Results) -> Verdict:
    """Judge the prediction by its worst joint, and its band by the smallest coverage."""
    rows = unseen(results)
    rows = rows[rows["model"] == "fitted"]
    errors = by_joint(rows, "rmse_2hz", "zero")
    if errors.empty:
        return Verdict(TOPIC, "not determined", say(f"currents.{_reason(results)}"))
    against = AgainstBaseline(errors, largest(rows, "rmse_2hz", "zero"), "A", 2, zero=CONSTANT)
    least = rows.loc[rows["coverage95"].idxmin()]
    held = float(least["coverage95"])
    place = f"joint {least['joint']} on {least['recording']}"
    words = {"joint": against.worst, "percent": against.percent(), "shown": against.shown()}
    words |= {"largest": against.largest_shown(), "least": least, "hold": held >= HELD}
    return Verdict(
        topic=TOPIC,
        state=against.state(held),
        sentence=say("currents.verdict", **words),
        evidence=say("currents.evidence", **words),
        drawing=against.drawing(),
        caption=say("error.bars", zero=CONSTANT),
        numbers=(
            *against.numbers("RMSE below 2 Hz"),
            Number("least share in the 95 % band", 100 * held, "%", place),
        ),
    )


def _reason(results: Results) -> str:
    """Return the name of the sentence on why currents are not judged."""
    if results.tables["friction"].empty:
        return "no friction"
    return "no motion" if results.with_role("validate") else "no validate"
