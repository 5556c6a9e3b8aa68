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
)
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.force_input import MEAN_STICTION, ForceInput, mean_stiction_torque
from ur5lib.force.gate import (
    Observations,
    contact_probabilities,
    diagonal,
    find_contacts,
    log_odds,
)
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.touched_link import Samples, touched
from ur5lib.force.while_shut import while_shut
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.kalman import Gaussians
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.sampling import interpolated, thinning
from ur5lib.timeseries.segments import Span, inside_spans, spans, unbroken

OPENING_PROBABILITY = 0.5  # a contact reaches it
CLOSING_PROBABILITY = 0.1  # a contact lasts while above it
CONTACT_MARGIN = 0.15  # s; a contact is extended this long at both ends
MIN_PROBABILITY_INSIDE = 0.999  # inside a contact, its probability is at least this
# Standard deviation of the window that averages forces at rest, in periods of the low-pass: longer
# where so few paths were fitted, or none, that their friction is hardly known.
REST_SMOOTHING_PERIODS = 0.2
FEW_PATHS_SMOOTHING_PERIODS = 0.4
# In contact, part of the force is taken for background: this share of the press that would explain
# it is given back, and this one is in the band.
PRESS_AS_FORCE = 0.3
PRESS_AS_DOUBT = 0.25
MOST = 0.5  # of a contact, with the arm at rest: its link is unknown
LinkFrames = tuple[Array, Array]  # rotations (M, n + 1, 3, 3), origins (M, n + 1, 3) [m]


class StretchEstimate(NamedTuple):
    """The estimate at the thinned samples (n,) of a part without a gap; fields as in
    WrenchEstimate.
    """

    wrench: Array
    std: Array
    unsmoothed: Array
    untouched: Array
    hidden: Array
    hidden_at_all: Array
    log_odds: Array
    background: Array
    least_squares: Array
    least_squares_std: Array
    link: Array
    off_flange: Array


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

    wrench, std: (N, 6) [N, Nm]; wrench ± 1.96 std is the 95 % band; unsmoothed: (N, 3) [N], the
    force before it is averaged at rest, for peaks; untouched, hidden, hidden_at_all: (N, 3) [N], as
    in `WhileShut`; in contacts, half of the 95 % band, and zero. log_odds: (N,), of contact,
    given all samples; background: (N, n) [Nm], slow part of the external torque; least_squares,
    least_squares_std: (N, 6) [N, Nm], the wrench of the same contacts without a prior: NaN in them
    where the torque is unknown, zero elsewhere. link, off_flange: (N,), the likeliest link of a
    contact in motion, from 1, and the probability that it is not the last one; NaN elsewhere. NaN
    where the arm's pose is unknown. Each quantity is interpolated when it is asked for: those of a
    long recording take a gigabyte together. stretches: parts without a gap, each with its rows and
    its estimate at every n-th of these; every: n.
    """

    stretches: list[tuple[slice, StretchEstimate]]
    every: int
    wrench = AtAllSamples()
    std = AtAllSamples()
    unsmoothed = AtAllSamples()
    untouched = AtAllSamples()
    hidden = AtAllSamples()
    hidden_at_all = AtAllSamples()
    log_odds = AtAllSamples()
    background = AtAllSamples()
    least_squares = AtAllSamples()
    least_squares_std = AtAllSamples()
    link = AtAllSamples()
    off_flange = AtAllSamples()


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
    frames: LinkFrames | None = None,
) -> WrenchEstimate:
    """Return the contact wrench of a run, each part without a gap estimated from all of its samples
    (offline).

    run: with a low-passed torque, and states of `model`; unknown friction of its gears counts as
    none; jacobian: (M, 6, n), at `used_rows`, NaN where the arm's pose is unknown; place: (M, 3)
    [m], where contacts are assumed, from the origin of frame 6, base axes; None for that origin;
    frames: rotations (M, n + 1, 3, 3) and origins (M, n + 1, 3) [m] of frames 0 to n, with which
    contacts in motion may be on any link; None for the last one.
    """
    place = np.zeros((len(jacobian), 3)) if place is None else place
    estimates, start = [], 0
    for rows, observations in _thinned(run, jacobian_at(jacobian, place), model, prior):
        end = start + len(observations.torque)
        if frames is not None:
            rotation, origin = (own[start:end] for own in frames)
            seen = origin - (origin[:, -1] + place[start:end])[:, None]
            observations = replace(observations, frames=(rotation, seen))
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
    model = observations.model
    # p(contact), the background b, and the spans of contacts
    probability, background = find_contacts(observations)
    contacts = contact_spans(probability, period)
    inside = inside_spans(contacts, len(torque))
    likely = np.where(inside, np.maximum(probability, MIN_PROBABILITY_INSIDE), probability)  # (n,)
    map_estimate, least_squares, where = _in_contacts(observations, contacts, background)
    shut = while_shut(observations, background.mean, probability, inside)
    std = np.hypot(
        std_in_contact(likely, map_estimate, model.doubt, shut.std),
        PRESS_AS_DOUBT * model.doubt * shut.press,
    )
    resting = inside & noise.still.all(axis=1) & finite_rows(torque)
    within = inside[:, None]
    given_back = np.where(within, PRESS_AS_FORCE * shut.press, 0.0)
    wrench = smoothed(likely[:, None] * map_estimate.mean, resting, _rest_samples(observations))
    return StretchEstimate(
        wrench=wrench + given_back,
        std=np.where(within, std, shut.std),
        unsmoothed=(likely[:, None] * map_estimate.mean + given_back)[:, :3],
        untouched=np.where(within, NORMAL95 * std[:, :3], shut.untouched),
        hidden=np.where(within, 0.0, shut.hidden),
        hidden_at_all=np.where(within, 0.0, shut.hidden_at_all),
        log_odds=log_odds(probability),
        background=background.mean,
        least_squares=least_squares.mean,
        least_squares_std=np.sqrt(least_squares.variance),
        link=where[:, 0],
        off_flange=where[:, 1],
    )


def _in_contacts(
    observations: Observations, contacts: Iterable[Span], background: Gaussians
) -> tuple[ContactWrench, ContactWrench, Array]:
    """Return F̂ᵐᵃᵖ of each contact, and least squares without a prior, zero outside contacts; and
    the likeliest link with the probability of those before the last (n, 2), NaN elsewhere.
    """
    torque, noise, model = observations.torque, observations.noise, observations.model
    # Jᵀ F = what gears and dry friction leave of it, τ - b, put right, and its variances
    carried, share = observations.gears.contact_torque(torque - background.mean)
    carried += noise.still * mean_stiction_torque(carried, model.breakaway, model.stiction)
    hidden = np.where(noise.still, 1 - MEAN_STICTION**2, 1.0) * noise.hidden
    slow = np.linalg.diagonal(background.covariance)
    covariance = diagonal(share**2 * (noise.quick + slow + hidden))  # S
    prior = observations.prior
    if model.sensed:  # at the links: no gear takes part of a contact
        prior = replace(prior, load_friction=0.0)
    lossy = replace(prior, load_friction=np.hypot(prior.load_friction, model.constants_doubt))
    map_estimate, least_squares = (ContactWrench(*np.zeros((2, len(torque), 6))) for _ in range(2))
    where = np.full((len(torque), 2), np.nan)
    for span in contacts:
        part = slice(*span)
        samples = carried[part], observations.jacobian[part], covariance[part]
        posterior_wrench = contact_wrench(*samples, observations.worth, lossy)
        if observations.frames is not None and moves(noise.still[part]):
            frames = (own[part] for own in observations.frames)
            on_arm = Samples(carried[part], covariance[part], *frames)
            if (found := touched(on_arm, posterior_wrench, prior)) is not None:
                posterior_wrench, where[part] = found.wrench, (found.link, found.off_flange)
        map_estimate.mean[part], map_estimate.variance[part] = posterior_wrench
        least_squares.mean[part], least_squares.variance[part] = least_squares_wrench(*samples)
    return map_estimate, least_squares, where


def moves(still: Mask) -> bool:
    """Return whether the arm moves for most of a contact; still: as of `TorqueVariances` (n, k).

    At rest, friction keeps what the wrist carries, so that any contact looks like one before it.
    """
    return bool(still.all(axis=1).mean() < MOST)


def _rest_samples(observations: Observations) -> float:
    """Return the standard deviation, in samples, of the window that averages forces at rest."""
    few = observations.model.doubt > 1 or observations.model.usual
    periods = FEW_PATHS_SMOOTHING_PERIODS if few else REST_SMOOTHING_PERIODS
    return periods / (observations.model.cutoff * observations.period)


def _at_flange(estimate: StretchEstimate, place: Array) -> StretchEstimate:
    """Return the estimate with its wrenches at the origin of frame 6; place: (n, 3) [m]."""
    quantities = estimate._asdict()
    wrenches = {name: quantities[name] for name in ("wrench", "least_squares")}
    stds = {name: quantities[name] for name in ("std", "least_squares_std")}
    return estimate._replace(
        **{name: wrench_at_flange(own, place) for name, own in wrenches.items()},
        **{name: std_at_flange(own, place) for name, own in stds.items()},
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
