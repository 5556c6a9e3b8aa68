"""How close the motion from encoders is to an IMU."""

from ur5lib.report.document import Verdict
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.verdicts.errors import AgainstBaseline, by_joint, largest

TOPIC = "Motion"
UNITS = {True: "rad/s²", False: "m/s²"}  # by whether a component is angular


def verdict(results: Results) -> Verdict | None:
    """Judge the acceleration from encoders by its worst component; None without an IMU."""
    rows = results.rows("acceleration_mae", estimate="encoders")
    errors = by_joint(rows, "mae", "zero_mae", "component")
    if errors.empty:
        return None
    component = str((errors["error"] / errors["zero"]).idxmax())
    unit = UNITS[component.startswith("r")]
    largest_error = largest(rows[rows["component"] == component], "mae", "zero_mae", "component")
    against = AgainstBaseline(errors, largest_error, unit, 3, "along")
    words = {"component": component, "percent": against.percent(), "shown": against.shown()}
    return Verdict(
        topic=TOPIC,
        state=against.state(),
        sentence=say("motion.verdict", **words),
        evidence=say("motion.evidence", largest=against.largest_shown(), **words),
        drawing=against.drawing(),
        caption=say("motion.caption"),
        numbers=against.numbers("mean absolute error"),
    )
