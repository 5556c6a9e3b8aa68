"""Judge a recording without its sensor and its contacts: findings, and its rows of the tables."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ur5lib.checks import files
from ur5lib.checks.channels import slower_than_fit
from ur5lib.checks.succession import moved_between, stated_succession
from ur5lib.force.problem import unusual_friction
from ur5lib.force.residual_model import Residuals
from ur5lib.records.account import AccountRow
from ur5lib.records.codes import Found
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import (
    PATH_TIMES,
    JointPath,
    Judgement,
    LoadRow,
    TorqueError,
    by_joint,
    current_errors,
)
from ur5lib.records.motion import Alignment, Motion, posture_change
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import JudgedLoad, Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Finding, Quality
from ur5lib.records.signals import Signals, is_led, slowly
from ur5lib.records.step import step
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import mean_absolute_error


class Inputs(Opened):
    """What is read of a recording."""

    quality: Quality
    signals: Signals
    motion: Motion
    before: Mapping[str, Motion]
    alignment: Alignment
    torques: Torques
    premises: Premises
    currents: Currents
    prediction: Prediction


@step("recording", "judgement.json", before="previous")
def judge_recording(
    recording: Inputs, friction: Friction, residuals: Residuals, cutoff_hz: float
) -> Judgement:
    """Return the findings on one recording and its rows of the result tables.

    recording: with the motions of the recordings that it follows, if any; cutoff_hz: of the
    currents' low-pass [Hz].
    """
    quality, signals, motion = recording.quality, recording.signals, recording.motion
    clocks, prediction = recording.alignment.clocks, recording.prediction
    changes = {name: posture_change(own, motion) for name, own in recording.before.items()}
    moved = [one for name, own in changes.items() if (one := moved_between(name, own))]
    slower = slower_than_fit(
        signals.actual_q, signals.segment, signals.period, cutoff_hz, friction.period
    )
    share = unusual_friction(motion, recording.currents, residuals)
    doubts = [*slower, *moved] if share is None else [*slower, *moved, _unusual(share)]
    known = recording.premises.contradictions
    contradictions = replace(known, findings=[*known.findings, *doubts])
    return Judgement(
        findings=files.findings(quality, contradictions, clocks),
        recordings=[files.summary(quality, signals)],
        paths=[*joint_paths(motion.q)],
        files=files.files_read(quality),
        account=[*_account(quality, changes)],
        clocks=files.clock_rows(clocks),
        torque_mae=[*torque_errors(signals, recording.torques)],
        current_rmse=[*current_errors(prediction)],
        payload=[load_row(prediction.load)] if prediction.load else [],
    )


def _account(quality: Quality, changes: Mapping[str, Array]) -> Iterator[AccountRow]:
    """Yield the account of import, and the recording that this one follows, unless import states
    it.

    changes: (n,) [rad], of the posture since each earlier recording, by name.
    """
    yield from quality.account
    if "after" not in [row.subject for row in quality.account]:
        yield from (stated_succession(name, change) for name, change in changes.items())


def joint_paths(q: Array) -> Iterator[JointPath]:
    """Yield the path of each joint; q: (N, n) [rad]."""
    frames = np.flatnonzero(np.isfinite(q).all(axis=1))
    if not len(frames):
        return
    some = frames[np.linspace(0, len(frames) - 1, PATH_TIMES).astype(int)]
    for joint, angles in enumerate(q[some].T, start=1):
        yield JointPath(joint=joint, angles=" ".join(f"{angle:.2f}" for angle in angles))


def _unusual(share: float) -> Finding:
    """Return the warning for a recording without the usual friction; share: the part of that
    friction which its currents show.
    """
    detail = (
        f"the currents show {share:.0%} of the friction that such a motion usually has, as where a "
        "hand leads the arm; since nothing was fitted, its contact force cannot be told from that, "
        "and none is stated: record motion without contact with the role fit"
    )
    return Finding("robot", Found.UNUSUAL_FRICTION, "warning", 1, detail)


def torque_errors(signals: Signals, torques: Torques) -> Iterator[TorqueError]:
    """Yield the MAE of torques against `target_moment`, by motion and link model, whole and below 2
    Hz.

    With the MAE of zero torque; interpolated frames are left out.
    """
    if signals.target_moment is None or is_led(signals):
        return
    received = ~signals.interpolated
    moment = signals.target_moment[received]
    slow = slowly(signals.target_moment, signals)[received]
    zero = {
        "zero_mae": mean_absolute_error(np.zeros_like(moment), moment),
        "zero_mae_2hz": mean_absolute_error(np.zeros_like(slow), slow),
    }
    motions = {"target": torques.target, "measured": torques.measured}
    for model in torques.measured:
        for motion, known in motions.items():
            if model in known:
                errors = zero | {
                    "mae": mean_absolute_error(known[model][received], moment),
                    "mae_2hz": mean_absolute_error(slowly(known[model], signals)[received], slow),
                }
                for joint, values in by_joint(errors):
                    yield TorqueError(motion=motion, model=model, joint=joint, **values)


def load_row(load: JudgedLoad) -> LoadRow:
    """Return an undeclared load as a row of payload.csv."""
    low, high = load.interval
    places = {
        f"{name}_{axis}": float(value)
        for name in ("center_of_mass", "center_of_mass_std")
        for axis, value in zip("xyz", getattr(load, name), strict=True)
    }
    return LoadRow(
        mass=load.mass,
        std_error=load.std_error,
        low=low,
        high=high,
        configured=load.configured,
        taken=load.taken,
        **places,
    )
