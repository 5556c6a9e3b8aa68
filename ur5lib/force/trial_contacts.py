"""Trial contacts on contact-free recordings: which the gate finds, by axis, speed and size."""

from dataclasses import dataclass, fields
from typing import NamedTuple, Self

import numpy as np
from scipy.optimize import approx_fprime, brentq, minimize
from scipy.special import expit, logit

from ur5lib.force.external_torque import JointState, States
from ur5lib.force.force_input import Gears
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import Span, overlap

PUSH_DURATION = 1.0  # s; a trial push lasts this long
PAUSE_DURATION = 2.0  # s; trial pushes are this far apart
TRIAL_SIZES = (1 / 12, 7.0)  # smallest and largest trial push, in typical forces
LOG_STEEPNESS = 1.5  # with it, the logistic curve goes from 25 to 75 % found within a factor of 1.6


@dataclass(frozen=True)
class Trials:
    """Results of M trial pushes.

    force: peaks (M,) [N]; axis: of the base (M,), 0 to 2; speed: mean of the flange (M,) [m/s]
    during the push, zero while the whole arm rests; found: whether an alarm overlaps the push (M,);
    unit: force along the axis (M,) [N] of one standard deviation of the joints' torques.
    """

    force: Array
    axis: Labels
    speed: Array
    found: Mask
    unit: Array

    @classmethod
    def joined(cls, parts: list[Self]) -> Self:
        """Return the trials of several recordings."""
        names = [field.name for field in fields(cls)]
        return cls(*(np.concatenate([getattr(trials, name) for trials in parts]) for name in names))

    def within(self, low: float, high: float) -> "Trials":
        """Return the trials at speeds from `low` to below `high` [m/s]."""
        return self.where((self.speed >= low) & (self.speed < high))

    def along(self, axis: int) -> "Trials":
        """Return the trials along one axis."""
        return self.where(self.axis == axis)

    def felt(self, largest: float) -> Mask:
        """Return in which trials (M,) a force of size `largest` [N] is at least two standard
        deviations of the joints' torques.
        """
        return 2 * self.unit <= largest

    def where(self, rows: Mask) -> "Trials":
        """Return the trials in some rows (M,)."""
        return Trials(*(getattr(self, field.name)[rows] for field in fields(self)))


def flange_speed(jacobian: Array, qd: Array) -> Array:
    """Return the speed (N,) [m/s] of the flange; jacobian: (N, 6, n); qd: (N, n) [rad/s]."""
    speed: Array = np.linalg.norm(np.matvec(jacobian[:, :3], qd), axis=1)
    return speed


def felt_push(
    torque: Array,
    time: Array,
    states: States,
    gears: Gears | None,
    largest_friction: Array,
    random: np.random.Generator,
) -> Array:
    """Return the part (N, 6) [Nm] of pushes' torques that reaches the motors.

    In motion, gears lose a part of it; at rest, dry friction takes up to a share of
    `largest_friction`, drawn for each push and joint. torque: (N, 6) [Nm]; time: (N,) [s];
    largest_friction: (6,) [Nm].
    """
    push = (time // (PUSH_DURATION + PAUSE_DURATION)).astype(np.int64)
    # dry friction bears anything between nothing and all that it can
    bears = (
        random.uniform(size=(push.max(initial=0) + 1, len(largest_friction)))[push]
        * largest_friction
    )
    resting = torque - np.clip(torque, -bears, bears)
    moving = torque if gears is None else gears.where_moving(states).felt(torque)
    return np.where(states == JointState.STILL, resting, moving)


class Untouched(NamedTuple):
    """A contact-free recording, on which pushes are tried.

    jacobian: (N, 6, n); speed: of the flange (N,) [m/s]; period: [s]; raised: its own alarms,
    during which no push is tried; hiding: variances (N, n) [N²m²] of the torque that hides a push.
    """

    jacobian: Array
    speed: Array
    period: float
    raised: list[Span]
    hiding: Array

    def information(self, place: Span) -> Array:
        """Return the mean information A = Σ j jᵀ / S (3, 3) [1/N²] on a force in a span, j: columns
        of J.
        """
        jacobian, hiding = self.jacobian[slice(*place), :3], self.hiding[slice(*place)]
        felt: Array = np.matmul(jacobian / hiding[:, None], jacobian.mT).mean(axis=0)
        return felt

    def free(self, places: list[Span]) -> list[tuple[Span, float]]:
        """Return the spans without an alarm, each with the flange's mean speed [m/s] in it."""
        means = [(place, float(self.speed[slice(*place)].mean())) for place in places]
        return [
            (place, mean)
            for place, mean in means
            if np.isfinite(mean) and not any(overlap(alarm, place) for alarm in self.raised)
        ]


def unit_along(information: Array, direction: Array) -> Array:
    """Return the force (...) [N] along a direction that is one standard deviation of the joints'
    torques: (dᵀ A d)^-½.

    information: A (3, 3) [1/N²]; direction: d (..., 3). Infinite where no joint feels it.
    """
    felt = np.vecdot(direction, np.matvec(information, direction))
    with np.errstate(divide="ignore"):
        return np.asarray(np.maximum(felt, 0.0) ** -0.5)


class Round(NamedTuple):
    """Pushes that are tried together: one in each span of a recording without an alarm.

    places: spans, with the flange's mean speed [m/s] in each; force: peaks (M,) [N]; axis: of the
    base (M,), 0 to 2; torque: external (N, n) [Nm].
    """

    places: list[tuple[Span, float]]
    force: Array
    axis: Labels
    torque: Array

    def tried(self, run: Untouched, alarms: list[Span]) -> Trials:
        """Return the results, by the alarms with the pushes."""
        found = [any(overlap(alarm, place) for alarm in alarms) for place, _ in self.places]
        units = [
            float(unit_along(run.information(place), np.eye(3)[axis]))
            for (place, _), axis in zip(self.places, self.axis, strict=True)
        ]
        speeds = np.array([mean for _, mean in self.places])
        return Trials(self.force, self.axis, speeds, np.array(found, bool), np.array(units))


def pushes_at_each_place(
    run: Untouched, random: np.random.Generator, typical_force: float, later: float = 0.0
) -> Round:
    """Return one push for each span without an alarm, along the base's x, y or z.

    random: distributes peaks and axes; typical_force: of contacts [N]; later: delay of all pushes,
    as a share of the interval of two.
    """
    profile, places = trial_pushes(len(run.jacobian), run.period, later)
    free = run.free(places)
    peaks = typical_force * random.permutation(sizes(len(free), later))
    # axes as evenly as possible
    axes = random.permutation((random.integers(3) + np.arange(len(free))) % 3)
    force = np.zeros((len(profile), 3))
    for (place, _), peak, axis in zip(free, peaks, axes, strict=True):
        force[slice(*place), axis] = peak * profile[slice(*place)]
    return Round(free, peaks, axes, np.matvec(run.jacobian[:, :3].mT, force))


def sizes(count: int, later: float) -> Array:
    """Return the sizes (count,) of a round's pushes in typical forces, evenly in their logarithm.

    Each round has other sizes, so that with few pushes a round, all sizes are tried; later: as of
    `pushes_at_each_place`.
    """
    smallest, largest = np.log(TRIAL_SIZES)
    shares = (np.arange(count) + 1 - later) / max(1, count)
    return np.asarray(np.exp(smallest + (largest - smallest) * shares))


def trial_pushes(count: int, period: float, later: float = 0.0) -> tuple[Array, list[Span]]:
    """Return raised-cosine pushes of height 1, one after each pause: profile (N,) and their spans.

    later: delay of all pushes, as a share of the interval of two.
    """
    length = round(PUSH_DURATION / period)
    interval = round((PUSH_DURATION + PAUSE_DURATION) / period)
    profile = np.zeros(count)
    shape = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(length) / length)
    starts = range(interval - length + round(later * interval), count - length, interval)
    for start in starts:
        profile[start : start + length] = shape
    return profile, [(start, start + length) for start in starts]


class Curve(NamedTuple):
    """The share of pushes that is found at a place, p = 1 / (1 + exp(-e^s (log F - log unit - m))).

    parameters: (m, s); covariance: of these (2, 2).
    """

    parameters: Array
    covariance: Array

    @classmethod
    def of(cls, force: Array, detected: Mask, unit: Array | float = 1.0) -> Self:
        """Return the curve fitted by maximum likelihood to trial pushes (M,) [N] at places with
        these units [N].
        """
        x = np.log(force) - np.log(unit)
        start = np.array([np.median(x[detected]), LOG_STEEPNESS])
        best = minimize(_cost, start, args=(x, detected))
        return cls(best.x, np.asarray(best.hess_inv))

    def share(self, force: Array, unit: Array) -> Array:
        """Return the share (K,) of pushes with forces (K,) [N] that is found, as the mean over
        places with units (M,) [N].
        """
        middle, steepness = self.parameters
        x = np.log(force)[:, None] - np.log(unit)
        return np.asarray(expit(np.exp(steepness) * (x - middle)).mean(axis=1))


def smallest_force(
    force: Array, detected: Mask, unit: Array | float = 1.0, probability: float = 0.95
) -> tuple[float, float]:
    """Return the force [N] of which a share `probability` is found, and its standard error.

    It is from a logistic curve over log force, and the curvature of its likelihood (delta method).
    force: (M,) [N], of trial pushes; detected: (M,); unit: of each place (M,) [N]; the share is the
    mean over places. Infinite if none was found.
    """
    if not detected.any():
        return np.inf, np.nan
    units = np.log(np.broadcast_to(unit, force.shape))
    curve = Curve.of(force, detected, unit)

    def reached(parameters: Array) -> float:
        """Return the log force at which the mean share found is `probability`, for these parameters
        of the curve.
        """
        middle, steepness = parameters
        alone = middle + logit(probability) * np.exp(-steepness)  # at one place
        ends = alone + units.min() - 1e-6, alone + units.max() + 1e-6
        return float(brentq(_missed, *ends, args=(units + middle, steepness, probability)))

    place = reached(curve.parameters)
    slope = approx_fprime(curve.parameters, reached, 1e-4)
    return float(np.exp(place)), float(np.exp(place) * np.sqrt(slope @ curve.covariance @ slope))


def _missed(place: float, middles: Array, steepness: float, probability: float) -> float:
    """Return probability minus the mean share of pushes found at the log force `place`."""
    return float(probability - expit(np.exp(steepness) * (place - middles)).mean())


def _cost(parameters: Array, x: Array, detected: Mask) -> float:
    """Return the negative log-likelihood, with a weak prior against perfect separation."""
    middle, steepness = parameters
    odds = np.exp(steepness) * (x - middle)
    likelihood = np.logaddexp(0, np.where(detected, -odds, odds)).sum()
    return float(likelihood + 0.5 * (steepness - LOG_STEEPNESS) ** 2)
