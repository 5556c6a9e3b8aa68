"""A made-up study with every table that cards need, and every figure that a rule draws."""

import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from tests.conftest import PROJECT
from tests.made_study import (
    FAR,
    ROLES,
    UNKNOWN,
    constant,
    judged_anew,
    predicted,
    push,
    rates,
    sensed,
    study,
    torques,
    touched,
)
from ur5lib.force.estimators import UNGATED
from ur5lib.jobs.declared import every
from ur5lib.report.figures.house_style import save
from ur5lib.report.figures.traces import WRENCH_PANELS, Traces, draw_traces
from ur5lib.report.results import Results

RULES = [*PROJECT.glob("workflow/rules/*.smk"), *PROJECT.glob("ur5lib/topics/*/rules.smk")]
OWNERS = {"recording": "{recording}", "posture": "{recording}", "arm": "{robot}"}
DRAWN = re.compile(r'\bdrawn\(\s*"(.*?)",([^)]*)\)')
EVERY: dict[str, Any] = {
    "friction": [constant(1, 10.0), constant(2, 20.0, **FAR), constant(3, 5.0, **UNKNOWN)],
    "contact_errors": sensed((30.0, "found"), (20.0, "missed")),
    "force_mae": touched(4.0) + [row | {"estimate": UNGATED, "mae": 5.0} for row in touched(4.0)],
    "pushes": [push("at rest", "z", 93.0), push("fast", "x", 20.0)],
    "current_rmse": predicted(0.2),
    "torque_mae": torques({"A": 0.1, "B": 0.3}),
    "detection": [rates("pushed", contacts=2, force_class_n=5.0), rates("seen", 2.0)],
}


def figures() -> dict[str, list[str]]:
    """The figures that rules draw, by what each is drawn of: {recording}, {robot}, nothing."""
    found: dict[str, list[str]] = {}
    for path in RULES:
        for of, names in DRAWN.findall(path.read_text()):
            found.setdefault(of, []).extend(re.findall(r'"(\w+)"', names))
    for step in every():
        drawings = [Path(file).stem for file in step.writes.values() if file.endswith(".svg")]
        found.setdefault(OWNERS[step.of], []).extend(drawings)
    return found


def illustrated(folder: Path, **changed: Any) -> Results:
    """A judged study of EVERY table with all figures, which are of one drawing.

    changed: of the results, before these are judged.
    """
    time = np.linspace(0, 1, 50)
    series = {"force sensor": (np.outer(np.sin(time), np.ones(6)), "measured")}
    folder.mkdir(exist_ok=True)
    save(draw_traces(Traces(time, series), WRENCH_PANELS), folder / "one.svg")
    for of, names in figures().items():
        for owner in {"{recording}": [*ROLES], "{robot}": ["ur5"]}.get(of, [""]):
            (folder / owner).mkdir(exist_ok=True)
            for name in names:
                for suffix in (".svg", ".csv"):
                    shutil.copy(folder / f"one{suffix}", folder / owner / f"{name}{suffix}")
    moving_joint().to_csv(folder / "ur5" / "friction.csv", index=False)
    moving_joint().to_csv(folder / "ur5" / "residuals.csv", index=False)
    made = study(**EVERY)
    return judged_anew(replace(made, figures=folder), **changed)


def moving_joint() -> pd.DataFrame:
    """The numbers of figures of friction and residuals, of one joint."""
    position = np.linspace(-1, 1, 400)
    return pd.DataFrame(
        {
            "velocity of joint 1 [rad/s]": position,
            "friction measured, joint 1 [Nm]": np.sign(position),
            "friction fitted, joint 1 [Nm]": np.sign(position),
            "half of the 95 % band, joint 1 [Nm]": 0.1,
            "position of joint 1 [rad]": position,
            "residual of joint 1 [A]": 0.01 * position,
        }
    )
