"""From motion and rigid-body torque to motor current: k i + b = τ + τ_friction, fitted.

The current is what is predicted, for it carries the noise: i = (τ + τ_friction - b) / k is linear
in 1/k, b/k and the friction coefficients over k. These come from samples in motion; at rest,
friction is whatever holds the joint up to breakaway: what it was before the stop, in some part.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ur5lib.identification import bootstrap
from ur5lib.identification.estimation import (
    Estimate,
    beside_fuller,
    estimate_together,
    physical,
)
from ur5lib.identification.friction import CONSIDERED, FAMILY, PRESLIDING, Term
from ur5lib.identification.prior import JointPrior, Prior
from ur5lib.identification.samples import (
    FEW,
    Record,
    Samples,
    Smooth,
    design,
    joint_samples,
    record_paths,
)
from ur5lib.identification.selection import (
    FEWEST,
    choose_presliding,
    choose_terms,
    held_current,
    left_out_residuals,
)
from ur5lib.timeseries.arrays import Array, Labels, Mask

UNDETERMINED = 0.5  # prior share above which the data do not determine a parameter
CONFLICT = 3.0  # prior standard deviations
COVERED = 0.95
FOLDS = 10  # of cross-fitting
LEAST_FRICTION = 0.1  # Nm
ONE_PATH = (
    "moves along one path only: no further friction term is selected, and the error bars are "
    "untested; record another path"
)


@dataclass(frozen=True)
class JointFit:
    """One joint's map from motion to current.

    presliding: [rad], over which friction turns; held: [A], by which it is more at rest than in
    motion, negative for less; band_moving, band_rest: half of the 95 % band [A] around the
    low-passed current of a recording left out; remarks: what could not be fitted, one sentence
    each.
    """

    terms: tuple[Term, ...]
    estimate: Estimate
    presliding: float
    held: float
    band_moving: float
    band_rest: float
    remarks: tuple[str, ...]

    def names(self) -> list[str]:
        """Of the parameters."""
        return ["torque_constant", "offset", *(n for term in self.terms for n in term.names())]


@dataclass(frozen=True)
class CurrentFit:
    """The six joints' maps; units: the paths, or among few the stretches, they rest on."""

    joints: tuple[JointFit, ...]
    units: int

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """A fit from what `dataclasses.asdict` made of it, by way of JSON."""
        return cls(tuple(_joint_from_plain(joint) for joint in data["joints"]), data["units"])


@dataclass(frozen=True)
class Parameter:
    """One fitted value in SI units; joint 1 to 6; interval: 95 %."""

    joint: int
    name: str
    value: float
    std_error: float
    interval: tuple[float, float]
    prior_share: float
    determined: bool


def fit_currents(
    records: Sequence[Record],
    smooth: Smooth,
    prior: Prior,
    family: Sequence[Term] = FAMILY,
    seed: int = 0,
) -> CurrentFit:
    """Fit all joints over contact-free recordings; choose friction by paths left out.

    smooth: a zero-phase low-pass, at 2 Hz say: above, the measured current is noise.
    """
    alone = [prior.of_joint(joint) for joint in range(6)]
    tried = [joint_samples(records, smooth, family, [way] * 6) for way in PRESLIDING]
    samples = [
        choose_presliding(*pair) for pair in zip(zip(*tried, strict=True), alone, strict=True)
    ]
    terms = [choose_terms(*pair) for pair in zip(samples, alone, strict=True)]
    estimates, units = estimate_together(samples, terms, prior, seed)
    fuller = [(*own, *(term for term in CONSIDERED if term not in own)) for own in terms]
    estimates = [*map(beside_fuller, estimates, estimate_together(samples, fuller, prior, seed)[0])]
    joints = zip(samples, terms, alone, estimates, strict=True)
    return CurrentFit(tuple(_joint_fit(*joint) for joint in joints), units)


def fit_without_each_path(
    records: Sequence[Record], smooth: Smooth, prior: Prior, family: Sequence[Term] = FAMILY
) -> list[tuple[list[str], CurrentFit]]:
    """Fits that have not seen some paths, each after the names of all recordings along these.

    So that nothing that judges comes from what was fitted on. At most FOLDS fits: of many paths,
    several are left out together. None where there is one path only.
    """
    path = record_paths(records)
    if path.max(initial=0) == 0:
        return []
    fits = []
    for fold in range(min(FOLDS, path.max() + 1)):
        out = path % FOLDS == fold
        others = [record for record, left in zip(records, out, strict=True) if not left]
        names = [record.name for record, left in zip(records, out, strict=True) if left]
        fits.append((names, fit_currents(others, smooth, prior, family)))
    return fits


def fit_for(recording: str, friction: Mapping[str, Any]) -> CurrentFit:
    """The fit that has not seen a recording's path, from friction.json; of one path, the only."""
    for fold in friction["left_out"]:
        if recording in fold["recordings"]:
            return CurrentFit.from_plain(fold["fit"])
    return CurrentFit.from_plain(friction["fit"])


def breakaway_torque(fit: CurrentFit) -> Array:
    """Coulomb friction (6,) [Nm], up to which dry friction holds a joint; at least LEAST_FRICTION.

    Of the terms that turn with the direction of motion, those that do not depend on the load.
    """
    place = [names.index("coulomb") for names in (joint.names() for joint in fit.joints)]
    torque = [
        physical(joint.estimate.coefficients)[own]
        for joint, own in zip(fit.joints, place, strict=True)
    ]
    return np.maximum(np.array(torque), LEAST_FRICTION)


def torque_constants(fit: CurrentFit) -> Array:
    """Torque constants (6,) [Nm/A] of the joints."""
    return np.array([1 / joint.estimate.coefficients[0] for joint in fit.joints])


def predict(fit: CurrentFit, record: Record) -> Array:
    """Motor current (N, 6) [A] of a motion without contact; the record's current is not used."""
    currents = []
    for joint, model in enumerate(fit.joints):
        columns, held = design(record, joint, model.terms, model.presliding)
        currents.append(columns @ model.estimate.coefficients + model.held * held)
    return np.stack(currents, axis=1)


def band(fit: CurrentFit, moving: Mask) -> Array:
    """Half of the 95 % band (N, 6) [A] of a low-passed prediction; moving: `smoothed_moving`."""
    in_motion, at_rest = (
        np.array([getattr(joint, name) for joint in fit.joints])
        for name in ("band_moving", "band_rest")
    )
    return np.where(moving, in_motion, at_rest)


def parameters(fit: CurrentFit) -> list[Parameter]:
    """Torque constants [Nm/A], offsets [Nm] and friction coefficients [Nm, Nm s/rad, ...]."""
    rows = []
    for joint, model in enumerate(fit.joints, start=1):
        estimate = model.estimate
        values = physical(estimate.coefficients)
        half = bootstrap.half_width(estimate.std_error, fit.units)
        columns = (values, estimate.std_error, values - half, values + half, estimate.prior_share)
        rows += [
            Parameter(joint, name, value, error, (low, high), share, bool(share < UNDETERMINED))
            for name, value, error, low, high, share in zip(model.names(), *columns, strict=True)
        ]
    return rows


def _joint_from_plain(data: Mapping[str, Any]) -> JointFit:
    numbers = {name: np.array(value, dtype=float) for name, value in data["estimate"].items()}
    bands = {
        name: float("nan") if data[name] is None else data[name]
        for name in ("band_moving", "band_rest")
    }
    return JointFit(
        terms=tuple(Term(**term) for term in data["terms"]),
        estimate=Estimate(**numbers),
        presliding=data["presliding"],
        held=data["held"],
        remarks=tuple(data["remarks"]),
        **bands,
    )


def _joint_fit(
    samples: Samples, terms: tuple[Term, ...], prior: JointPrior, estimate: Estimate
) -> JointFit:
    """What stands beside the estimate of a joint: friction at rest, bands, remarks."""
    coefficients = estimate.coefficients
    residual = left_out_residuals(samples, terms, prior)
    if not np.isfinite(residual).any():  # the only path: of the fit itself, then
        residual = samples.current - samples.design(terms) @ coefficients
    # At rest dry friction holds any torque up to breakaway, and few poses show it.
    sticking = COVERED * max(0.0, float(coefficients[2]))
    return JointFit(
        terms,
        estimate,
        samples.presliding,
        held_current(samples, terms, coefficients),
        _band(residual[samples.moving], samples.record[samples.moving]),
        np.fmax(_band(residual[~samples.moving], samples.record[~samples.moving]), sticking),
        _remarks(samples, estimate, prior),
    )


def _band(residual: Array, record: Labels) -> float:
    """Half of a band that covers COVERED of every recording; NaN where there is none.

    The next recording is as warm as none before: wide enough for the worst will do for most.
    Where all are too short to say so alone, they say it together.
    """
    each = [np.abs(residual[record == one]) for one in np.unique(record)]
    told = [errors for errors in each if len(errors) >= FEWEST] or [np.abs(residual)]
    return max((float(np.quantile(e, COVERED)) for e in told if len(e) >= FEWEST), default=np.nan)


def _remarks(samples: Samples, estimate: Estimate, prior: JointPrior) -> tuple[str, ...]:
    moved = len(np.unique(samples.path[samples.moving]))
    remarks = []
    if moved == 0:
        remarks.append(
            "does not move: its friction is unknown and its torque constant is that of the prior; "
            "record a motion of this joint"
        )
    elif moved == 1:
        remarks.append(ONE_PATH)
    elif moved < FEW:
        remarks.append(
            f"moves along {moved} paths only: the variation between paths is hardly known; "
            "record more paths"
        )
    away = (estimate.coefficients[0] - prior.inverse) / prior.std
    if abs(away) > CONFLICT:
        remarks.append(
            f"torque constant contradicts the known value by {abs(away):.1f} standard deviations: "
            "check columns, units and robot"
        )
    return tuple(remarks)
