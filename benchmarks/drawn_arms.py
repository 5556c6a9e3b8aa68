"""What the population tells of arms that are drawn from it, and of one that is not.

    python -m benchmarks.drawn_arms [arms] [--quick]

Arms (200) have torque constants and friction of the shipped population: its trends, and the spreads
of arms and joints. Friction further differs from day to day and from run to run. Each arm moves
along six drawn paths on three days, on 10 Hz samples that its link model and its friction make with
a slow noise. Each is fitted as a study fits it, and a population is estimated from the fits. Then,
with the population of the other half of the arms: how often the 95 % intervals of an arm's
parameters contain them, by the number of recordings to fit on; how often the joint is named of
which friction was doubled; and how often any joint of an arm is that was not changed.
"""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from scipy.signal import lfilter

from benchmarks.harness.options import options_of
from ur5lib.commands.population import CLEAR
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.condition import joint_conditions
from ur5lib.identification.current_regression import expected_fit, fit_currents
from ur5lib.identification.currents import (
    BETWEEN_DAYS,
    BETWEEN_RUNS,
    CurrentFit,
    parameters,
    torque_constants,
)
from ur5lib.identification.population import KINDS, Population, fit_population
from ur5lib.identification.samples import Record, columns_of
from ur5lib.pipeline.current_samples import prior_of
from ur5lib.robots.description import POPULATION, Robot, load_robot, robot_path
from ur5lib.robots.friction import BASE, PRESLIDING
from ur5lib.robots.population import Measured, MeasuredArm, MeasuredJoint, read_measured
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.profiles import fourier_terms, resting_series

ROBOTS = ("ur3e", "ur5e", "ur10e")  # in turn
DAYS, RUNS = 3, 2  # of an arm; of a day
NOISE, MEMORY = 0.1, 0.5  # of Coulomb friction; s, over which it is correlated
SECONDS, PERIOD, HARMONICS = 30.0, 0.1, 12
SPEED, PATHS = 1.2, 12  # rad/s, the largest of each joint; drawn paths, shared among the arms

Traits = dict[str, Array]
"""The true traits of an arm's joints, (6,) each, in SI units."""


@dataclass(frozen=True)
class Arm:
    """A drawn arm: its true traits, and its recordings."""

    robot: Robot
    traits: Traits
    records: list[Record]


def main() -> None:
    """Print spreads beside the true ones, shares of intervals that hold, and arms named."""
    options = options_of(__doc__)
    options.add_argument("arms", type=int, nargs="?", default=200)
    given = options.parse_args()
    numbers = range(4 if given.quick else given.arms)
    truth, rows = fit_population(read_measured(POPULATION)), []
    measured: list[MeasuredArm] = []
    for number in numbers:
        arm = draw_arm(truth, number)
        fit = fit_currents(arm.records, as_recorded, prior_of(arm.robot, []), [])
        measured.append(measured_arm(arm, fit, number))
        rows.append(deviations(arm, fit))
    print_spreads(truth, fit_population(Measured(arms=measured)), between(np.stack(rows)))
    of_others = [fit_population(Measured(arms=measured[half::2])) for half in (1, 0)]
    judged = Judged()
    for number in numbers:
        judged.judge(truth, number, of_others[number % 2])
    judged.print_shares()


def draw_arm(truth: Population, number: int, strange: int | None = None) -> Arm:
    """Return an arm of the population, recorded on DAYS days.

    strange: a joint from 0 with twice the Coulomb and viscous friction, if any.
    """
    random = np.random.default_rng(number)
    robot = load_robot(robot_path(ROBOTS[number % len(ROBOTS)]))
    traits = draw_traits(truth, robot, random)
    for name in ("coulomb", "viscous") if strange is not None else ():
        traits[name][strange] *= 2
    records = []
    for day in range(DAYS):
        of_day = 1 + BETWEEN_DAYS * random.standard_normal(6)
        for _ in range(RUNS):
            rubbing = of_day * (1 + BETWEEN_RUNS * random.standard_normal(6))
            path = (number + len(records)) % PATHS
            record = recorded(robot, path, traits, rubbing, random)
            records.append(replace(record, day=str(day)))
    return Arm(robot, traits, records)


def draw_traits(truth: Population, robot: Robot, random: np.random.Generator) -> Traits:
    """Return traits of an arm's joints: trend, plus the arm's deviation, plus the joints'."""
    torque_max = np.array(robot.torque_limits())
    traits: Traits = {}
    for name, spread in truth.items():
        mean = spread.kind.columns(torque_max) @ spread.trend
        own = spread.arm * random.standard_normal() + spread.joint * random.standard_normal(6)
        traits[name] = np.exp(mean + own) if spread.kind.logarithm else mean + own
    coulomb = truth["coulomb"]
    traits["offset"] *= np.exp(coulomb.kind.columns(torque_max) @ coulomb.trend)
    traits["torque_constant"] *= np.array(robot.family_torque_constants())
    return traits


def recorded(
    robot: Robot, path: int, traits: Traits, rubbing: Array, random: np.random.Generator
) -> Record:
    """Return a recording; rubbing: (6,), by which its friction is multiplied."""
    still = moved(robot.name, path)
    noise = NOISE * traits["coulomb"] * slow_noise(len(still.q), random)
    torque = [
        columns @ np.concatenate([[1, -traits["offset"][joint]], rubbing[joint] * own])
        for joint, own in enumerate(np.stack([traits[t.kind] for t in BASE], axis=1))
        for columns, _ in [columns_of(still.joint(joint, PRESLIDING[0]), BASE)]
    ]
    current = (np.stack(torque, axis=1) + noise) / traits["torque_constant"]
    return replace(still, name=f"{path}_{random.integers(10**9)}", current=current)


@cache
def moved(name: str, path: int) -> Record:
    """Return a motion that begins and ends at rest, and the torque of the links."""
    random = np.random.default_rng(1000 + path)
    time = np.arange(0, SECONDS, PERIOD)
    weights = resting_series(SECONDS, HARMONICS) @ random.standard_normal((2 * HARMONICS - 3, 6))
    position, rate, acceleration, _ = (
        term @ weights for term in fourier_terms(SECONDS, HARMONICS, time)
    )
    scale = SPEED / np.abs(rate).max(axis=0)
    q, qd, qdd = position * scale + random.uniform(-2, 2, 6), rate * scale, acceleration * scale
    robot = load_robot(robot_path(name))
    torque = LinkModel(robot, robot.fullest_model()).inverse_dynamics(q, qd, qdd)
    return Record("", PERIOD, np.zeros(len(q), np.int64), q, qd, torque, 0 * q)


def slow_noise(count: int, random: np.random.Generator) -> Array:
    """Return noise (count, 6) of standard deviation 1, correlated over MEMORY."""
    kept = np.exp(-PERIOD / MEMORY)
    white = random.standard_normal((count, 6)) * np.sqrt(1 - kept**2)
    return np.asarray(lfilter([1.0], [1.0, -kept], white, axis=0))


def measured_arm(arm: Arm, fit: CurrentFit, number: int) -> MeasuredArm:
    """Return an arm's traits as `ur5 population --write` takes them from its own fit."""
    values: dict[int, dict[Any, tuple[float, float]]] = defaultdict(dict)
    for row in parameters(fit):
        clear = not KINDS[row.name].logarithm or row.value > CLEAR * row.std_error  # type: ignore[index]
        if row.determined and clear:
            values[row.joint][row.name] = row.value, row.std_error
    constants = arm.robot.family_torque_constants()
    joints = {
        joint: MeasuredJoint(
            torque_max=arm.robot.motor(joint).torque_max,
            family_constant=constants[joint - 1],
            values=own,
        )
        for joint, own in values.items()
    }
    minutes = DAYS * RUNS * SECONDS / 60
    about = {"arm": arm.robot.name, "study": str(number), "source": "drawn"}
    return MeasuredArm(**about, days=DAYS, minutes=minutes, joints=joints)


def as_recorded(values: Array, record: Record) -> Array:
    """Return values as they are, in place of a low-pass: drawn samples are slow already."""
    return values


def deviations(arm: Arm, fit: CurrentFit) -> Array:
    """Return Coulomb friction of each run over that of the fit, and the variance of its error.

    Shape (2, DAYS, RUNS, 6), by the condition that a study's health shows of each recording.
    """
    whole = torque_constants(fit) * [own.estimate.coefficients[2] for own in fit.joints]
    each = [joint_conditions(record, as_recorded, fit) for record in arm.records]
    runs = np.array([[own["coulomb"] for own in joints] for joints in each])  # (R, 6, 2)
    value, error = np.moveaxis(runs, -1, 0) / whole
    return np.stack([value, error**2]).reshape(2, DAYS, RUNS, 6)


def between(found: Array) -> dict[str, float]:
    """Return the standard deviations of days and of runs (analysis of variance, by moments).

    found: `deviations` of all arms, (A, 2, DAYS, RUNS, 6).
    """
    value, error = found[:, 0], float(found[:, 1].mean())
    within, of_days = value.var(axis=2, ddof=1).mean(), value.mean(axis=2).var(axis=1, ddof=1)
    parts = {"days": of_days.mean() - within / RUNS, "runs": within - error}
    return {name: float(np.sqrt(max(variance, 0.0))) for name, variance in parts.items()}


def print_spreads(truth: Population, found: Population, friction: Mapping[str, float]) -> None:
    """Print each level's standard deviation, and the true one; friction: of days and runs."""
    for name, own in truth.items():
        arms = f"{found[name].arm:.3f} ({own.arm:.3f})"
        joints = f"{found[name].joint:.3f} ({own.joint:.3f})"
        print(f"{name}, found (true): of arms {arms}, of joints {joints}")
    true = {"days": BETWEEN_DAYS, "runs": BETWEEN_RUNS}
    parts = [f"of {level} {friction[level]:.3f} ({true[level]:.3f})" for level in true]
    print(f"friction, found (true): {', '.join(parts)}")


@dataclass
class Judged:
    """What is counted.

    inside: whether intervals hold, by the number of recordings and trait; named: whether the joint
    with doubled friction was; falsely: whether any joint of an arm was that was not changed.
    """

    inside: dict[str, dict[int, list[bool]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(list))
    )
    named: list[bool] = field(default_factory=list)
    falsely: list[bool] = field(default_factory=list)

    def judge(self, truth: Population, number: int, known: Population) -> None:
        """Judge an arm by a population that was estimated without it."""
        arm, joint = draw_arm(truth, number), number % 6
        prior = prior_of(arm.robot, [], known)
        self._intervals(arm, 0, expected_fit(prior))
        for count in (1, DAYS * RUNS):
            fit = fit_currents(arm.records[:count], as_recorded, prior, [])
            self._intervals(arm, count, fit)
        self.falsely.append(bool(unlike(fit)))
        other = draw_arm(truth, number, strange=joint)
        self.named.append(joint in unlike(fit_currents(other.records, as_recorded, prior, [])))

    def _intervals(self, arm: Arm, count: int, fit: CurrentFit) -> None:
        for row in parameters(fit):
            low, high = row.interval
            holds = low <= arm.traits[row.name][row.joint - 1] <= high
            self.inside[row.name][count].append(bool(holds))

    def print_shares(self) -> None:
        """Print the shares of intervals that hold, and those of arms."""
        for name, by_count in self.inside.items():
            parts = [f"{np.mean(own):.3f} with {count}" for count, own in by_count.items()]
            print(f"{name}, intervals that hold: {', '.join(parts)} recordings")
        print(f"doubled friction named on {np.mean(self.named):.3f} of {len(self.named)} arms")
        print(f"a joint named falsely on {np.mean(self.falsely):.3f}")


def unlike(fit: CurrentFit) -> set[int]:
    """Return the joints, from 0, that are said to differ from other arms."""
    return {
        joint
        for joint, own in enumerate(fit.joints)
        if any(found.code == "unlike other arms" for found in own.remarks)
    }


if __name__ == "__main__":
    main()
