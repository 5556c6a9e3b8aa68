"""The errors of rollouts: by joint and at the flange, their medians over windows, and in how many
windows one arm is closer than another.
"""

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np
import scipy  # loads scipy.stats at its first use

from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.rollout.models import IDENTIFIED
from ur5lib.topics.rollout.rows import RolledOut
from ur5lib.topics.rollout.windows import HORIZONS

LARGEST = 0.9  # share of windows
TAIL = 0.025  # on either side of a 95 % interval
SMALLEST = 1e-9  # deg, mm
NEAR = 0.5  # of the identified arm's error
MIN_WINDOWS = 6  # the least of which a median has a 95 % interval


def deviations(arm: Robot, angles: Array, reached: Array) -> Array:
    """Return how far angles (W, H, n) [rad] are from those reached: by joint [deg], and the flange
    along x, y, z of the base [mm], (W, H, n + 3).
    """
    places = [
        link_frames(arm, own.reshape(-1, own.shape[-1]))[1][:, -1].reshape(*own.shape[:2], 3)
        for own in (angles, reached)
    ]
    joints, flange = np.degrees(angles - reached), 1e3 * (places[0] - places[1])
    return np.concatenate([joints, flange], axis=-1)


def sizes(deviation: Array) -> Array:
    """Return the size of deviations: by joint [deg], and of the flange [mm], (W, H, n + 1)."""
    joints, flange = np.split(np.abs(deviation), [-3], axis=-1)
    return np.append(joints, np.linalg.norm(flange, axis=-1, keepdims=True), axis=-1)


def rows_of(found: Mapping[str, Array], differing: Array, recordings: int) -> Iterator[RolledOut]:
    """Yield the rows of rollout.csv, of each model the flange first.

    found: `deviations` (W, H, n + 3) by model, that of IDENTIFIED among them; differing: what this
    model's in R windows and in their repeats differ by, (R, H, n + 3); recordings: their number.
    """
    ours, repeated = sizes(found[IDENTIFIED]), sizes(differing / np.sqrt(2))
    error, count = np.maximum(np.median(ours, axis=0), SMALLEST), ours.shape[2]
    floor = np.median(repeated, axis=0) if len(repeated) >= MIN_WINDOWS else np.nan * error
    for model, own in found.items():
        errors, apart = sizes(own), np.median(sizes(own - found[IDENTIFIED]), axis=0)
        won, columns = (ours < errors).sum(axis=0), medians(errors)
        for place, (k, horizon) in product((count - 1, *range(count - 1)), enumerate(HORIZONS)):
            at = k, place
            values: dict[str, Any] = {name: float(each[at]) for name, each in columns.items()}
            if model == IDENTIFIED and np.isfinite(floor[at]):
                values |= {"floor": float(floor[at]), "repeats": len(repeated)}
            elif model != IDENTIFIED:
                values |= {"apart": float(apart[at]), **shares(int(won[at]), len(errors))}
                values["why"] = why(values["beaten"], apart[at] / error[at], floor[at] / error[at])
            yield RolledOut(
                model=model,
                horizon_s=horizon,
                joint=place + 1 if place < count - 1 else None,
                unit="deg" if place < count - 1 else "mm",
                **values,
                windows=len(errors),
                recordings=recordings,
            )


def medians(errors: Array) -> dict[str, Array]:
    """Return the columns of a row about its own errors (W, ...)."""
    low, high = median_interval(errors)
    largest = np.quantile(errors, LARGEST, axis=0, method="higher")
    return {"error": np.median(errors, axis=0), "low": low, "high": high, "largest": largest}


def why(beaten: str, apart: float, floor: float) -> str | None:
    """Return why an arm is not beaten; apart: distance from the identified arm, floor: of repeats,
    NaN if unknown, both over the identified arm's error.
    """
    if beaten == "yes":
        return None
    if apart < NEAR:
        return "alike"
    if floor >= NEAR:
        return "repeats"
    return "few" if beaten == "open" else "worse"


def median_interval(values: Array) -> Array:
    """Return the ends of the 95 % interval of medians over the first axis (W, ...), (2, ...).

    They are values of the sample: of W independent ones, a number below the median is binomial.
    """
    tail = int(scipy.stats.binom.ppf(TAIL, len(values), 0.5))
    ordered = np.sort(values, axis=0)
    return ordered[[max(tail - 1, 0), min(len(values) - tail, len(values) - 1)]]


def shares(won: int, windows: int) -> dict[str, Any]:
    """Return the share of windows that were won, its 95 % interval (Clopper and Pearson 1934), and
    whether it is above a half, as fields of a row.
    """
    beta = scipy.stats.beta
    low = float(beta.ppf(TAIL, won, windows - won + 1)) if won else 0.0
    high = float(beta.isf(TAIL, won + 1, windows - won)) if won < windows else 1.0
    beaten = "yes" if low > 0.5 else "no" if high < 0.5 else "open"
    share = {"closer": won / windows, "closer_low": low, "closer_high": high}
    return share | {"beaten": beaten}
