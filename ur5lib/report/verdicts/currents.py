"""Whether friction and torque constants predict motor currents."""

import pandas as pd

from ur5lib.report.document import Number, Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import bars
from ur5lib.report.verdicts.errors import (
    by_joint,
    largest,
    on_recording,
    percent,
    ratios,
    stated,
    stated_largest,
    with_range,
    worst,
)
from ur5lib.report.verdicts.states import HELD, state
from ur5lib.report.views.currents import unseen

TOPIC = "Friction and currents"
CONSTANT = "a constant current"


def verdict(results: Results) -> Verdict:
    """Judge the prediction by its worst joint, and its band by where it holds least."""
    rows = unseen(results)
    rows = rows[rows["model"] == "fitted"]
    errors = by_joint(rows, "rmse_2hz", "zero")
    if errors.empty:
        return Verdict(TOPIC, "not determined", _undetermined(results))
    joint, most = worst(errors), largest(rows, "rmse_2hz", "zero")
    least = rows.loc[rows["coverage95"].idxmin()]
    held = float(least["coverage95"])
    shown = with_range(errors.loc[joint], 2, "A", zero=CONSTANT)
    bands = "hold" if held >= HELD else "are too narrow"
    return Verdict(
        topic=TOPIC,
        state=state(errors["error"][joint], errors["zero"][joint], held),
        sentence="On recordings that no fit has seen, predicted motor currents err by "
        f"{percent(errors, joint)} of a constant current's error on joint {joint} (the worst), "
        f"and their 95 % bands {bands}.",
        evidence=f"Joint {joint}: {shown}. "
        f"{on_recording(most, 2, 'A', 'on joint', CONSTANT)} "
        f"The band holds least on joint {least['joint']} on {least['recording']}: "
        f"{100 * held:.0f} %.",
        drawing=bars(ratios(errors)),
        caption="Error by joint; a full bar is the error of a constant current.",
        numbers=(
            stated(errors.loc[joint], "RMSE below 2 Hz", "A", f"joint {joint}", CONSTANT),
            stated_largest(most, "A", f"joint {most['place']}", CONSTANT),
            Number("least share in the 95 % band", 100 * held, "%", _place(least)),
        ),
    )


def _place(row: pd.Series) -> str:
    return f"joint {row['joint']} on {row['recording']}"


def _undetermined(results: Results) -> str:
    if results.tables["friction"].empty:
        return "No friction was fitted, so that currents are not predicted."
    if not results.with_role("validate"):
        return "No recording has the role validate, which would test the predicted currents."
    return "No validate recording tests the predicted currents: none moves without a load."
