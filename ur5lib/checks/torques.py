"""Checks of the controller's torque, `target_moment`: whether it is that of the arm and load."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ur5lib.checks.arm import MIN_LEAD_OF_ARM, MOUNTINGS, mounting_as_cause, robots_as_cause
from ur5lib.checks.block_means import BlockMeans, fitted_load, size
from ur5lib.checks.checked import MIN_BLOCKS, Checked, arms_alike
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import MAX_SHARE_UNMODELLED, Finding, contradiction
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.statics import load_torque
from ur5lib.timeseries.arrays import Array

TORQUE_NOISE = 0.02  # Nm; nothing is explained better
# Another arm, a load or a unit that leaves more is not named as the cause.
MAX_SHARE_LEFT_BY_CAUSE = 0.1
MIN_LOAD, MAX_LOAD = 0.3, 40.0  # kg; loads that are named as the cause
MIN_GIVEN_LOAD = 0.1  # kg
# Share of what is left that a load explains. It is at most 0.14 in right recordings in motion.
MIN_SHARE_EXPLAINED_BY_GIVEN_LOAD = 0.3
DEGREES_PER_RADIAN = 180 / np.pi


def foreign_torque(
    means: BlockMeans, arm: Robot, payloads: Sequence[Payload | None]
) -> Iterator[Finding]:
    """Find a target_moment that is not the arm's; payloads: those that it may contain."""
    torque = means.torque
    if torque is None:
        return
    residual = _least_residual(means, torque, arm, payloads)
    share = size(residual) / size(torque)
    foreign = share > MAX_SHARE_UNMODELLED
    if foreign:
        arms = _fitting_arms(means, torque, arm)
    else:
        arms = [*_likelier_arms(means, torque, arm, payloads)]
    if foreign or arms:
        fitting = [*arms, *_other_causes(means, torque, residual, arm)]
        yield _other_torque(arm, share, fitting)


def _other_torque(arm: Robot, share: float, fitting: Sequence[str]) -> Finding:
    """Return the stop sign; share: of the torque's size that the arm leaves unexplained; fitting:
    causes that would explain it.
    """
    cause = f", where {' or '.join(fitting)} would fit" if fitting else ""
    detail = (
        f"target_moment differs from the torque of {arm.name} by {number(share, '.0%')} of its "
        f"size{cause}; correct `robot`, `gravity`, `payload`, or columns and units"
    )
    one, other = CauseCode.OTHER_TORQUE_OF_KNOWN_CAUSE, CauseCode.OTHER_TORQUE
    return contradiction(one if fitting else other, "robot", detail)


def is_foreign(
    means: BlockMeans, torque: Array, arm: Robot, payloads: Sequence[Payload | None]
) -> bool:
    """Return whether a torque (M, 6) [Nm] cannot be that of an arm with any of the payloads."""
    return size(_least_residual(means, torque, arm, payloads)) > MAX_SHARE_UNMODELLED * size(torque)


def given_load(checked: Checked) -> Iterator[Finding]:
    """Warn of a load in `target_moment` that neither the study nor the recording names."""
    means, torque = checked.means, checked.means.torque
    if torque is not None and len(means.q) >= MIN_BLOCKS:
        residual = _least_residual(means, torque, checked.arm, checked.payloads)
        mass, left = _as_load(means, residual, checked.arm)
        explained = left**2 < (1 - MIN_SHARE_EXPLAINED_BY_GIVEN_LOAD) * size(residual) ** 2
        if MIN_GIVEN_LOAD < mass < MAX_LOAD and explained:
            detail = (
                f"target_moment contains a load of {mass:.2f} kg that neither the study nor the "
                "recording names: declare it as `payload` if the arm carries it; link models are "
                "compared without it"
            )
            yield Finding("robot", Found.GIVEN_LOAD, "warning", 1, detail)


def _as_load(means: BlockMeans, residual: Array, arm: Robot) -> tuple[float, float]:
    """Return the mass [kg] of the load that explains torques (M, 6) [Nm] best, and the norm of what
    it leaves.
    """
    load = load_torque(arm, means.q)
    columns = [means.beside_inertia(load[:, :, k]).ravel() for k in range(4)]
    return fitted_load(np.stack(columns, axis=1), residual.ravel())


def _least_residual(
    means: BlockMeans, torque: Array, arm: Robot, payloads: Sequence[Payload | None]
) -> Array:
    return min((_residual(means, torque, arm.carrying(payload)) for payload in payloads), key=size)


def _residual(means: BlockMeans, torque: Array, arm: Robot) -> Array:
    """Return what neither the arm's gravity nor its inertia explains of a torque (M, 6) [Nm]."""
    return means.beside_inertia(torque - means.gravity(arm))


def _fits(means: BlockMeans, torque: Array, arm: Robot) -> bool:
    """Return whether a torque (M, 6) [Nm] may be an arm's: little of it is left unexplained."""
    return size(_residual(means, torque, arm)) < MAX_SHARE_LEFT_BY_CAUSE * size(torque)


def _likelier_arms(
    means: BlockMeans, torque: Array, arm: Robot, payloads: Sequence[Payload | None]
) -> Iterator[str]:
    """Yield, as a study's line, the described arm that explains the torque best, if it is likelier
    by far.
    """
    others = [other for other in arms_alike(arm, None) if other.name != arm.name]
    likelihoods = [
        max(_likelihood(means, torque, candidate.carrying(payload)) for payload in payloads)
        for candidate in [arm, *others]
    ]
    best = int(np.argmax(likelihoods))
    if likelihoods[best] - likelihoods[0] > MIN_LEAD_OF_ARM:
        yield from robots_as_cause([others[best - 1].name])


def _likelihood(means: BlockMeans, torque: Array, arm: Robot) -> float:
    """Return the log-likelihood of a torque (M, 6) [Nm], each joint with a variance of its own."""
    variance = (_residual(means, torque, arm) ** 2).mean(axis=0) + TORQUE_NOISE**2
    return float(means.log_likelihood(variance).sum())


def _fitting_arms(means: BlockMeans, torque: Array, arm: Robot) -> list[str]:
    """Return, as a study's lines, the described arms that have this torque."""
    fitting = (one for one in arms_alike(arm, None) if _fits(means, torque, one))
    return robots_as_cause(one.name for one in fitting)


def _other_causes(means: BlockMeans, torque: Array, residual: Array, arm: Robot) -> Iterator[str]:
    """Yield in words each payload, mounting, unit of positions or exchanged column of currents with
    which the torque would be the arm's.

    residual: (M, 6) [Nm], what the arm leaves of the torque.
    """
    mass, left = _as_load(means, residual, arm)
    if MIN_LOAD < mass < MAX_LOAD and left < MAX_SHARE_LEFT_BY_CAUSE * size(torque):
        yield f"a payload of {mass:.1f} kg"
    for gravity in MOUNTINGS:
        if _fits(means, torque, arm.mounted(gravity)):
            yield mounting_as_cause(gravity)
    for unit, factor in (("rad", DEGREES_PER_RADIAN), ("deg", 1 / DEGREES_PER_RADIAN)):
        if _fits(replace(means, q=factor * means.q), torque, arm):
            yield f"actual_q in {unit}"
    for name, current in means.currents.items():
        if _fits(means, current, arm):
            yield f"the column of {name}"
