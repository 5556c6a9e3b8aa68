"""Torques of two real arms of seven joints: base parameters beside FIGAROH's, and friction.

    python -m benchmarks.seven_joints <folder>

The folder has `rokae-xmate7`: filtering/data/excit of
YanjunLIU-ac/Dynamic_Parameter_Identification_for_Rokae_xMate on GitHub, at d5855f4 (20 s at 1 kHz
with motor torques and joint-torque sensors), and `kuka-lbr-med`: src/test/measurements.csv of
lbr-stack/dynamic_parameter_identification, at 58b4d88 (torques without stamps). Each part of a
recording is predicted by a fit to its other parts: links, rotors, and each joint's offset, Coulomb
and viscous friction. Draws docs/seven_joints.svg, and tries intervals for the missing stamps.
Writes results/figaroh/xmate/ and results/figaroh/lbr-med/ for
`benchmarks/figaroh/identification.py`, whose answers are scored, too, where they lie there already.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import torch
from matplotlib.figure import Figure

from benchmarks.harness.options import options_of
from benchmarks.harness.prediction import FIGAROH
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.base_parameters import InertialEstimate, identify, prior_width, stack
from ur5lib.leaderboard.tables import markdown, number
from ur5lib.report.figures.house_style import LINE_STYLES
from ur5lib.robots.description import Robot
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.tables import write_text
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import DEAD_ZONE

CONSTANT, OURS, MOTOR, SEEN = "constant", "ours", "motor torque alone", "motor less sensor"
FOR_FIGAROH, DRAWING = Path("results/figaroh"), Path("docs/seven_joints.svg")
MASSES = (4.0, 4.0, 3.0, 3.0, 2.0, 1.5, 0.5)  # kg: guesses, around which the prior is
VAGUE = 3.0  # times the prior's width of an arm whose maker states its links
ANY = 50.0  # standard deviation of the prior of offsets and friction [Nm, Nm s/rad]
CREEP = 0.01  # rad/s, over which Coulomb friction reverses
CUTOFF, RATE, BLOCK = (4, 10.0), 100, 50  # order and Hz; samples a second that remain; samples
# lengths [m] and angles between axes [degrees] as the scripts of the recordings' repositories have
XMATE = (0.3415, 0, 0.394, 0, 0.366, 0, 0.2503), (-90, 90, -90, 90, -90, 90, 0)
MED = (0.34, 0, 0.4, 0, 0.4, 0, 0.126), (-90, 90, 90, -90, -90, 90, 0)
REST = 644  # first samples of the KUKA, at rest
DIGITS = 2
PERIOD, STILL = 0.01, 1e3  # s between its samples; so long that it hardly moves
INTERVALS = (0.005, PERIOD, 0.02, 0.05, STILL)


@dataclass(frozen=True)
class Log:
    """A recording without contact: smoothed motion and torques (N, 7), and labels (N,) of parts."""

    robot: Robot
    period: float
    q: Array
    qd: Array
    qdd: Array
    torque: Array
    part: Labels

    @cached_property
    def columns(self) -> Array:
        """Return Y (N, 7, P) of torques Y π: the links' and rotors' parameters, then `friction`."""
        links = self.model.regressor(self.q, self.qd, self.qdd)
        return self.slow(np.concatenate([links, by_joint(friction(self.qd))], axis=2))

    @property
    def model(self) -> LinkModel:
        """Return the arm's guessed links."""
        return LinkModel(self.robot, self.robot.chosen_model)

    @property
    def parts(self) -> Labels:
        """Return the labels of the samples that `slow` keeps."""
        return self.part[:: self._every]

    def slow(self, values: Array) -> Array:
        """Return samples (N, ...) behind the low-pass, RATE a second."""
        flat = values.reshape(len(values), -1)
        low = zero_phase_lowpass(flat, 1 / self.period, *CUTOFF)
        return low.reshape(values.shape)[:: self._every]

    @property
    def _every(self) -> int:
        return max(1, round(1 / RATE / self.period))


@dataclass(frozen=True)
class Motors:
    """An xMate's motors beside its sensors: motor torque = π [sensor, q̈, 1, Coulomb, viscous].

    estimate: of π (35,), five a joint, from the first half; torque: (N, 7) [Nm], behind the gear;
    friction: (N, 7) [Nm], that torque less sensor, rotor and offset.
    """

    estimate: InertialEstimate
    torque: Array
    friction: Array


def main() -> None:
    """Print errors, friction and what the interval between samples changes."""
    options = options_of(__doc__)
    options.add_argument("folder", type=Path, help="of the recordings")
    given = options.parse_args()
    torch.set_num_threads(1)
    sensed, motors = xmate(given.folder / "rokae-xmate7")
    alone = replace(sensed, torque=motors.torque)
    print("xMate, second half by a fit to the first, mean error [Nm]")
    print(errors(sensed, sensed.parts == 1, {MOTOR: left(alone)}))
    compared = friction_curves(sensed, motors, fitted(alone, sensed.parts == 0))
    print(friction_table(motors, compared))
    DRAWING.parent.mkdir(exist_ok=True)
    drawing(compared).savefig(DRAWING, metadata={"Date": None})
    file = given.folder / "kuka-lbr-med" / "measurements.csv"
    med = kuka(file)
    controllers = pd.read_csv(file).filter(like="tau_ext").to_numpy()
    print("LBR Med, each fifth of the motion by a fit to the rest, mean error [Nm]")
    print(errors(med, med.parts >= 0, {"controller": med.slow(controllers)}))
    print(intervals(med, INTERVALS[-1:] if given.quick else INTERVALS))


def xmate(folder: Path) -> tuple[Log, Motors]:
    """Return the xMate's recording with its sensors' torques, in halves, and its motors."""
    q, qd, sensor, motor = (
        np.loadtxt(folder / f"excit_{name}_record.txt")
        for name in ("ang", "vel", "torque", "motor")
    )
    half = np.arange(len(q)) * 2 // len(q)
    log = smoothed(seven("xmate", *XMATE), 0.001, q, qd, sensor, half)
    terms = np.dstack([sensor, log.qdd, friction(log.qd)])
    first = log.parts == 0
    wide = np.full(5 * len(MASSES), ANY)
    estimate = solved(log.slow(by_joint(terms))[first], log.slow(motor)[first], 0 * wide, wide)
    ratio, *others = estimate.parameters.reshape(-1, 5).T
    torque = motor / ratio
    rest = np.einsum("njm,mj->nj", terms[:, :, 1:3], others[:2] / ratio)
    return log, Motors(estimate, torque, torque - sensor - rest)


def kuka(file: Path) -> Log:
    """Return the KUKA's recording, its motion in five parts, with PERIOD between its samples."""
    table = pd.read_csv(file)
    q, torque = (table.filter(regex=rf"^{name}_\d").to_numpy() for name in ("q", "tau"))
    moved = np.arange(len(q)) - REST
    part = np.where(moved < 0, -1, moved * 5 // moved[-1].clip(1)).clip(-1, 4)
    qd = np.gradient(q, PERIOD, axis=0)
    return smoothed(seven("lbr-med", *MED), PERIOD, q, qd, torque, part)


def smoothed(robot: Robot, period: float, q: Array, qd: Array, torque: Array, part: Labels) -> Log:
    """Return a recording with its motion as the project smooths it."""
    time = period * np.arange(len(q))
    motion = smooth_encoders(time, np.zeros(len(q), np.int64), q, qd)
    return Log(robot, period, motion.q, motion.motor_qd, motion.qdd, torque, part)


def seven(name: str, offsets: tuple[float, ...], turns: tuple[int, ...]) -> Robot:
    """Return an arm of known axes whose links are guesses."""
    axes = zip(offsets, np.deg2rad(turns), strict=True)
    return Robot.model_validate(
        {
            "name": name,
            "gravity": (0, 0, -9.81),
            "denavit_hartenberg": [{"a": 0.0, "d": d, "alpha": turn} for d, turn in axes],
            "joints": ["any"] * len(MASSES),
            "motors": {"any": {"position_max": 3.0, "velocity_max": 3.0, "torque_max": 200.0}},
            "masses": MASSES,
            "models": {
                "guess": {
                    "description": "",
                    "centers_of_mass": [[0.0] * 3] * len(MASSES),
                    "inertias": [[0.01] * 3 + [0.0] * 3] * len(MASSES),
                }
            },
            "chosen_model": "guess",
        }
    )


def friction(qd: Array) -> Array:
    """Return the terms (..., 3) of velocities: offset, Coulomb and viscous friction."""
    return np.stack([np.ones_like(qd), np.tanh(qd / CREEP), qd], axis=-1)


def by_joint(terms: Array) -> Array:
    """Return columns (N, n, n M) of terms (N, n, M) that each joint has for its own."""
    own = terms[:, :, None] * np.eye(terms.shape[1])[..., None]
    return own.reshape(*terms.shape[:2], -1)


def solved(columns: Array, torque: Array, prior: Array, width: Array) -> InertialEstimate:
    """Return the estimate from blocks of half a second, which tell the standard errors."""
    parts = np.array_split(np.arange(len(torque)), len(torque) // BLOCK)
    return identify(stack((columns[part], torque[part]) for part in parts), prior, width)


def fitted(log: Log, rows: Mask) -> InertialEstimate:
    """Return the parameters of a recording's slow samples in a mask."""
    links = log.model.parameters
    others = log.columns.shape[2] - len(links)
    prior = np.append(links, np.zeros(others))
    width = np.append(VAGUE * prior_width(len(links)), np.full(others, ANY))
    return solved(log.columns[rows], log.slow(log.torque)[rows], prior, width)


def left(log: Log) -> Array:
    """Return the slow torques (N, 7) that fits to the other parts leave."""
    found = log.slow(log.torque)
    for part in np.unique(log.parts[log.parts >= 0]):
        own = log.parts == part
        found[own] -= log.columns[own] @ fitted(log, ~own).parameters
    return found


def errors(log: Log, judged: Mask, further: Mapping[str, Array]) -> str:
    """Return the mean absolute error [Nm] of each model and joint over the slow samples judged."""
    slow = log.slow(log.torque)
    models = {CONSTANT: slow - slow[judged].mean(axis=0), **figaroh(log), OURS: left(log)} | further
    table = pd.DataFrame({name: np.abs(own[judged]).mean(axis=0) for name, own in models.items()})
    table.index = [f"{k + 1}" for k in table.index]
    table.loc["mean"] = table.mean()
    cells = ([name, *(number(own, DIGITS) for own in row)] for name, *row in table.itertuples())
    return markdown(["joint", *table], cells)


def figaroh(log: Log) -> dict[str, Array]:
    """Return what FIGAROH leaves of the slow torques (N, 7); write what it needs."""
    folder = FOR_FIGAROH / log.robot.name
    folder.mkdir(parents=True, exist_ok=True)
    bodies = rigid_bodies(log.robot, log.robot.chosen_model)
    write_text(urdf(log.robot, bodies), folder / "arm.urdf")
    np.savez(
        folder / "samples.npz",
        **{name: getattr(log, name) for name in ("period", "q", "qdd", "torque")},
        qd=np.where(np.abs(log.qd) > DEAD_ZONE, log.qd, 0.0),
        stretch=np.zeros(len(log.q)),  # masked ends of parts would cost it more than jumps do
        path=log.part,
        fitted=np.ones(len(log.q), bool),
    )
    if not (folder / "predicted.npz").exists():
        print(f"{folder} has no predicted.npz; benchmarks/figaroh/identification.py writes it")
        return {}
    with np.load(folder / "predicted.npz") as found:
        return {title: log.slow(log.torque - found[key]) for key, title in FIGAROH.items()}


def friction_curves(log: Log, motors: Motors, alone: InertialEstimate) -> pd.DataFrame:
    """Return each joint's friction [Nm] over its speeds, with standard errors: as seen, as fitted
    to it in the first half, and as fitted there to motor torque alone.
    """
    count, parts = len(MASSES), []
    for joint in range(count):
        qd, seen = (values[log.part == 1, joint] for values in (log.qd, motors.friction))
        speed = np.linspace(*np.quantile(qd, (0.02, 0.98)), 24)
        near = np.abs(qd[:, None] - speed).argmin(axis=1)
        means = pd.Series(seen).groupby(near).mean().reindex(range(len(speed)))
        by_motor = of_terms(speed, alone, len(alone.parameters) - 3 * (count - joint) + 1)
        by_sensor = of_terms(speed, motors.estimate, 5 * joint + 3)
        inverse = motors.estimate.parameters[5 * joint]
        values = by_sensor @ motors.estimate.parameters / inverse
        by_sensor[:, 5 * joint] = -values  # of a quotient
        own = {
            "joint": joint + 1,
            "speed": speed,
            "seen": means,
            SEEN: values,
            f"{SEEN}, error": motors.estimate.standard_errors(by_sensor) / inverse,
            MOTOR: by_motor @ alone.parameters,
            f"{MOTOR}, error": alone.standard_errors(by_motor),
        }
        parts.append(pd.DataFrame(own))
    return pd.concat(parts)


def of_terms(speed: Array, estimate: InertialEstimate, first: int) -> Array:
    """Return the rows (N, P) of Coulomb and viscous friction, of which one is parameter `first`."""
    rows = np.zeros((len(speed), len(estimate.parameters)))
    rows[:, first : first + 2] = friction(speed)[:, 1:]
    return rows


def friction_table(motors: Motors, curves: pd.DataFrame) -> str:
    """Return friction at the largest speed with 95 % intervals, and how far curves are apart."""
    rows = []
    for joint, own in curves.groupby("joint"):
        last, inverse = own.iloc[-1], motors.estimate.parameters[5 * (joint - 1)]
        values = (f"{last[k]:.1f} ± {NORMAL95 * last[f'{k}, error']:.1f}" for k in (SEEN, MOTOR))
        apart = (number((own[k] - own["seen"]).abs().mean()) for k in (SEEN, MOTOR))
        about = str(joint), number(1 / inverse, 0), number(last["speed"], 2), number(last["seen"])
        rows.append([*about, *values, *apart])
    heads = "joint", "motor to sensor", "at [rad/s]", "seen [Nm]", SEEN, MOTOR
    return markdown([*heads, "first from seen, mean", "second from seen, mean"], rows)


def drawing(curves: pd.DataFrame) -> Figure:
    """Return a panel for each joint: friction as seen, and both curves with their 95 % bands."""
    figure, axes = plt.subplots(2, 4, figsize=(9, 4.5), layout="constrained")
    for (joint, own), axis in zip(curves.groupby("joint"), axes.flat, strict=False):
        for name, style in ((SEEN, "first"), (MOTOR, "second")):
            axis.add_line(LINE_STYLES[style].line(0, own["speed"], own[name]))
            half = NORMAL95 * own[f"{name}, error"]
            axis.fill_between(own["speed"], own[name] - half, own[name] + half, alpha=0.2,
                              color=LINE_STYLES[style].colours[0], linewidth=0)  # fmt: skip
        axis.plot(own["speed"], own["seen"], "k.", markersize=3)
        axis.set_title(f"Joint {joint}")
    for axis in axes[:, 0]:
        axis.set_ylabel("Friction [Nm]")
    for axis in (*axes[1, :3], axes[0, 3]):
        axis.set_xlabel("Speed [rad/s]")
    lines = [*axes[0, 0].get_lines()]
    axes[1, 3].legend(lines, ["fitted to motor less sensor", "fitted to motor alone", "seen"])
    axes[1, 3].axis("off")
    return figure


def intervals(log: Log, seconds: Sequence[float]) -> str:
    """Return the mean error [Nm] of a recording for intervals between its samples."""
    rows = []
    for period in seconds:
        shorter = PERIOD / period
        own = replace(log, qd=log.qd * shorter, qdd=log.qdd * shorter**2)
        error = np.abs(left(own)[log.parts >= 0]).mean()
        name = f"{period:g}" if period < STILL else "motion left out"
        rows.append([name, number(float(error), DIGITS)])
    return markdown(["interval [s]", "mean error [Nm]"], rows)


if __name__ == "__main__":
    main()
