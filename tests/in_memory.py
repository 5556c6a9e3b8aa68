"""Recordings in a folder for the library in memory, and a study's results beside what it gives."""

import json
import shutil
from functools import cache
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pandas as pd

import ur5lib
from ur5lib.chain.model import FIGURES, TABLES
from ur5lib.jobs.memory import text_of
from ur5lib.report.figures.house_style import Drawing, save
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import read_csv

FREE = ["free1.csv", "free2.csv"]
DOTS = (("velocity", "rad/s"), ("measured", "Nm"))  # of the figure of friction
PUSH = {"kind": "push", "start_s": 3, "seconds": 2, "force": [40, 0, 0]}


def put_recordings(folder: Path) -> None:
    """Put free1.csv, free2.csv and pushed.csv of a simulated UR5e into a folder: at 125 Hz, as a
    client of RTDE may ask for.
    """
    for name in (*FREE, "pushed.csv"):
        shutil.copy(Path(simulated().name) / name, folder)


@cache
def simulated() -> TemporaryDirectory[str]:
    """A folder with these recordings, which each process simulates once."""
    kept, arm = TemporaryDirectory(), load_robot(robot_path("ur5e"))
    for name, draw, more in (
        ("free1", 4, {}),
        ("free2", 7, {"posture": [-0.4, -1.2, 1.3, -1.2, 1.2, -0.5]}),
        ("pushed", 9, {}),
    ):
        plan: dict[str, Any] = {
            "trajectory": {"kind": "fourier", "draw": draw, "period_s": 12, "harmonics": 6} | more,
            "seed": draw,
        }
        if name == "pushed":
            plan["contacts"] = [PUSH]
        place = Path(kept.name) / name
        simulate(arm, SimulatedRecording.model_validate(plan), "rtde-csv", place, place / "truth")
        pd.read_csv(place / "robot.csv")[::4].to_csv(f"{place}.csv", index=False)
    return kept


def assert_as_in_study(
    runs: ur5lib.Recordings, model: ur5lib.Model, results: Path, *names: str
) -> None:
    """A study read and fitted in memory states what its report does, to the last bit.

    names: recordings whose currents and forces are estimated.
    """
    study = ur5lib.load(results)
    built = study.model(runs.robot)
    for name, text in model._arm.items():
        if name != "threshold":  # the published estimates have theirs, too
            assert text == Path(built._arm[name]).read_text(), name
    own, all_of_study = (json.loads(text_of(one._arm["threshold"])) for one in (model, built))
    assert own.items() <= all_of_study.items()
    for name in TABLES:
        table = study.table(name)
        reported = table[table["robot"] == runs.robot].reset_index(drop=True)
        pd.testing.assert_frame_equal(model.table(name), reported, check_exact=True)
    drawn = read_csv(results / "figures" / runs.robot / "friction.csv")
    for joint, axis in enumerate(model.plot("friction").axes, start=1):
        dots = drawn[[f"{name}, joint {joint} [{unit}]" for name, unit in DOTS]]
        np.testing.assert_allclose(axis.lines[0].get_xydata(), dots, rtol=1e-5)
    errors = study.table("current_rmse")
    for name in names:
        pd.testing.assert_frame_equal(
            model.estimate(runs[name]), study.forces(name), check_exact=True
        )
        found, stated = model.predict(runs[name]), study.currents(name)
        same = [*found.columns.intersection(stated.columns)]
        assert len(same) == 18
        pd.testing.assert_frame_equal(found[same], stated[same], check_exact=True)
        rows = errors[errors["recording"] == name].reset_index(drop=True)
        scored = model.score(runs[name]).drop(columns="nrmse")
        pd.testing.assert_frame_equal(scored, rows, check_exact=True)


def assert_draws_as_in_report(results: Path, folder: Path) -> None:
    """The models of all arms of a built study draw each figure as its report does, to the last bit.

    folder: for what is drawn.
    """
    study = ur5lib.load(results)
    arms = sorted(path.name for path in (results / "parameters").iterdir())
    for arm, name in product(arms, FIGURES):
        drawn = folder / f"{arm}_{name}.svg"
        save(Drawing(study.model(arm).plot(name), pd.DataFrame()), drawn)
        assert drawn.read_bytes() == (results / "figures" / arm / f"{name}.svg").read_bytes(), name
