"""Estimates from the virtual test stand by seed, and the coverage of their intervals.

Three recordings to fit are simulated for each seed, and one that is pushed; motion, posture and
all noise are drawn anew, and files are read as real ones are. Counted are, for each quantity, the
values whose 95 % interval contains the truth, and the largest error; of the contact wrench the
share inside its 95 % band and the error, beside that of an estimate of zero, over whole recordings
and while in contact.
"""

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch
from ur5lib.pipeline.current_record import smoother
from ur5lib.pipeline.left_over import left_over

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import joint_states
from ur5lib.force.residual_model import ResidualModel, Stretch, few_paths, fit_residual_model
from ur5lib.force.wrench_estimate import estimate_wrench
from ur5lib.identification.currents import (
    CurrentFit,
    breakaway_torque,
    fit_currents,
    fit_without_each_path,
    parameters,
    predict,
    torque_constants,
)
from ur5lib.identification.prior import Prior
from ur5lib.identification.rotor_inertia import fit_rotor_inertia
from ur5lib.identification.samples import Record, record_paths
from ur5lib.pipeline.current_prior import controllers_ratio, prior_of
from ur5lib.recordings.intake import read_and_repair
from ur5lib.report import truth_table
from ur5lib.report.truth_table import Row
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.signals.device_clock import device_clock
from ur5lib.signals.imu_calibration import calibrate
from ur5lib.signals.imu_record import imu_record
from ur5lib.signals.resampling import resample
from ur5lib.signals.smoothing import smooth_encoders
from ur5lib.stand.plan import POSTURE, SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.tables import WRENCH, channel, labelled, named, read_json, read_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken

SEEDS, SECONDS = 20, 20.0
ORDER, CUTOFF = 4, 2.0  # of low-passes, as in the settings' defaults
MOTION = {"kind": "fourier", "period_s": 20, "harmonics": 10}  # as the default study's fast ones
PUSHES = [
    {"kind": "push", "start_s": start, "seconds": 2, "force": force}
    for start, force in ((3, [40, 0, 0]), (7, [0, -40, 0]), (11, [0, 0, 40]), (15, [20, 20, 20]))
]


def main() -> None:
    """Print how many intervals contain the truth, and the coverage of the wrench's band."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("seeds", nargs="?", type=int, default=SEEDS, help="how many, from 0 on")
    options.add_argument("--quick", action="store_true", help="short: only shows that it runs")
    given = options.parse_args()
    seeds, length = (1, 5.0) if given.quick else (given.seeds, SECONDS)
    torch.set_num_threads(1)
    rows = pd.DataFrame([row for seed in range(seeds) for row in recovered(seed, length)])
    print(f"{seeds} seeds, 3 recordings to fit of {length:g} s each and a pushed one")
    for quantity, part in rows.groupby("quantity", sort=False):
        off = (part["estimate"] - part["truth"]).abs()
        if part["within95"].notna().all():
            inside = part["within95"] == "yes"
            print(
                f"{quantity:>28}: {inside.sum():>4} of {len(part):>4} intervals hold the truth "
                f"({inside.mean():.0%}), largest error {off.max():.2g} {part['unit'].iloc[0]}"
            )
    wrench = rows[rows["quantity"].str.contains("coverage|rmse")]
    mean = wrench.pivot_table(["estimate", "zero"], ["quantity", "index"], sort=False)
    print(mean.to_string(float_format="%.3g"))


@dataclass(frozen=True)
class Taken:
    """A simulated recording: signals, the IMU's readings and start, and the truth."""

    robot: Robot
    signals: pd.DataFrame
    imu: pd.DataFrame
    start: Any
    summary: dict[str, Any]
    truth: pd.DataFrame

    @cached_property
    def kinematics(self) -> tuple[Array, Array, Array]:
        """Return R_6, o_6 and J_g at the measured positions."""
        return flange_kinematics(self.robot, channel(self.signals, "actual_q"))

    @cached_property
    def record(self) -> Record:
        """Return smoothed motion, its torque under the true model, and the measured current."""
        time, segment = (self.signals[name].to_numpy() for name in ("time", "segment"))
        measured = (channel(self.signals, f"actual_{name}") for name in ("q", "qd", "current"))
        q, qd, current = measured
        motion = smooth_encoders(time, segment, q, qd)
        states = motion.q, motion.qd, motion.qdd
        torque = torque_of(self.robot, self.summary["model"], states)
        step = float(np.median(np.diff(time)))
        name = f"seed {self.summary['plan']['seed']}"
        return Record(name, step, segment, motion.q, motion.qd, torque, current)


def taken(plan: dict[str, Any]) -> Taken:
    """Simulate a recording, and read it like a real one."""
    robot = load_robot(robot_path("ur5"))
    wanted = SimulatedRecording.model_validate(plan | {"imu": {}})
    with tempfile.TemporaryDirectory() as folder:
        truth = f"{folder}/truth"
        simulate(robot, wanted, "thesis-csv", Path(folder), Path(truth))
        intake = read_and_repair({"format": "thesis-csv", "folder": folder}, robot, 0.1)
        known = read_json(f"{truth}.json"), read_table(f"{truth}.parquet")
    return Taken(
        robot, intake.robot, intake.sensors["imu"], intake.quality["starts"]["imu"], *known
    )


def plans(seed: int, seconds: float = SECONDS) -> list[dict[str, Any]]:
    """Return plans of three recordings to fit and one with pushes, each around another posture."""
    drawn = []
    for draw in range(100 * seed, 100 * seed + 4):
        posture = POSTURE + np.random.default_rng(draw).uniform(-0.4, 0.4, 6)
        trajectory = MOTION | {"draw": draw, "posture": posture.tolist()}
        drawn.append({"trajectory": trajectory, "seed": draw, "seconds": seconds})
    return [*drawn[:3], drawn[3] | {"contacts": PUSHES}]


def recovered(seed: int, seconds: float = SECONDS) -> Iterator[Row]:
    """Yield rows of all estimates and the truth, from the recordings of one seed."""
    *fitted, pushed = (taken(plan) for plan in plans(seed, seconds))
    yield from device_rows(fitted)
    yield from map_rows(fit := fitted_map(fitted), fitted[0].summary)
    yield from pushed_rows(fit, fitted, pushed)


def device_rows(fitted: list[Taken]) -> Iterator[Row]:
    """Yield rows of clocks, rotor inertias and the IMU."""
    robot, summary = fitted[0].robot, fitted[0].summary
    clocks = [
        device_clock(own.imu, own.start, own.signals, *own.kinematics[::2])[0] for own in fitted
    ]
    for clock, own in zip(clocks, fitted, strict=True):
        yield from truth_table.clock_rows({"imu": asdict(clock)}, own.summary)
    true = robot.models[summary["model"]].rotor_inertias
    yield from truth_table.rotor_rows(rotors(robot, fitted), true)
    calibration = calibrate([*map(imu_of, fitted, clocks)])
    yield from truth_table.imu_rows(asdict(calibration), summary["plan"]["imu"])


def map_rows(fit: CurrentFit, truth: dict[str, Any]) -> Iterator[Row]:
    """Return rows of torque constants and friction."""
    return truth_table.friction_rows({"parameters": [*map(asdict, parameters(fit))]}, truth)


def torque_of(robot: Robot, model: str, states: Any) -> Array:
    """Return the torque (N, 6) [Nm] of a model at q, q̇, q̈ (N, 6)."""
    arm = build_arm(robot, model)
    return inverse_dynamics(arm, *(torch.from_numpy(state.copy()) for state in states)).numpy()


def rotors(robot: Robot, recordings: list[Taken]) -> dict[str, Any]:
    """Fit rotor inertias to the controller's torque minus that of rigid links at the targets."""
    parts = []
    for own in recordings:
        states = [channel(own.signals, f"target_{name}") for name in ("q", "qd", "qdd")]
        rigid = torque_of(robot, robot.chosen_model, states)
        parts.append((channel(own.signals, "target_moment") - rigid, states[1], states[2]))
    fit = fit_rotor_inertia(*zip(*parts, strict=True))
    parts_of_fit = {"value": fit.value._asdict(), "std_error": fit.std_error._asdict()}
    return {"from": recordings} | parts_of_fit


def imu_of(own: Taken, clock: Any) -> Any:
    """Return the samples of a recording's IMU and joints for the calibration."""
    rotation, _, jacobian = own.kinematics
    read = resample(own.imu, clock, own.signals["time"].to_numpy())
    kinematics = pd.DataFrame(named(rotation, "R6") | named(jacobian, "J"))
    signals = pd.concat([own.signals, read], axis="columns")
    place = np.array(own.robot.mounting.imu), np.array(own.robot.gravity)
    return imu_record(signals, kinematics, *place, ORDER, CUTOFF)


def fitted_map(recordings: list[Taken]) -> CurrentFit:
    """Fit the map from motion to current."""
    records = [own.record for own in recordings]
    return fit_currents(records, smoother(ORDER, CUTOFF), known(recordings))


def known(recordings: list[Taken]) -> Prior:
    """Return the prior of the torque constants."""
    ratios = [controllers_ratio(own.signals, own.record.qd) for own in recordings]
    return prior_of(recordings[0].robot, ratios)


def residuals(fit: CurrentFit, free: list[Taken]) -> ResidualModel:
    """Fit the residual model to torques predicted by fits without the path (`fit_residuals`)."""
    records = [own.record for own in free]
    unseen = fit_without_each_path(records, smoother(ORDER, CUTOFF), known(free))
    fits = {name: own for names, own in unseen for name in names}
    stretches = [
        Stretch(torque[rows], states[rows], own.period)
        for own in records
        for torque, states, segment in [external(fits[own.name], own)]
        for rows in unbroken(segment)
    ]
    model = fit_residual_model(stretches, CUTOFF, breakaway_torque(fit))
    return model.wider(few_paths(int(record_paths(records).max()) + 1))


def pushed_rows(fit: CurrentFit, free: list[Taken], pushed: Taken) -> Iterator[Row]:
    """Yield errors of F^map over all samples of a recording and over those in contact."""
    step = pushed.record.period
    torque, states, segment = external(fit, pushed.record)
    given = torque, pushed.kinematics[2], states, segment, step
    estimate = estimate_wrench(*given, residuals(fit, free), ContactPrior())
    columns = labelled(estimate.wrench, "Fmap", WRENCH) | labelled(estimate.std, "Fmap_std", WRENCH)
    forces, own = pd.DataFrame(columns), pushed.truth["time"].to_numpy()
    true = pushed.truth.filter(like="wrench").apply(
        lambda column: np.interp(pushed.signals["time"], own, column), result_type="expand"
    )
    touched = (true != 0).any(axis="columns")
    for rows, when in ((touched | True, ""), (touched, "_in_contact")):
        for row in truth_table.wrench_rows(forces[rows], true[rows]):
            yield row | {"quantity": f"{row['quantity']}{when}"}


def external(fit: CurrentFit, record: Record) -> tuple[Array, Any, Any]:
    """Return external torque [Nm], joint states and segments of a recording."""
    smooth = smoother(ORDER, CUTOFF)
    torque = left_over(record, predict(fit, record), torque_constants(fit), smooth, CUTOFF)
    return torque, joint_states(record.qd, record.segment, record.period), record.segment


if __name__ == "__main__":
    main()
