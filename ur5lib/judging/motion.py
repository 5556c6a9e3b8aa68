"""Accelerations from the encoders, compared with an IMU."""

from collections.abc import Iterator

from ur5lib.judging.errors import Conditions, by_place, judged, verdicts
from ur5lib.judging.study import StudyTables
from ur5lib.records.verdicts import JudgedError, Verdict

QUESTION = "motion"
UNITS = {"linear": "m/s²", "angular": "rad/s²"}


def errors(study: StudyTables, robot: str) -> list[JudgedError]:
    """Return the errors of the acceleration from encoders by component, compared with filterpy's
    plain smoother.
    """
    methods = study.tables["acceleration_mae"]
    methods = methods.assign(error=methods["mae"], zero=methods["zero_mae"])
    rows = methods[methods["estimate"] == "encoders"]
    if rows.empty:
        return []
    table = by_place(rows, "component")
    plain = methods[methods["estimate"] == "filterpy"].groupby("component")["error"].mean()
    table["rival"], table["rival_error"] = "filterpy's plain smoother", plain.reindex(table.index)
    turns = table.index.str.startswith("r")
    kinds = {"angular": table[turns], "linear": table[~turns]}
    return [
        one
        for kind, part in kinds.items()
        for one in judged(QUESTION, robot, UNITS[kind], part, Conditions())
    ]


def judge_motion(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Judge the acceleration from encoders by component; nothing without an IMU."""
    found = [one for one in errors(study, robot) if one.state != "not determined"]
    if found:
        count = max(one.recordings for one in found)
        interval = f"range over {count} recordings"
        cutoff = study.study["settings"]["lowpass"]["accelerations"]["cutoff_hz"]
        quantity = f"mean absolute error below {cutoff:g} Hz"
        yield from verdicts(found, quantity, interval, arm=robot, basis="unseen")
