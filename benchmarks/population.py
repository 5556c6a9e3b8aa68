"""What other arms tell of one: each measured arm left out of the population in turn.

    python -m benchmarks.population [--quick]

Takes the built studies of results/ whose arms are in ur5lib/robots/population.yaml. A line for
each: the error of predicted currents below 2 Hz over all recordings without contact or undeclared
load, relative to that of the study's own fit (cross-fitted), mean over joints: expected from the
other arms; without friction; with the median friction per largest torque of the other arms' joints
of nearly that size; fitted to one recording in which every joint moves, with the other arms and
without them, mean over these recordings, and the worst joint of that mean. Then the share of
currents inside the expected band, and that of the measured values inside the expected 95 %
intervals. `--quick` fits to one recording only.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.current_prediction import read_arms
from benchmarks.harness.options import options_of
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.identification.current_regression import expected_fit, fit_currents
from ur5lib.identification.currents import CurrentFit, band, parameters, predict
from ur5lib.identification.population import fit_population
from ur5lib.identification.samples import Record
from ur5lib.identification.validation import baseline_current, coefficients_of_constants
from ur5lib.pipeline.current_samples import Smoother, prior_of
from ur5lib.pipeline.records.friction import Friction
from ur5lib.robots.description import POPULATION, Robot, load_robot, robot_path
from ur5lib.robots.population import Measured, MeasuredArm, read_measured
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

CUTOFF = 2.0  # Hz
SMOOTH = Smoother(4, CUTOFF)
ALIKE = 1.4  # factor between the largest torques of joints of one size
MOVES = 0.05  # rad/s, that a recording to fit on reaches on every joint


def main() -> None:
    """Print a line for each arm, and the share of intervals that hold."""
    given = options_of(__doc__).parse_args()
    measured, inside = read_measured(POPULATION), []
    for arm in measured.arms:
        try:
            study = FinishedStudy(Path("results") / arm.study)
            friction = study.parameters(Friction, arm.arm, "friction")
        except InputError:
            print(f"{arm.arm} of {arm.study}: not built")
            continue
        others = measured.without(arm.study)
        print(f"{arm.arm} of {arm.study}: {judged(study, arm, friction, others, given.quick)}")
        inside += inside_intervals(arm, others)
    print(f"inside their 95 % intervals: {np.mean(inside):.2f} of {len(inside)} values")


def judged(
    study: FinishedStudy, arm: MeasuredArm, friction: Friction, others: Measured, quick: bool
) -> str:
    """Return what the others tell of an arm's currents, beside its own fit and simpler guesses."""
    described = load_robot(robot_path(arm.arm))
    records = recorded(study.folder, arm.arm)
    prior = prior_of(described, [], fit_population(others))
    expected = expected_fit(prior)

    def cross_fitted(record: Record) -> Array:
        return predict(friction.fit_for(record.name), record)

    def error(fit: CurrentFit, seen: str = "") -> Array:
        return rmse(partial(predict, fit), [own for own in records if own.name != seen])

    own = rmse(cross_fitted, records)
    guesses = {
        "no friction": guessed(described, None),
        "median friction": guessed(described, others),
    }
    errors = {"expected": error(expected)} | {
        name: rmse(partial(baseline_current, coefficients=guess), records)
        for name, guess in guesses.items()
    }
    parts = [f"{name} {(each / own).mean():.2f}" for name, each in errors.items()]
    moving = [record for record in records if (np.abs(record.qd).max(axis=0) > MOVES).all()]
    single = moving[: 1 if quick else None] if len(records) > 1 else []
    for name, known in (("population", prior), ("none", replace(prior, typical={}))):
        fits = [(fit_currents([one], SMOOTH, known, []), one.name) for one in single]
        if fits:
            ratios = np.mean([error(fit, seen) / own for fit, seen in fits], axis=0)
            parts.append(
                f"one recording ({name}) {ratios.mean():.2f}, worst joint {ratios.max():.2f}"
            )
    shares = [covered(expected, record) for record in records]
    return "; ".join([*parts, f"inside the expected band {np.nanmean(shares):.2f}"])


def recorded(folder: Path, robot: str) -> list[Record]:
    """Return the contact-free recordings of an arm, without those of an undeclared load."""
    return [own.record for arm in read_arms(folder) if arm.folder.name == robot for own in arm.runs]


def rmse(predicted: Callable[[Record], Array], records: Sequence[Record]) -> Array:
    """Return the RMSE (n,) [A] of predicted currents below CUTOFF over all recordings."""
    residuals = [SMOOTH(own.current - predicted(own), own) for own in records]
    error: Array = np.sqrt(np.nanmean(np.concatenate(residuals) ** 2, axis=0))
    return error


def covered(fit: CurrentFit, record: Record) -> float:
    """Return the share of a recording's currents inside the band of a fit."""
    half = band(fit, record, SMOOTH)
    slow = SMOOTH(record.current - predict(fit, record), record)
    return float(np.mean((np.abs(slow) <= half)[np.isfinite(slow)]))


def guessed(arm: Robot, others: Measured | None) -> Array:
    """Return the baseline's coefficients: family's constants, median friction of others."""
    constants, nothing = np.array(arm.family_torque_constants()), np.zeros(len(arm.joints))
    friction = {"coulomb": nothing, "viscous": nothing}
    if others is not None:
        for name in friction:
            friction[name] = np.array([median(others, name, most) for most in arm.torque_limits()])
    return coefficients_of_constants(constants, nothing, friction["coulomb"], friction["viscous"])


def median(others: Measured, name: str, torque_max: float) -> float:
    """Return the median of a trait per largest torque, times this one; of alike joints if any."""
    joints = [own for arm in others.arms for own in arm.joints.values() if name in own.values]
    alike = [own for own in joints if 1 / ALIKE < own.torque_max / torque_max < ALIKE]
    return torque_max * float(
        np.median([own.values[name][0] / own.torque_max for own in alike or joints])  # type: ignore[index]
    )


def inside_intervals(arm: MeasuredArm, others: Measured) -> list[bool]:
    """Return whether each measured value is inside the interval that the others give."""
    prior = prior_of(load_robot(robot_path(arm.arm)), [], fit_population(others))
    found = []
    for row in parameters(expected_fit(prior)):
        own = arm.joints.get(row.joint)
        if own is not None and row.name in own.values:
            value, error = own.values[row.name]  # type: ignore[index]
            half = (row.interval[1] - row.interval[0]) / 2
            found.append(bool(abs(value - row.value) <= np.hypot(half, NORMAL95 * error)))
    return found


if __name__ == "__main__":
    main()
