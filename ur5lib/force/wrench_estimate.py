"""The contact wrench over a recording, its band, and the odds of contact.

tau_ext = J^T F + b + e, with the background b and the fast error e of `ResidualModel`, but for what
gears and dry friction take of J^T F. The gate estimates the times of contact and b; the magnitude
of each contact follows from its own samples.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.ndimage import binary_dilation, gaussian_filter1d

from ur5lib.force.contact_place import jacobian_at, std_at_flange, wrench_at_flange
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.contact_wrench import (
    ContactWrench,
    contact_wrench,
    least_squares_wrench,
    static_wrench,
)
from ur5lib.force.external_torque import finite_rows, is_still
from ur5lib.force.force_input import MEAN_STICTION, ForceInput, mean_stiction_torque
from ur5lib.force.gate import (
    Observations,
    contact_probabilities,
    diagonal,
    find_contacts,
    log_odds,
)
from ur5lib.force.missed_contacts import (
    MISSED_DEVIATIONS,
    missed_contacts,
    mixture_std,
    probability_while_shut,
)
from ur5lib.force.residual_model import ResidualModel
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.sampling import interpolated, thinning
from ur5lib.timeseries.segments import Span, inside_spans, spans, unbroken

OPENING_PROBABILITY = 0.5  # a contact reaches it
CLOSING_PROBABILITY = 0.1  # a contact lasts while above it
CONTACT_MARGIN = 0.15  # s; a contact is extended this long at both ends
MIN_PROBABILITY_INSIDE = 0.999  # inside a contact, its probability is at least this
# Standard deviation of the window that averages forces at rest, in periods of the low-pass.
REST_SMOOTHING_PERIODS = 0.4


class StretchEstimate(NamedTuple):
    """The estimate at the thinned samples (n,) of a part without a gap; fields as in
    WrenchEstimate.
    """

    wrench: Array
    std: Array
    log_odds: Array
    background: Array
    least_squares: Array
    least_squares_std: Array


class AtAllSamples:
    """A quantity of the thinned estimates, interpolated linearly at all samples within each part
    without a gap.
    """

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, estimates: "WrenchEstimate", owner: type) -> Array:
        return at_all_samples(
            [(rows, getattr(estimate, self._name)) for rows, estimate in estimates.stretches],
            estimates.every,
        )


def at_all_samples(stretches: Iterable[tuple[slice, Array]], every: int) -> Array:
    """Return a quantity (N, ...) of parts without a gap, interpolated between their thinned
    samples.

    stretches: each part's rows, and the values at every n-th of these; every: n.
    """
    parts = []
    for rows, thinned in stretches:
        at = np.arange(rows.stop - rows.start)
        thinned_at = every * np.arange(len(thinned))
        columns = interpolated(at, thinned_at, thinned.reshape(len(thinned), -1))
        parts.append(columns.reshape(len(at), *thinned.shape[1:]))
    return np.concatenate(parts)


@dataclass(frozen=True)
class WrenchEstimate:
    """The wrench of the environment on the arm, base axes, at the origin of the last frame.

    wrench, std: (N, 6) [N, Nm]; wrench ± 1.96 std is the 95 % band; log_odds: (N,), of contact,
    given all samples; background: (N, n) [Nm], slow part of the external torque; least_squares,
    least_squares_std: (N, 6) [N, Nm], the wrench of the same contacts without a prior: NaN in them
    where the torque is unknown, zero elsewhere. NaN where the arm's pose is unknown. Each quantity
    is interpolated when it is asked for: those of a long recording take a gigabyte together.
    stretches: parts without a gap, each with its rows and its estimate at every n-th of these;
    every: n.
    """

    stretches: list[tuple[slice, StretchEstimate]]
    every: int
    wrench = AtAllSamples()
    std = AtAllSamples()
    log_odds = AtAllSamples()
    background = AtAllSamples()
    least_squares = AtAllSamples()
    least_squares_std = AtAllSamples()


def used_rows(segment: Labels, period: float, cutoff: float) -> Labels:
    """Return the numbers (M,) of the rows that an estimate uses: every n-th, from the first of each
    part without a gap.

    cutoff: of the torque's low-pass [Hz].
    """
    stride = thinning(period, cutoff)
    return np.concatenate([np.arange(rows.start, rows.stop, stride) for rows in unbroken(segment)])


def estimate_wrench(
    run: ForceInput,
    jacobian: Array,
    model: ResidualModel,
    prior: ContactPrior,
    place: Array | None = None,
) -> WrenchEstimate:
    """Return the contact wrench of a run, each part without a gap estimated from all of its samples
    (offline).

    run: with a low-passed torque, and states of `model`; unknown friction of its gears counts as
    none; jacobian: (M, 6, n), at `used_rows`, NaN where the arm's pose is unknown; place: (M, 3)
    [m], where contacts are assumed, from the origin of frame 6, base axes; None for that origin.
    """
    place = np.zeros((len(jacobian), 3)) if place is None else place
    estimates, start = [], 0
    for rows, observations in _thinned(run, jacobian_at(jacobian, place), model, prior):
        end = start + len(observations.torque)
        estimate = _at_flange(_estimate(observations), place[start:end])
        start = end
        for quantity in estimate:
            quantity[~observations.posed] = np.nan
        estimates.append((rows, estimate))
    return WrenchEstimate(estimates, thinning(run.period, model.cutoff))


def contact_log_odds(
    run: ForceInput, added: Array, jacobian: Array, model: ResidualModel, prior: ContactPrior
) -> list[Array]:
    """Return only the log-odds (N,) of contact, with each of some additional external torques (R,
    N, n) [Nm]; other arguments as of `estimate_wrench`.
    """
    every = thinning(run.period, model.cutoff)
    odds: list[list[tuple[slice, Array]]] = [[] for _ in added]
    for rows, observations in _thinned(run, jacobian, model, prior):
        torques = observations.torque + added[:, rows.start : rows.stop : every]
        for own, probability in zip(
            odds, contact_probabilities(observations, torques), strict=True
        ):
            own.append((rows, np.where(observations.posed, log_odds(probability), np.nan)))
    return [at_all_samples(own, every) for own in odds]


def _thinned(
    run: ForceInput, jacobian: Array, model: ResidualModel, prior: ContactPrior
) -> Iterator[tuple[slice, Observations]]:
    """Yield, for each part without a gap, its rows and its observations at every n-th of these."""
    stride, start = thinning(run.period, model.cutoff), 0
    for rows in unbroken(run.segment):
        part = run.thinned(stride, slice(rows.start, rows.stop, stride))
        end = start + len(part.states)
        yield rows, Observations.of(part, jacobian[start:end], model, prior)
        start = end


def _estimate(observations: Observations) -> StretchEstimate:
    """Return the wrench of one part without a gap, at its thinned samples."""
    torque, period, noise = observations.torque, observations.period, observations.noise
    model, prior = observations.model, observations.prior
    # p(contact), the background b, and the spans of contacts
    probability, background = find_contacts(observations)
    contacts = contact_spans(probability, period)
    inside = inside_spans(contacts, len(torque))
    likely = np.where(inside, np.maximum(probability, MIN_PROBABILITY_INSIDE), probability)  # (n,)
    # Jᵀ F = what gears and dry friction leave of it, τ - b, put right, and its variances
    carried, share = observations.gears.contact_torque(torque - background.mean)
    carried += noise.still * mean_stiction_torque(carried, model.breakaway, model.stiction)
    hidden = np.where(noise.still, 1 - MEAN_STICTION**2, 1.0) * noise.hidden
    slow = np.linalg.diagonal(background.covariance)
    covariance = diagonal(share**2 * (noise.quick + slow + hidden))  # S
    # F of each contact: F̂ᵐᵃᵖ, and least squares without a prior
    if model.sensed:  # at the links: no gear takes part of a contact
        prior = replace(prior, load_friction=0.0)
    lossy = replace(prior, load_friction=np.hypot(prior.load_friction, model.constants_doubt))
    map_estimate, least_squares = (ContactWrench(*np.zeros((2, len(torque), 6))) for _ in range(2))
    for span in contacts:
        part = slice(*span)
        samples = carried[part], observations.jacobian[part], covariance[part]
        posterior_wrench = contact_wrench(*samples, observations.worth, lossy)
        map_estimate.mean[part], map_estimate.variance[part] = posterior_wrench
        least_squares.mean[part], least_squares.variance[part] = least_squares_wrench(*samples)
    shut = _std_while_shut(observations, probability, inside)
    std = std_in_contact(likely, map_estimate, model.doubt, shut)
    resting = inside & noise.still.all(axis=1) & finite_rows(torque)
    rest_samples = REST_SMOOTHING_PERIODS / (model.cutoff * period)
    return StretchEstimate(
        wrench=smoothed(likely[:, None] * map_estimate.mean, resting, rest_samples),
        std=np.hypot(
            np.where(inside[:, None], std, shut), _slow_press(observations, background.mean)
        ),
        log_odds=log_odds(probability),
        background=background.mean,
        least_squares=least_squares.mean,
        least_squares_std=np.sqrt(least_squares.variance),
    )


def _at_flange(estimate: StretchEstimate, place: Array) -> StretchEstimate:
    """Return the estimate with its wrenches at the origin of frame 6; place: (n, 3) [m]."""
    return estimate._replace(
        wrench=wrench_at_flange(estimate.wrench, place),
        std=std_at_flange(estimate.std, place),
        least_squares=wrench_at_flange(estimate.least_squares, place),
        least_squares_std=std_at_flange(estimate.least_squares_std, place),
    )


def smoothed(wrench: Array, resting: Mask, samples: float) -> Array:
    """Return a wrench (n, 6) averaged over the samples at rest; resting: which these are (n,);
    samples: standard deviation of the normal window.

    In contact at rest, friction sticks and slips, and torques jump where the force does not.
    """
    weighted = np.where(resting[:, None], np.hstack([wrench, np.ones((len(wrench), 1))]), 0.0)
    sums = gaussian_filter1d(weighted, samples, axis=0, mode="constant")
    averaged = wrench.copy()
    averaged[resting] = sums[resting, :-1] / sums[resting, -1:]
    return averaged


def std_in_contact(likely: Array, contact: ContactWrench, doubt: float, shut: Array) -> Array:
    """Return the standard deviation σ (n, 6) [N, Nm] in contact, with ± 1.96 σ as its 95 % band.

    likely: (n,), probability p of contact; contact: the wrench F̂ in contact; doubt: factor on its
    deviation if few paths were fitted; shut: (n, 6), deviation of a free arm.
    """
    # mixture of contact (p) and free (1 - p): E[F] = p F̂, E[F²] = p (var + F̂²) + (1 - p) var_free
    p = likely[:, None]
    second = p * (doubt**2 * contact.variance + contact.mean**2) + (1 - p) * shut**2
    return np.asarray(np.sqrt(np.maximum(second - (p * contact.mean) ** 2, 0.0)))


def contact_spans(probability: Array, period: float) -> list[Span]:
    """Return the spans of contacts by their probability (N,), extended by CONTACT_MARGIN [s] at
    both ends.

    period: [s].
    """
    in_contact = inside_spans(
        spans(probability, OPENING_PROBABILITY, CLOSING_PROBABILITY), len(probability)
    )
    reach = np.ones(2 * round(CONTACT_MARGIN / period) + 1, bool)
    return spans(binary_dilation(in_contact, reach).astype(float), 0.5, 0.5)


def _slow_press(observations: Observations, background: Array) -> Array:
    """Return the wrench (n, 6) of a slow press that would cause the background (n, joints) [Nm],
    times the model's doubt.

    It widens the band while the whole arm rests without a tare; zero elsewhere.
    """
    resting = is_still(observations.states)
    wrench = np.zeros((len(background), 6))
    if resting.any():
        std = np.sqrt(observations.noise.spread[resting])
        wrench[resting], _ = static_wrench(
            background[resting],
            std,
            observations.jacobian[resting],
            observations.prior.force,
        )
    return observations.model.doubt * wrench


def _std_while_shut(observations: Observations, contact_probability: Array, inside: Mask) -> Array:
    """Return σ (n, 6) while the gate is shut, with which ± 1.96 σ is the 95 % band of the wrench.

    The band is that of a mixture of a free arm, with a force that does not count as contact, and a
    missed contact. contact_probability: probability of contact by the gate (n,); inside: which
    samples are in contacts (n,).
    """
    model, prior = observations.model, observations.prior
    hidden = (model.doubt * MISSED_DEVIATIONS) ** 2 * observations.noise.hiding()
    share, variance = missed_contacts(observations.jacobian, hidden, prior)
    probability = probability_while_shut(share, inside, observations.period, prior)
    free_variance = np.diagonal(observations.quiet)
    return mixture_std(
        np.maximum(probability, contact_probability[:, None]), variance, free_variance
    )
