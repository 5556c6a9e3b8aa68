"""Errors of all estimates of a run, of the same samples, beside those of the project's own."""

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np

from ur5lib.force.contact_figures import INTERVAL_ENDS, figures_by_contact, resampled_means
from ur5lib.force.detection import CONTACT_FORCE, contacts, in_contact
from ur5lib.leaderboard.run import Estimate, Run
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import coverage, interval_score

AXES = ("Fx", "Fy", "Fz")
KEPT = ("mae", "slope", "coverage95", "interval_score95")
Estimates = Mapping[str, Estimate]


def sensed_rows(run: Run, found: Estimates, ours: str) -> Iterator[dict[str, Any]]:
    """Yield figures in contact and free, against the sensor; by axis, and of the vector (`norm`).

    Samples in which any estimate is unknown are left out for all. mae: of an axis; rmse: of the
    force vector; score: interval score, mean of the axes; <figure>_more: how much larger it is than
    that of `ours`. Each has the 95 % interval (_low, _high) from resamples of whole contacts.
    """
    assert run.sensor is not None
    size = np.linalg.norm(run.sensor[:, :3], axis=1)
    common = known_to_all(found)
    count = len(contacts(size, CONTACT_FORCE))
    same = {name: masked(own, common) for name, own in found.items()}
    beside = compared(run.sensor, size, same, ours)
    for name, own in same.items():
        figures = figures_by_contact(*own, run.sensor, size, run.period)
        row: dict[str, Any] = {"recording": run.name, "estimator": name, "contacts": count}
        for during, axis in product(("contact", "free"), range(3)):
            known = axis_figures(figures.get(during, {}), axis)
            where = {"during": during, "component": AXES[axis]}
            yield row | where | known | (beside[AXES[axis]][name] if during == "contact" else {})
        if "coverage95" in figures["contact"]:
            row["coverage95"] = float(figures["contact"]["coverage95"][:3].mean())
        yield row | {"during": "contact", "component": "norm"} | beside["norm"][name]


def axis_figures(figures: Mapping[str, Array], axis: int) -> dict[str, float]:
    """Return the figures of an axis that are shown."""
    return {key: float(figures[key][axis]) for key in KEPT if key in figures}


def compared(
    sensor: Array, size: Array, found: Estimates, ours: str
) -> dict[str, dict[str, dict[str, float]]]:
    """Return the errors of the estimates in contact, beside ours, by axis and of the vector.

    sensor: (N, 6) [N, Nm]; size: of its force (N,) [N].
    """
    errors = {name: (own.wrench - sensor)[:, :3] for name, own in found.items()}
    squares = {name: (own**2).sum(axis=1) for name, own in errors.items()}
    scores = {
        name: score_by_sample(own.wrench, own.std, sensor)
        for name, own in found.items()
        if own.std is not None
    }
    rmse = _resampled(squares, size, np.sqrt, "rmse", ours)
    score = _resampled(scores, size, np.asarray, "score", ours)
    by_axis = {}
    for axis, component in enumerate(AXES):
        absolute = {name: np.abs(own[:, axis]) for name, own in errors.items()}
        by_axis[component] = _resampled(absolute, size, np.asarray, "mae", ours)
    return by_axis | {"norm": {name: rmse[name] | score.get(name, {}) for name in found}}


def score_by_sample(wrench: Array, std: Array, sensor: Array) -> Array:
    """Return the interval score (N,) [N] of each sample, mean of the axes, NaN where unknown."""
    score = np.full(len(wrench), np.nan)
    known = np.isfinite(wrench + std + sensor).all(axis=1)
    own, band, truth = (values[None, known, :3] for values in (wrench, std, sensor))  # (1, n, 3)
    score[known] = interval_score(own, band, truth).mean(axis=1)
    return score


def _resampled(
    values: Mapping[str, Array], size: Array, scale: Any, label: str, ours: str
) -> dict[str, dict[str, float]]:
    """Return a figure of each estimate in contact, its interval, and its difference from ours.

    values: (N,) each; scale: from the mean of the values to the figure; size: (N,) [N], at the
    sensor.
    """
    table = np.column_stack([*values.values()])
    contact = np.isfinite(table).all(axis=1) & in_contact(size)
    figure, draws = scale(table[contact].mean(axis=0)), resampled_means(table, size)
    found = {name: {label: float(own)} for name, own in zip(values, figure, strict=True)}
    if draws is None:
        return found
    drawn, reference = scale(draws), [*values].index(ours)
    more = drawn - drawn[:, [reference]]
    ends = np.concatenate(
        [np.quantile(drawn, INTERVAL_ENDS, axis=0), np.quantile(more, INTERVAL_ENDS, axis=0)]
    )
    for name, low, high, more_low, more_high in zip(values, *ends, strict=True):
        own = found[name]
        own |= {f"{label}_low": low, f"{label}_high": high}
        own |= {f"{label}_more": own[label] - found[ours][label]}
        own |= {f"{label}_more_low": more_low, f"{label}_more_high": more_high}
    return found


def free_rows(run: Run, found: Estimates) -> Iterator[dict[str, Any]]:
    """Yield the force [N] that each estimate shows where nothing touches the arm.

    median and largest95: of |F|; coverage95: how often the band contains the force of zero.
    """
    common = known_to_all(found)
    for name, estimate in found.items():
        wrench, std = masked(estimate, common)
        size = np.linalg.norm(wrench[common, :3], axis=1)
        row: dict[str, Any] = {"recording": run.name, "estimator": name}
        row |= {"during": "free", "component": "norm"}
        row |= {"median": float(np.median(size)), "largest95": float(np.quantile(size, 0.95))}
        if std is not None:
            inside = coverage(wrench[:, :3], std[:, :3], np.zeros_like(wrench[:, :3]))
            row["coverage95"] = float(inside.mean())
        yield row


def known_to_all(found: Estimates) -> Mask:
    """Return the samples (N,) in which every estimate has a force."""
    known = [np.isfinite(own.wrench[:, :3]).all(axis=1) for own in found.values()]
    return np.asarray(np.all(known, axis=0))


def masked(estimate: Estimate, rows: Mask) -> Estimate:
    """Return an estimate in some samples, NaN in the others."""
    wrench, std = estimate
    kept = None if std is None else np.where(rows[:, None], std, np.nan)
    return Estimate(np.where(rows[:, None], wrench, np.nan), kept)
