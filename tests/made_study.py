"""A study of made-up tables, judged as the workflow judges it."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pandas as pd

from tests import made_tables
from ur5lib.judging.study import StudyTables
from ur5lib.records.codes import Found
from ur5lib.records.pushes import SmallestPush
from ur5lib.records.verdicts import Verdict
from ur5lib.report.results import Results
from ur5lib.steps.judge_study import Judged, judged
from ur5lib.study.model import Settings

EVERY_JOINT = "1 2 3 4 5 6"
COLUMNS = made_tables.COLUMNS | {  # and of steps
    "next_recordings": ["robot", "after", "force", "current", "mass", "worthwhile"],
    "changes": ["study", "topic", "name", "before", "after", "differs", "changed"],
    "repetition": ["robot", "quantity", "joint", "component", "floor", "error"],
    "pushes": ["robot", *(field.name for field in fields(SmallestPush))],
}
ROLES = {"fitted": "fit", "seen": "validate", "pushed": "contact"}
RESTING = {"fitted": None, "seen": None, "pushed": None}
JUDGED = Judged.__annotations__


def study(moving: dict[str, Any] | None = None, **tables: list[dict[str, Any]]) -> Results:
    """A judged study of one recording of each role, of 1000 frames; tables not given are empty."""
    joints = dict.fromkeys(ROLES, EVERY_JOINT) | (moving or {})
    tables["recordings"] = [
        {"recording": name, "duration_s": 60.0, "frames": 1000, "moving_joints": told}
        for name, told in joints.items()
    ]
    entries = [{"name": name, "robot": "ur5", "role": role} for name, role in ROLES.items()]
    entries[0]["file"] = "wave.csv"
    made = Results(
        {
            "study": "made",
            "title": "Made up",
            "recordings": entries,
            "settings": Settings().model_dump(),
        },
        {name: pd.DataFrame(tables.get(name), columns=known) for name, known in COLUMNS.items()},
        drawn=frozenset(ROLES),
    )
    return judged_anew(made)


def judged_anew(made: Results, **changed: Any) -> Results:
    """A study, changed and judged by its tables."""
    made = replace(made, **changed)
    own = {name: table for name, table in made.tables.items() if name not in JUDGED}
    found = judged(StudyTables(made.study, own, **kept(made)))._asdict()
    frames = {
        name: pd.DataFrame(
            [*map(vars, rows)], columns=[field.name for field in fields(get_args(JUDGED[name])[0])]
        ).replace("", np.nan)
        for name, rows in found.items()
    }
    return replace(made, tables=own | frames)


def kept(made: StudyTables) -> dict[str, Any]:
    """What the study says of its arms."""
    names = ("placeholders", "effort", "bearing", "loads")
    return {name: getattr(made, name) for name in names}


def verdicts_of(results: StudyTables, question: str) -> list[Verdict]:
    """The verdicts on a question."""
    return [row for row in judged(results).verdicts if row.question == question]


def state(results: StudyTables, question: str) -> tuple[str | None, str]:
    """State and reason of a question."""
    first = next(row for row in verdicts_of(results, question) if row.rank == 1)
    return first.state, first.reason


def finding(severity: str, code: Found = Found.LOST_FRAMES, count: int = 1, **more: Any) -> dict:
    row = {"recording": "seen", "device": "robot", "code": code, "finding": code.words}
    return row | {"severity": severity, "count": count, "detail": "why"} | more


def constant(joint: int, value: float, **more: Any) -> dict[str, Any]:
    """A torque constant, known as 10 ± 3 Nm/A, which the recordings determine."""
    row = {"robot": "ur5", "joint": joint, "parameter": "torque_constant", "value": value}
    row |= {"std_error": 0.5, "low": value - 1, "high": value + 1, "prior_share": 0.1}
    row |= {"known": 10.0, "known_std": 3.0, "determined": "yes", "contradicted": None}
    return row | {"use": "yes"} | more


REFUSED = {"determined": "no", "contradicted": 142.0, "use": "no", "reason": "contradicted"}
UNKNOWN = {"determined": "no", "prior_share": 0.8, "use": "no", "reason": "prior_only"}
FAR = {"reason": "far"}


def torques(errors: dict[str, float], recordings: tuple[str, ...] = ("seen",)) -> list[dict]:
    """Errors of link models beside a torque of 1 Nm, on every joint."""
    row = {"motion": "measured", "zero_mae": 2.0, "zero_mae_2hz": 1.0}
    return [
        row | {"recording": name, "model": model, "joint": joint, "mae": 2 * e, "mae_2hz": e}
        for name in recordings
        for model, e in errors.items()
        for joint in range(1, 7)
    ]


def predicted(
    error: float, held: float = 0.95, recording: str = "seen", factor: float = 1.0
) -> list[dict]:
    """Errors beside a constant current's of 1 A, on every joint."""
    row = {"model": "fitted", "recording": recording, "rmse_lowpassed": error, "coverage95": held}
    row |= {"band_factor95": factor, "zero_rmse_lowpassed": 1.0, "r2": 1 - error**2}
    return [row | {"joint": joint} for joint in range(1, 7)]


def touched(mae: float, recording: str = "pushed", **more: Any) -> list[dict]:
    """Errors of the force in contact, of 10 N along each axis."""
    row = {"recording": recording, "kind": "compensated", "estimate": "Fmap", "during": "contact"}
    row |= {"mae": mae, "mae_low": 0.8 * mae, "mae_high": 1.2 * mae, "mean_force": 10.0}
    row |= {"use": "yes"} | ({"use": "no", "reason": "fitted"} if recording == "fitted" else {})
    return [row | {"coverage95": 0.95, **more, "component": f"F{axis}"} for axis in "xyz"]


DOUBTED = {"use": "no", "reason": "sensor_bias"}


def sensed(*peaks: tuple[float, str], recording: str = "pushed") -> list[dict]:
    """Contacts at the sensor with their peaks [N] and fates, 10 s apart."""
    about = {"recording": recording, "estimate": "Fmap", "component": "norm"}
    return [
        about | {"peak": peak, "fate": fate, "start_s": 10.0 * k, "end_s": 10.0 * k + 1}
        for k, (peak, fate) in enumerate(peaks)
    ]


def rates(recording: str, alarms: float = 0.0, **more: Any) -> dict[str, Any]:
    """A recording's alarms a minute."""
    return {"recording": recording, "estimate": "Fmap", "alarms_per_min": alarms} | more


def push(motion: str, axis: str, value: float | None, **more: Any) -> dict[str, Any]:
    """The smallest push that trials find."""
    row = {"robot": "ur5", "motion": motion, "axis": axis, "value": value, "std_error": 1.0}
    row |= {"low": (value or 0.0) - 2, "high": (value or 0.0) + 2, "largest_tried": 100.0}
    return row | {"trials": 30, "seconds": 1.0, "basis": "unseen"} | more


PLACE = Path()
