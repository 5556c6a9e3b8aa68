"""How close the motion from encoders is to an IMU."""

from ur5lib.report.document import Verdict
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
from ur5lib.report.verdicts.states import state

TOPIC = "Motion"
UNITS = {True: "rad/s²", False: "m/s²"}  # by whether a component is angular


def verdict(results: Results) -> Verdict | None:
    """Judge the acceleration from encoders by its worst component; None without an IMU."""
    rows = results.rows("acceleration_mae", estimate="encoders")
    errors = by_joint(rows, "mae", "zero_mae", "component")
    if errors.empty:
        return None
    component = str(worst(errors))
    unit = UNITS[component.startswith("r")]
    shown = with_range(errors.loc[component], 3, unit)
    judged = state(errors["error"][component], errors["zero"][component])
    most = largest(rows[rows["component"] == component], "mae", "zero_mae", "component")
    return Verdict(
        topic=TOPIC,
        state=judged,
        sentence="The acceleration from the joint encoders differs from the IMU's by "
        f"{percent(errors, component)} of its mean size along {component}, the worst component.",
        evidence=f"Along {component}: {shown}. {on_recording(most, 3, unit, 'along')}",
        drawing=bars(ratios(errors)),
        caption="Error in x, y, z, rx, ry, rz; a full bar is the error of no acceleration.",
        numbers=(
            stated(errors.loc[component], "mean absolute error", unit, component),
            stated_largest(most, unit, component),
        ),
    )
