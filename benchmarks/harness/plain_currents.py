"""Predicted currents compared with a twenty-line rival: plain least squares with the root of the
velocity, and dry friction that reverses over four distances.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from benchmarks.harness.markdown import markdown
from benchmarks.harness.torque_models import MEMORIES, RIDGE
from benchmarks.leave_out import Recording, Study, without_each
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.current_samples import (
    ZeroPhaseLowpass,
    controllers_ratio,
    current_record,
    prior_of,
)
from ur5lib.identification.currents import predict
from ur5lib.identification.samples import INDEPENDENT_STEP, CurrentSamples, smoothed_moving
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot
from ur5lib.timeseries.arrays import Array, Mask


def currents_table(study: Study, quick: bool) -> str:
    """Return a table of the RMSE [A] of low-passed currents on left-out paths and dates."""
    arm, smooth = load_robot(study.arm), ZeroPhaseLowpass(*study.lowpass)
    errors = []
    for _, fitted, tested in without_each(study)[: 1 if quick else None]:
        known = [sampled(own, arm) for own in fitted]
        unseen = [sampled(own, arm) for own in tested if own.entry["role"] == "fit"]
        records, ratios = zip(*known, strict=True)
        fit = fit_currents(records, smooth, prior_of(arm, ratios))
        for record, _ in unseen:
            ours = smooth(record.current - predict(fit, record), record)
            errors += [*squares(records, record, ours, smooth)]
    table = np.sqrt(pd.concat(errors).pivot_table("square", ["fit", "state"], "joint", sort=False))
    lines = [
        [*name, *(f"{own:.4f}" for own in line)]
        for name, line in zip(table.index, table.to_numpy(), strict=True)
    ]
    return markdown(["fit", "state", *map(str, table.columns)], lines)


def sampled(own: Recording, arm: Robot) -> tuple[CurrentSamples, Array]:
    """Return a recording's samples, and the controller's torque constants [Nm/A]."""
    signals = Signals.read(own.file("signals.parquet"))
    motion = Motion.read(own.file("motion.parquet"))
    torques = Torques.read(own.file("torques.parquet"))
    record = current_record(
        AlignedRecording(name=own.name, signals=signals, motion=motion, torques=torques), arm
    )
    assert record is not None
    return record, controllers_ratio(signals, motion, own.premises().contradictions.odd_targets())


def squares(
    fitted: Sequence[CurrentSamples], record: CurrentSamples, ours: Array, smooth: ZeroPhaseLowpass
) -> Iterator[pd.DataFrame]:
    """Yield the squared errors [A²] on a recording, by fit, state and joint."""
    for joint, own in enumerate(ours.T):
        columns, moving = rows(record, smooth, joint)
        left = {"ours": own[:: stride(record)]}
        for name, at_rest in (("least squares", False), ("least squares, at rest, too", True)):
            left[name] = columns[:, -1] - columns[:, :-1] @ plain(fitted, smooth, joint, at_rest)
        state = np.where(moving, "in motion", "at rest")
        for name, error in left.items():
            table = {"fit": name, "state": state, "joint": joint + 1, "square": error**2}
            yield pd.DataFrame(table).dropna()
            yield pd.DataFrame(table | {"state": "all"}).dropna()


def plain(
    fitted: Sequence[CurrentSamples], smooth: ZeroPhaseLowpass, joint: int, at_rest: bool
) -> Array:
    """Return the coefficients (P,) of plain least squares; at_rest: on samples at rest, too."""
    each = [rows(record, smooth, joint) for record in fitted]
    known = np.concatenate([columns[moving | at_rest] for columns, moving in each])
    known = known[np.isfinite(known).all(axis=1)]
    scale = np.sqrt((known[:, :-1] ** 2).mean(axis=0)) + 1e-12
    scaled = known[:, :-1] / scale
    normal = scaled.T @ scaled + RIDGE * len(known) * np.eye(len(scale))
    return np.linalg.solve(normal, scaled.T @ known[:, -1]) / scale


def rows(record: CurrentSamples, smooth: ZeroPhaseLowpass, joint: int) -> tuple[Array, Mask]:
    """Return low-passed columns and current (n, P + 1) of a joint, and whether it moves (n,)."""
    return record.once(("plain", joint), lambda: _rows(record, smooth, joint))


def _rows(record: CurrentSamples, smooth: ZeroPhaseLowpass, joint: int) -> tuple[Array, Mask]:
    motion, every = record.joint(joint), stride(record)
    states = [motion.direction_over(distance) for distance in MEMORIES]
    root = np.sqrt(np.abs(motion.qd)) * np.sign(motion.qd)
    load = np.abs(motion.torque) * motion.direction
    columns = [motion.torque, np.ones_like(root), motion.qd, root, load, *states]
    smoothed = smooth(np.column_stack([*columns, record.current[:, joint]]), record)
    return smoothed[::every], smoothed_moving(record, smooth)[::every, joint]


def stride(record: CurrentSamples) -> int:
    """Return the number of samples between independent ones."""
    return max(1, round(INDEPENDENT_STEP / record.period))
