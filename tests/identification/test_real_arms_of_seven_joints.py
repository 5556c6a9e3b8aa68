"""Sensed torques of a real Rokae xMate and KUKA LBR Med are predicted by fits to other parts."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import shared_folder
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import identify, prior_width, stack
from ur5lib.identification.current_samples import ZeroPhaseLowpass
from ur5lib.identification.measured_torques import FittedArm, fit_arm
from ur5lib.identification.samples import CurrentSamples
from ur5lib.identification.torque_rows import MeasuredRun
from ur5lib.robots.description import Robot
from ur5lib.smoothing.encoders import SmoothedMotion, smooth_encoders
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.lowpass import zero_phase_lowpass

pytestmark = pytest.mark.slow

JOINTS, RATE, CUTOFF = 7, 100, (4, 10.0)  # samples a second that remain; order and Hz
MASSES = (4.0, 4.0, 3.0, 3.0, 2.0, 1.5, 0.5)  # kg: guesses, around which the prior is
# lengths [m] and angles between axes [degrees] as the scripts of the recordings' repositories have
XMATE = (0.3415, 0, 0.394, 0, 0.366, 0, 0.2503), (-90, 90, -90, 90, -90, 90, 0)
MED = (0.34, 0, 0.4, 0, 0.4, 0, 0.126), (-90, 90, 90, -90, -90, 90, 0)
NO_LABELS = np.zeros(100_000, np.int64)
WEIGHT = 30.0  # kg, about that of both arms
REST = 644  # first samples of the KUKA, at rest


@dataclass(frozen=True)
class Recorded:
    """A recording of an arm: period [s], torque (N, 7), and its motion, smoothed."""

    robot: Robot
    period: float
    torque: Array
    motion: SmoothedMotion

    @classmethod
    def of(cls, robot: Robot, period: float, q: Array, qd: Array, torque: Array) -> "Recorded":
        motion = smooth_encoders(period * np.arange(len(q)), NO_LABELS[: len(q)], q, qd)
        return cls(robot, period, torque, motion)


@pytest.fixture(scope="module")
def recordings() -> Path:
    return shared_folder("seven-joints", "they are a Rokae's and a KUKA's recordings")


@pytest.fixture(scope="module")
def xmate(recordings: Path) -> Recorded:
    names = (f"excit_{name}_record.txt" for name in ("ang", "vel", "torque"))
    data = [np.loadtxt(recordings / "rokae-xmate7" / name) for name in names]
    return Recorded.of(guessed(*XMATE), 0.001, *data)


@pytest.fixture(scope="module")
def med(recordings: Path) -> Recorded:
    """Nobody noted the 10 ms between its samples."""
    table = pd.read_csv(recordings / "kuka-lbr-med" / "measurements.csv")
    q, torque = (table.filter(regex=rf"^{name}_\d").to_numpy() for name in ("q", "tau"))
    return Recorded.of(guessed(*MED), 0.01, q, np.gradient(q, 0.01, axis=0), torque)


def test_torques_of_an_xmate_are_predicted(xmate: Recorded) -> None:
    """The second half by the first, within a tenth of what a constant leaves."""
    count = len(xmate.torque)
    ours, constant = errors(xmate, np.arange(count) * 2 // count, [1])
    assert ours < 0.1 * constant


def test_torques_of_a_kuka_are_predicted(med: Recorded) -> None:
    """Each fifth of the motion by the rest."""
    moved = np.arange(len(med.torque)) - REST
    fifth = np.where(moved < 0, -1, moved * 5 // moved[-1]).clip(-1, 4)
    ours, constant = errors(med, fifth, range(5))
    assert ours < 0.1 * constant


def fitted_arm(recorded: Recorded) -> FittedArm:
    """As of an arm whose links are unknown, but for their weight."""
    motion, torque = recorded.motion, recorded.torque
    moved = motion.q, motion.motor_qd, 0 * torque, torque
    samples = CurrentSamples("run", recorded.period, NO_LABELS[: len(torque)], *moved)
    regressor = LinkModel(recorded.robot, "guess").regressor
    known = recorded.robot.model_copy(update={"weight": WEIGHT})
    return fit_arm(known, [MeasuredRun(samples, motion.qdd, regressor)], ZeroPhaseLowpass(*CUTOFF))


def test_no_counterbalance_is_invented(xmate: Recorded) -> None:
    assert fitted_arm(xmate).balanced == []


def test_torques_of_the_opposite_sign_are_no_bodies(med: Recorded) -> None:
    """Those of the KUKA are the links' on its motors, and no counterbalance is taken for it."""
    with pytest.raises(RefusalError, match="foreign bodies"):
        fitted_arm(med)
    assert fitted_arm(replace(med, torque=-med.torque)).balanced == []


def errors(recorded: Recorded, part: Labels, judged: Sequence[int]) -> tuple[float, float]:
    """Mean absolute error [Nm] in the parts judged, of fits to the other parts, and of a constant.

    part (N,): a label, negative where samples are only fitted to.
    """
    motion, period = recorded.motion, recorded.period
    model, every = LinkModel(recorded.robot, "guess"), max(1, round(1 / RATE / period))
    columns = model.regressor(motion.q, motion.motor_qd, motion.qdd)
    columns = np.concatenate([columns, friction_columns(motion.motor_qd)], axis=2)
    columns, torque = (slow(values, period)[::every] for values in (columns, recorded.torque))
    part = part[::every]
    residual = torque.copy()
    for own in judged:
        residual[part == own] -= columns[part == own] @ fitted(
            model, columns[part != own], torque[part != own]
        )
    rows = np.isin(part, judged)
    constant = torque[rows] - torque[rows].mean(axis=0)
    return float(np.abs(residual[rows]).mean()), float(np.abs(constant).mean())


def fitted(model: LinkModel, columns: Array, torque: Array) -> Array:
    """Parameters of links, rotors, offsets, Coulomb and viscous friction; blocks of 0.5 s."""
    others = columns.shape[2] - len(model.parameters)
    prior = np.append(model.parameters, np.zeros(others))
    width = np.append(3 * prior_width(len(model.parameters)), np.full(others, 50.0))
    blocks = np.array_split(np.arange(len(torque)), len(torque) // 50)
    return identify(stack((columns[own], torque[own]) for own in blocks), prior, width).parameters


def friction_columns(qd: Array) -> Array:
    """Offset, Coulomb and viscous friction (N, 7, 21) of each joint."""
    terms = np.stack([np.ones_like(qd), np.tanh(qd / 0.01), qd], axis=-1)
    return (terms[:, :, None] * np.eye(JOINTS)[..., None]).reshape(*qd.shape, -1)


def slow(values: Array, period: float) -> Array:
    flat = values.reshape(len(values), -1)
    return zero_phase_lowpass(flat, 1 / period, *CUTOFF).reshape(values.shape)


def guessed(offsets: tuple[float, ...], turns: tuple[int, ...]) -> Robot:
    """An arm of known axes whose links are guesses."""
    axes = zip(offsets, np.deg2rad(turns), strict=True)
    links = {
        "description": "",
        "centers_of_mass": [[0.0] * 3] * JOINTS,
        "inertias": [[0.01] * 3 + [0.0] * 3] * JOINTS,
    }
    return Robot.model_validate(
        {
            "name": "guessed",
            "gravity": (0, 0, -9.81),
            "denavit_hartenberg": [{"a": 0.0, "d": d, "alpha": turn} for d, turn in axes],
            "joints": ["any"] * JOINTS,
            "motors": {"any": {"position_max": 3.0, "velocity_max": 3.0, "torque_max": 200.0}},
            "masses": MASSES,
            "models": {"guess": links},
            "chosen_model": "guess",
        }
    )
