"""Efforts of each kind given to a live estimate of each: taken, refused or undecided.

Of each recording of an arm of a built study that moves for two seconds, until it has; its friction
is that of the fit without the recording's path. Torques are currents times the documented
constants, each up to 10 % off, with or without gravity; an arm that was identified by torques has
these constants in its fit.
"""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.harness.options import arm_options, built
from benchmarks.live import learned_on, of
from ur5lib.records.measured import Measured
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.live.arm_file import with_input
from ur5lib.topics.live.live import KINDS, LONGEST_MOTION, Live
from ur5rivals.run import Run
from ur5rivals.study import read_arms

OFF = 0.1  # relative error of a documented constant, at most
UNDECIDED = "undecided"


def main() -> None:
    """Print how often each kind was taken, refused, or undecided, by the arm's kind."""
    given = arm_options(__doc__).parse_args()
    [folder] = built([Path("results") / given.study])
    [arm] = [own for own in read_arms(folder) if own.robot == given.robot]
    runs = [run for run in [*arm.fit, *arm.free, *arm.sensed] if run.measured is not None]
    known = learned_on(arm.fit[:3] if given.quick else arm.fit)
    rows = [
        (*case, run.name)
        for run in (runs[:1] if given.quick else runs)
        for case in decisions(run, known)
    ]
    report(pd.DataFrame(rows, columns=["identified by", "given", "decision", "recording"]))


def report(rows: pd.DataFrame) -> None:
    """Print the number of recordings by case and decision, and which are undecided."""
    case = [rows["identified by"], rows["given"]]
    print(pd.crosstab(case, rows["decision"]).to_string())
    fits = (rows["identified by"] == rows["given"]).map({True: "right", False: "wrong"})
    print(pd.crosstab(fits.rename("given"), rows["decision"]).to_string())
    undecided = rows[rows["decision"] == UNDECIDED]["recording"].value_counts()
    names = ", ".join(f"{name} ({count} of 9)" for name, count in undecided.items())
    print(f"undecided: {names or 'none'}; of {rows['recording'].nunique()} recordings")


def decisions(run: Run, known: dict[str, Any]) -> list[tuple[str, str, str]]:
    """The arm's kind, the given one, and the decision, of all nine cases of a recording."""
    arm, measured = of(run)
    assert run.arm is not None
    files = {kind: with_input({**arm, **known}, run.arm.robot, kind) for kind in KINDS}
    off = 1 + OFF * np.random.default_rng(0).uniform(-1, 1, measured.q.shape[1])
    for kind in (*KINDS,)[1:]:
        files[kind]["torque_constant"] = (files[kind]["torque_constant"] / off).tolist()
        files[kind]["current"] = (files[kind]["current"] * off).tolist()
    constants = off * files["current"]["motor_constant"]
    efforts = efforts_of(measured, constants, Live(files["current"]))
    found = [
        (own, kind, decision(Live(file), measured._replace(current=given)))
        for own, file in files.items()
        for kind, given in efforts.items()
    ]
    return [(own, kind, word) for own, kind, word in found if word]


def efforts_of(run: Measured, constants: Array, arm: Live) -> dict[str, Array]:
    """Currents [A], torques [Nm], and torques less gravity [Nm] (N, n) of a recording."""
    torque = constants * run.current
    gravity = arm.sweep(run.q, 0 * run.q).gravity
    return {"current": run.current, "torque": torque, "torque_less_gravity": torque - gravity}


def decision(arm: Live, run: Measured) -> str:
    """Whether the estimator takes or refuses a recording's efforts within its first two seconds of
    motion, "" if it has less.
    """
    assert arm.efforts is not None
    velocities = [None] * len(run.q) if run.qd is None else run.qd
    for sample in zip(run.time, run.q, velocities, run.current, strict=True):
        arm.step(*sample)
        if arm.refused or arm.efforts.fit:
            return "refused" if arm.refused else "taken"
        if arm.efforts.motion >= LONGEST_MOTION:
            return UNDECIDED
    return ""


if __name__ == "__main__":
    main()
