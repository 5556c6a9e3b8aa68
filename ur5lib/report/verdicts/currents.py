"""Whether friction and torque constants predict motor currents."""

from ur5lib.report.document import Number, Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import bars
from ur5lib.report.verdicts.errors import by_joint, ratios, stated, with_range, worst
from ur5lib.report.verdicts.states import HELD, state
from ur5lib.report.views.currents import unseen

TOPIC = "Friction and currents"
CONSTANT = "a constant current"


def verdict(results: Results) -> Verdict:
    """Judge the prediction by its worst joint, and its band by the joint that it holds least."""
    rows = unseen(results)
    rows = rows[rows["model"] == "fitted"]
    errors = by_joint(rows, "rmse_2hz", "zero")
    if errors.empty:
        return Verdict(TOPIC, "not determined", _undetermined(results))
    joint = worst(errors)
    held = rows.groupby("joint")["coverage95"].mean()
    least = held.idxmin()
    shown = with_range(errors.loc[joint], 2, "A", zero=CONSTANT)
    judged = state(errors["error"][joint], errors["zero"][joint], held.min())
    tells = "are no better predicted than by a constant"
    if judged != "do not use":
        tells = "are predicted, and their 95 % bands "
        tells += "hold" if held.min() >= HELD else "are too narrow"
    return Verdict(
        topic=TOPIC,
        state=judged,
        sentence=f"On recordings that no fit has seen, motor currents {tells}.",
        evidence=f"Worst on joint {joint}: {shown}. The band "
        f"holds {100 * held.min():.0f} % on joint {least}.",
        drawing=bars(ratios(errors)),
        caption="Error by joint; a full bar is the error of a constant current.",
        numbers=(
            stated(errors.loc[joint], "RMSE below 2 Hz", "A", f"joint {joint}", CONSTANT),
            Number("share in the 95 % band", 100 * float(held.min()), "%", f"joint {least}"),
        ),
    )


def _undetermined(results: Results) -> str:
    if results.tables["friction"].empty:
        return "No friction was fitted, so that currents are not predicted."
    if not results.with_role("validate"):
        return "No recording has the role validate, which would test the predicted currents."
    return "No validate recording tests the predicted currents: none moves without a load."
