"""Errors of all estimates of a run, of the same samples, compared with the project's own."""

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np

from ur5lib.force.contact_figures import INTERVAL_ENDS, figures_by_contact, resampled_means
from ur5lib.force.sensed_contact import CONTACT_FORCE, contacts, in_contact
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import coverage, interval_scores
from ur5rivals.run import Estimate, Run

FORCE_COMPONENTS = ("Fx", "Fy", "Fz")
SHOWN_FIGURES = ("mae", "slope", "coverage95", "interval_score95")
EstimatesByName = Mapping[str, Estimate]


def sensed_rows(run: Run, estimates: EstimatesByName, ours: str) -> Iterator[dict[str, Any]]:
    """Yield scores against the sensor, in contact and free; by axis, and of the vector (`norm`).

    Samples in which any estimate is unknown are left out for all. mae: of an axis; rmse: of the
    force vector; score: interval score, mean of the axes; <figure>_more: difference from the figure
    of `ours`; with the 95 % interval (_low, _high) of each from a bootstrap over whole contacts.
    width: of the band in contact; score_whole: of the whole recording.
    """
    assert run.sensor is not None
    size = np.linalg.norm(run.sensor[:, :3], axis=1)
    common = known_to_all(estimates)
    count = len(contacts(size, CONTACT_FORCE))
    same = {name: masked(estimate, common) for name, estimate in estimates.items()}
    beside = compared(run.sensor, size, same, ours)
    for name, estimate in same.items():
        figures = figures_by_contact(*estimate, run.sensor, size, run.period)
        row: dict[str, Any] = {"recording": run.name, "estimator": name, "contacts": count}
        for during, axis in product(("contact", "free"), range(3)):
            of_axis = axis_figures(figures.get(during, {}), axis)
            where = {"during": during, "component": FORCE_COMPONENTS[axis]}
            yield (
                row
                | where
                | of_axis
                | (beside[FORCE_COMPONENTS[axis]][name] if during == "contact" else {})
            )
        if estimate.std is not None:
            row["coverage95"] = float(figures["contact"]["coverage95"][:3].mean())
            row["width"] = float(figures["contact"]["width95"][:3].mean())
            row["score_whole"] = float(figures["all"]["interval_score95"][:3].mean())
        yield row | {"during": "contact", "component": "norm"} | beside["norm"][name]


def axis_figures(figures: Mapping[str, Array], axis: int) -> dict[str, float]:
    """Return by name those figures of an axis that the tables show."""
    return {key: float(figures[key][axis]) for key in SHOWN_FIGURES if key in figures}


def compared(
    sensor: Array, size: Array, estimates: EstimatesByName, ours: str
) -> dict[str, dict[str, dict[str, float]]]:
    """Return the errors of the estimates in contact, compared with ours, by axis and of the vector.

    sensor: (N, 6) [N, Nm]; size: of its force (N,) [N].
    """
    errors = {name: (estimate.wrench - sensor)[:, :3] for name, estimate in estimates.items()}
    squares = {name: (error**2).sum(axis=1) for name, error in errors.items()}
    scores = {
        name: interval_scores(estimate.wrench, estimate.std, sensor)[:, :3].mean(axis=1)
        for name, estimate in estimates.items()
        if estimate.std is not None
    }
    rmse = _resampled(squares, size, np.sqrt, "rmse", ours)
    score = _resampled(scores, size, np.asarray, "score", ours)
    by_axis = {}
    for axis, component in enumerate(FORCE_COMPONENTS):
        absolute = {name: np.abs(error[:, axis]) for name, error in errors.items()}
        by_axis[component] = _resampled(absolute, size, np.asarray, "mae", ours)
    return by_axis | {"norm": {name: rmse[name] | score.get(name, {}) for name in estimates}}


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
    by_name = {name: {label: float(row)} for name, row in zip(values, figure, strict=True)}
    if draws is None:
        return by_name
    drawn, reference = scale(draws), [*values].index(ours)
    more = drawn - drawn[:, [reference]]
    ends = np.concatenate(
        [np.quantile(drawn, INTERVAL_ENDS, axis=0), np.quantile(more, INTERVAL_ENDS, axis=0)]
    )
    for name, low, high, more_low, more_high in zip(values, *ends, strict=True):
        row = by_name[name]
        row |= {f"{label}_low": low, f"{label}_high": high}
        row |= {f"{label}_more": row[label] - by_name[ours][label]}
        row |= {f"{label}_more_low": more_low, f"{label}_more_high": more_high}
    return by_name


def free_rows(run: Run, estimates: EstimatesByName) -> Iterator[dict[str, Any]]:
    """Yield for each estimate its force [N] on a run without contact.

    median: of |F|; largest95: 95 % quantile of |F|; coverage95: share of samples with zero in the
    band.
    """
    common = known_to_all(estimates)
    for name, estimate in estimates.items():
        wrench, std = masked(estimate, common)
        size = np.linalg.norm(wrench[common, :3], axis=1)
        row: dict[str, Any] = {"recording": run.name, "estimator": name}
        row |= {"during": "free", "component": "norm"}
        row |= {"median": float(np.median(size)), "largest95": float(np.quantile(size, 0.95))}
        if std is not None:
            inside = coverage(wrench[:, :3], std[:, :3], np.zeros_like(wrench[:, :3]))
            row["coverage95"] = float(inside.mean())
        yield row


def known_to_all(estimates: EstimatesByName) -> Mask:
    """Return the mask (N,) of samples at which every estimate states a force."""
    finite = [np.isfinite(estimate.wrench[:, :3]).all(axis=1) for estimate in estimates.values()]
    return np.asarray(np.all(finite, axis=0))


def masked(estimate: Estimate, rows: Mask) -> Estimate:
    """Return an estimate in the samples `rows`, NaN in the others."""
    wrench, std = estimate
    masked_std = None if std is None else np.where(rows[:, None], std, np.nan)
    return Estimate(np.where(rows[:, None], wrench, np.nan), masked_std)
