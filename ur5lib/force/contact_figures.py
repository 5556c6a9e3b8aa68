"""Errors of a contact wrench estimate against the force sensor: in contact, free, overall."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ur5lib.force.alarms import largest_force
from ur5lib.force.estimators import Stated
from ur5lib.force.sensed_contact import CONTACT_FORCE, contacts, in_contact, is_free
from ur5lib.records.contacts import WHOLE, ContactError
from ur5lib.records.force_errors import ForceError
from ur5lib.records.table import WRENCH
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.metrics import (
    BAND_COVERAGE,
    NORMAL95,
    band_factor,
    correlation,
    coverage,
    interval_score,
    largest_error,
    mean_absolute_error,
    skill,
    slope,
    zero_interval_score,
)
from ur5lib.timeseries.segments import inside_spans, overlap

NOMINAL_COVERAGES = (0.5, 0.8, 0.95)  # nominal coverages of bands
CONTACT_RESAMPLES = 1000  # a recording's contacts are resampled this often
MIN_CONTACTS = 3  # fewer contacts give no interval by resampling
INTERVAL_ENDS = [0.025, 0.975]  # quantiles at the ends of a 95 % interval
MIN_GAIN = 0.2  # an estimate with a smaller gain does not show the force
SPLIT = ("mae_missed", "mae_shut", "mae_gain")  # parts of an error in contact
MIN_MEAN = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1])  # N, Nm; no gain is stated of a smaller mean
MIN_DIVISOR = 1e-12  # N, N s: replaces a zero divisor


def periods(force: Array, period: float) -> dict[str, Mask]:
    """Return the masks (N,) of all samples, those in contact and contact-free ones, by name; force:
    (N,) [N], of the sensor; period: [s].
    """
    everywhere = np.ones(len(force), bool)
    return {"all": everywhere, "contact": in_contact(force), "free": is_free(force, period)}


def missed(estimate: Array, force: Array) -> Mask:
    """Return which samples (N,) are in contacts throughout which an estimate is zero.

    estimate: (N, 6), zero while its gate is shut; force: (N,) [N], of the sensor.
    """
    unseen = [span for span in contacts(force) if not estimate[slice(*span)].any()]
    return in_contact(force) & inside_spans(unseen, len(force))


def figures_by_contact(
    estimate: Array, std: Array | None, reference: Array, force: Array, period: float
) -> dict[str, dict[str, Array]]:
    """Return error figures (6,) of a wrench (N, 6) and its standard deviation, by period.

    The periods are "all", "contact", "free", and, with std, "missed" contacts. reference: the
    sensor's wrench (N, 6), NaN where it is saturated; force: (N,) [N], of the sensor, which defines
    contacts; period: [s]. Samples without an estimate or a reading are excluded; a period of which
    all samples are excluded has no figures.
    """
    finite = np.isfinite(estimate).all(axis=1) & np.isfinite(reference).all(axis=1)
    parts = periods(force, period)
    if std is not None:
        parts["missed"] = missed(estimate, force)
    known = {name: rows for name, within in parts.items() if (rows := within & finite).any()}
    figures = {
        name: error_figures(estimate[rows], None if std is None else std[rows], reference[rows])
        for name, rows in known.items()
    }
    if "free" in known:
        half = np.quantile(np.abs(reference - estimate)[known["free"]], BAND_COVERAGE, axis=0)
        for name, rows in known.items():
            even = interval_score(estimate[rows], half / NORMAL95, reference[rows])
            figures[name]["even_interval_score95"] = even
    if "contact" in figures:
        figures["contact"] |= resampled_figures(estimate, reference, force)
        if std is not None:
            own = mean_parts(error_parts(estimate, reference, force))
            figures["contact"] |= {name: own[name] for name in SPLIT}
    return figures


def error_parts(estimate: Array, reference: Array, force: Array) -> dict[str, Array]:
    """Return the absolute error (N, K) of each sample in contact, and its parts by cause; NaN in
    other samples.

    mae: the whole; mae_missed: in missed contacts; mae_shut: in found contacts while the gate is
    shut; mae_gain: what one gain for the whole recording would remove. The rest is friction.
    estimate: (N, K), zero while its gate is shut; reference: (N, K), the sensor's.
    """
    known = np.isfinite(estimate).all(axis=1) & np.isfinite(reference).all(axis=1)
    within, felt = known & in_contact(force), np.asarray(estimate.any(axis=1))
    lost = missed(estimate, force)
    error = np.where(within[:, None], np.abs(reference - estimate), np.nan)
    gain = slope(estimate[within & felt], reference[within & felt])
    scaled = np.abs(reference - estimate / np.where(gain > MIN_GAIN, gain, 1.0))
    return {
        "mae": error,
        "mae_missed": error * lost[:, None],
        "mae_shut": error * (~lost & ~felt)[:, None],
        "mae_gain": (error - scaled) * felt[:, None],
    }


def mean_parts(parts: dict[str, Array], rows: slice = slice(None)) -> dict[str, Array]:
    """Return the mean (K,) of each part of an error over the samples that have one; negative means
    become zero.
    """
    known = np.isfinite(parts["mae"][rows]).all(axis=1)
    count = max(int(known.sum()), 1)
    return {
        name: np.maximum(part[rows][known].sum(axis=0) / count, 0.0) for name, part in parts.items()
    }


def error_figures(estimate: Array, std: Array | None, reference: Array) -> dict[str, Array]:
    """Return error figures of each column (6,), with those of an estimate that is always zero."""
    zero = np.zeros_like(reference)
    mean = mean_absolute_error(zero, reference)
    figures = {
        "mae": mean_absolute_error(estimate, reference),
        "max": largest_error(estimate, reference),
        "zero_mae": mean,
        "zero_max": largest_error(zero, reference),
        "mean_force": mean,
        "slope": np.where(mean < MIN_MEAN[: len(mean)], np.nan, slope(estimate, reference)),
        "skill": skill(estimate, reference),
        "correlation": correlation(estimate, reference),
        "zero_interval_score95": zero_interval_score(reference),
    }
    if std is not None:
        figures["width95"] = 2 * NORMAL95 * np.nanmean(std, axis=0)
        figures["interval_score95"] = interval_score(estimate, std, reference)
        figures["band_factor95"] = band_factor(estimate, std, reference)
        inside = (np.abs(estimate) <= NORMAL95 * std)[:, :3]  # of the force
        figures["zero_in_band95"] = np.full(len(mean), inside.all(axis=1).mean())
        for stated in NOMINAL_COVERAGES:
            figures[f"coverage{100 * stated:.0f}"] = coverage(estimate, std, reference, stated)
    return figures


def resampled_figures(estimate: Array, reference: Array, force: Array) -> dict[str, Array]:
    """Return 95 % intervals (6,) of the error in contact and the lower end of the skill's, by
    bootstrap.

    estimate, reference: wrenches (N, 6), NaN where unknown; force: (N,) [N], of the sensor. Empty
    with fewer than MIN_CONTACTS.
    """
    columns = estimate.shape[1]
    # |reference - estimate| and |reference|, the error of zero
    errors = np.abs(np.concatenate([reference - estimate, reference + 0 * estimate], axis=1))
    means = resampled_means(errors, force)
    if means is None:
        return {}
    error, zero = means[:, :columns], means[:, columns:]
    low, high = np.quantile(error, INTERVAL_ENDS, axis=0)
    skill_low = np.quantile(1 - error / np.maximum(zero, MIN_DIVISOR), INTERVAL_ENDS[0], axis=0)
    return {"mae_low": low, "mae_high": high, "skill_low": skill_low}


def resampled_means(values: Array, force: Array) -> Array | None:
    """Return means (CONTACT_RESAMPLES, K) of values (N, K) over resamples of whole contacts.

    Rows of NaN are unknown; force: (N,) [N], of the sensor. Whole contacts are drawn, since
    neighbouring samples have similar errors. Every call with the same contacts draws the same ones.
    None with fewer than MIN_CONTACTS.
    """
    finite_in_contact = np.isfinite(values).all(axis=1) & in_contact(force)
    spans = [
        span for span in contacts(force, CONTACT_FORCE) if finite_in_contact[slice(*span)].any()
    ]
    if len(spans) < MIN_CONTACTS:
        return None
    filled = np.where(finite_in_contact[:, None], values, 0.0)
    sums = np.array([filled[a:b].sum(axis=0) for a, b in spans])  # (contacts, K)
    counts = np.array([finite_in_contact[a:b].sum() for a, b in spans])
    # mean = Σ sums / Σ counts of the contacts drawn
    drawn_contacts = np.random.default_rng(0).integers(
        len(spans), size=(CONTACT_RESAMPLES, len(spans))
    )
    return np.asarray(
        sums[drawn_contacts].sum(axis=1) / counts[drawn_contacts].sum(axis=1)[:, None]
    )


def force_errors(
    kind: str, estimate: str, figures: Mapping[str, Mapping[str, Array]]
) -> Iterator[ForceError]:
    """Yield error figures as rows, one for each period and component; kind: of the reference."""
    contact = figures.get("contact", {})
    skills = contact.get("skill_low", contact.get("skill", np.zeros(0)))
    determined = dict(zip(WRENCH, (skills > 0).tolist(), strict=False))
    for during, values in figures.items():
        for k, component in enumerate(WRENCH[: len(values["mae"])]):
            own: Any = {name: float(each[k]) for name, each in values.items()}
            yield ForceError(
                kind=kind,
                estimate=estimate,
                during=during,
                component=component,
                determined=determined.get(component),
                **own,
            )


def contact_errors(
    name: str, stated: Stated, reference: Array, force: Array, time: Array
) -> Iterator[ContactError]:
    """Yield for each contact at the sensor a row for each axis, and one for the force vector.

    name: of the estimate; stated: by it; reference: force (N, 3) [N], NaN where the sensor is
    saturated; force: (N,) [N], of the sensor, which defines contacts; time: (N,) [s].
    """
    estimate = stated.wrench[:, :3]
    std = np.full_like(estimate, np.nan) if stated.std is None else stated.std[:, :3]
    estimated_contacts = contacts(np.linalg.norm(estimate, axis=1), CONTACT_FORCE)
    parts = error_parts(estimate, reference, force)
    for number, span in enumerate(contacts(force, CONTACT_FORCE), start=1):
        first, last = span
        e, f = estimate[first:last], reference[first:last]
        start, end = float(time[first]), float(time[last - 1])
        step = (end - start) / max(last - first - 1, 1)
        about: Any = {"estimate": name, "contact": number, "start_s": start, "end_s": end}
        for axis, component in enumerate(WRENCH[:3]):
            own = _peak_and_impulse(e[:, [axis]], f[:, [axis]], step)
            yield ContactError(**about, component=component, **own)
        onset = next(
            (begin for begin, stop in estimated_contacts if overlap((begin, stop), span)), None
        )
        means = mean_parts(parts, slice(*span))
        own = {name: float(means[name].mean()) for name in ("mae", "mae_shut", "mae_gain")}
        yield ContactError(
            **about,
            component=WHOLE,
            **_peak_and_impulse(e, f, step),
            **_largest(stated.sharp[first:last], std[first:last]),
            onset_error_s=None if onset is None else float(time[onset]) - start,
            **own,
        )


def _largest(force: Array, std: Array) -> dict[str, Any]:
    """Return the largest force of a contact with half of its 95 % band, None where unknown."""
    names = ("largest", "largest_band")
    known = zip(names, largest_force(force, std), strict=True)
    return {name: None if np.isnan(value) else value for name, value in known}


def _peak_and_impulse(estimate: Array, reference: Array, step: float) -> dict[str, Any]:
    """Return peak and impulse of a contact, each with its error along the sensor's direction.

    estimate, reference: (M, D) [N]; step: [s]. If a sample has no reading, all but `peak` are NaN.
    """
    estimate = estimate + 0 * reference
    # the direction of the sensor at its peak, and of its impulse
    top = reference[np.argmax(np.nan_to_num(np.linalg.norm(reference, axis=1)))]
    peak, impulse = np.linalg.norm(top), np.linalg.norm(step * reference.sum(axis=0))
    along = estimate @ (top / max(peak, MIN_DIVISOR))
    pushed = (
        step * estimate.sum(axis=0) @ (step * reference.sum(axis=0) / max(impulse, MIN_DIVISOR))
    )
    return {
        "peak": float(peak),
        "peak_error": float(along.max() - peak),
        "impulse": float(impulse),
        "impulse_error": float(pushed - impulse),
    }
