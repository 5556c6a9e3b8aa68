"""Stop signs: what in a recording contradicts the study so much that no forces may be stated."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice

import numpy as np
import pandas as pd

from ur5lib.channels import MOST_JOINTS, columns, joint_count
from ur5lib.errors import Remark, remark
from ur5lib.recordings.arm_checks import (
    MOUNTINGS,
    SURE,
    constants,
    contradictions_by_gravity,
    foreign_mountings,
    likeliest,
)
from ur5lib.recordings.block_means import BlockMeans, fitted_load, size
from ur5lib.recordings.checked import FEWEST, Checked, described
from ur5lib.recordings.checks import MOVES, misread_velocities, recorded
from ur5lib.recordings.current_checks import (
    delayed,
    exchanged_currents,
    foreign_currents,
    turned,
    undeclared_load,
)
from ur5lib.recordings.innovations import CURRENT
from ur5lib.recordings.quality import GIVEN_LOAD, MODELLED, Finding, contradiction
from ur5lib.recordings.target_checks import scaled
from ur5lib.robots.description import Payload, Robot, robot_names
from ur5lib.robots.statics import link_frames, load_torque
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask

CHECKED = {"time", "segment", "interpolated"}.union(  # columns, as far as recorded
    columns("actual_TCP_pose"),
    *(columns(f"actual_{name}", MOST_JOINTS) for name in ("q", "qd", "current")),
    *(columns(f"target_{name}", MOST_JOINTS) for name in ("q", "qd", "current", "moment")),
)
TOOL = 0.01  # m; in right recordings, the tool stays within 0.002 m of its place on the flange
PRECISE = 0.02  # Nm; nothing is explained better
EXPLAINED = 0.1  # share that another arm, a load or a unit may leave to be named as the cause
LIGHT, HEAVY = 0.3, 40.0  # kg; loads that are named as the cause
GIVEN, SHOWN = 0.1, 0.3  # kg; share of what is left that a load explains; at most 0.14 in motion
DEGREES = 180 / np.pi  # of a radian
FRAMES = 20  # in which a joint moves, from which its channels are compared
CLOSER = 0.5  # a pair closer by this factor than the targets; in right recordings, none is by 0.95
SMOOTHER = 0.3  # actual_current is at least 15 times as rough as target_current in right recordings
EQUAL = 0.5  # share of changing values that equal their targets; in right recordings, 0.002 at most
EXCHANGED = {  # which quantities are exchanged, by the pair that fits like targets
    ("actual_q", "target_qd"): ("q",),
    ("target_q", "actual_qd"): ("qd",),
    ("actual_q", "actual_qd"): ("q", "qd"),
}


def stop_signs(checked: Checked) -> list[Finding]:
    """Return the stop signs of a recording, of which the columns CHECKED are enough."""
    if copied := [*_equal_to_targets(checked.robot, checked.step)]:
        return [contradiction("simulated", names=copied)]  # nothing else follows from it
    channels = [*_motion(checked.robot), *_current(checked.robot)]
    of_channels = [contradiction("exchanged channels", name=name) for name in channels]
    return [*of_channels, *islice(_contradictions(checked), 1)]  # others follow from the first


def _contradictions(checked: Checked) -> Iterator[Finding]:
    """Yield what contradicts the arm and what it carries, the strongest evidence first."""
    robot, arm, loaded = checked.robot, checked.arm, checked.loaded
    yield from misread_velocities(robot, checked.step)
    means = checked.means
    if len(means.q) < FEWEST:
        return
    yield from foreign_torque(means, arm, [checked.configured, checked.declared])
    yield from tool_off_flange(robot, arm)
    if checked.answers is not None:  # whatever arm and units are
        yield from delayed(checked.answers, checked.driven)
        yield from exchanged_currents(checked.answers)
    if checked.tells_by_gravity() and means.torque is None:  # which has shown arm and joints
        shown = means, loaded, checked.others, checked.fitted, checked.driven
        yield from contradictions_by_gravity(*shown)
    else:
        yield from _mounting(checked)
        yield from foreign_currents(means, loaded)
    if checked.answers is not None and checked.driven:
        yield from turned(means, loaded)
        yield from scaled(means, checked.odd_targets)
    if checked.fitted:  # elsewhere, the fit finds an undeclared load
        known = arm.carrying(checked.configured)
        yield from undeclared_load(means, known, loaded, checked.odd_targets)


def given_load(checked: Checked) -> Iterator[Finding]:
    """Warn of a load in `target_moment` that neither the study nor the recording names."""
    means, torque = checked.means, checked.means.torque
    if torque is not None and len(means.q) >= FEWEST:
        payloads = [checked.configured, checked.declared]
        residual = _least_residual(means, torque, checked.arm, payloads)
        mass, left = _as_load(means, residual, checked.arm)
        if GIVEN < mass < HEAVY and left**2 < (1 - SHOWN) * size(residual) ** 2:
            yield Finding("robot", GIVEN_LOAD, "warning", 1, {"mass": mass})


def _as_load(means: BlockMeans, residual: Array, arm: Robot) -> tuple[float, float]:
    """Return the mass [kg] of the load that explains torques (M, 6) best, and what is left."""
    load = load_torque(arm, means.q)
    columns = [means.beside_inertia(load[:, :, k]).ravel() for k in range(4)]
    return fitted_load(np.stack(columns, axis=1), residual.ravel())


def _mounting(checked: Checked) -> Iterator[Finding]:
    """Find another mounting; a push at rest is like one, but for torque constants that none has."""
    means, loaded = checked.means, checked.loaded
    if CURRENT not in means.currents or loaded.senses_torque():
        return
    if checked.tells_by_gravity() or constants(means, loaded).off():
        yield from likeliest(foreign_mountings(means, loaded, checked.driven))


def _equal_to_targets(robot: pd.DataFrame, step: float) -> Iterator[str]:
    """Yield what equals its targets to the last bit: positions of moving joints, and currents.

    At rest, coarse positions of a real arm may do so. step: between frames [s].
    """
    for name, least in (("q", MOVES * step), ("current", 0.0)):
        if recorded(robot, f"actual_{name}", f"target_{name}"):
            actual, target = (_received(robot, f"{kind}_{name}") for kind in ("actual", "target"))
            changes = (np.abs(np.diff(target, axis=0)) > least) & (target[1:] != 0)
            if changes.sum() >= FRAMES and np.mean((actual == target)[1:][changes]) > EQUAL:
                yield f"actual_{name}"


def _received(robot: pd.DataFrame, name: str) -> Array:
    """Return a channel of the frames that were received."""
    return channel(robot, name)[~robot["interpolated"].to_numpy()]


def _motion(robot: pd.DataFrame) -> tuple[str, ...]:
    """Return which of q and qd are exchanged: another pair is closer than that of the targets."""
    if not recorded(robot, "actual_q", "actual_qd", "target_q", "target_qd"):
        return ()
    measured, target = (np.abs(_received(robot, f"{kind}_qd")) for kind in ("actual", "target"))
    moves = (measured > MOVES) & (target > MOVES)
    moving = moves.sum(axis=0) >= FRAMES
    if not moving.any():
        return ()
    own = _apart(robot, moves, "target_q", "target_qd")[moving]
    others = {pair: _apart(robot, moves, *pair)[moving] for pair in EXCHANGED}
    best = min(others, key=lambda pair: float(np.median(others[pair])))
    return EXCHANGED[best] if np.mean(others[best] < CLOSER * own) > 0.5 else ()


def _apart(robot: pd.DataFrame, moves: Mask, position: str, velocity: str) -> Array:
    """Return the median difference (6,) [rad/s] between a position's slope and a velocity.

    moves: (N, 6), the frames that count; NaN for joints without any.
    """
    step = np.diff(robot["time"].to_numpy()[~robot["interpolated"].to_numpy()])[:, None]
    rate = _received(robot, velocity)
    slope = np.diff(_received(robot, position), axis=0) / step
    apart = np.where(moves[1:], np.abs(slope - (rate[1:] + rate[:-1]) / 2), np.nan)
    apart[:, ~moves[1:].any(axis=0)] = 0.0
    return np.asarray(np.nanmedian(apart, axis=0))


def _current(robot: pd.DataFrame) -> Iterator[str]:
    if recorded(robot, "actual_current", "target_current"):
        kinds = ("actual", "target")
        measured, target = (roughness(_received(robot, f"{kind}_current")) for kind in kinds)
        known = (measured > 0) | (target > 0)
        if known.any() and np.mean(measured[known] < SMOOTHER * target[known]) > 0.5:
            yield "current"


def roughness(values: Array) -> Array:
    """Return the median size (6,) of third differences of (N, 6), noise more than motion; NaN of
    fewer than four samples.
    """
    if len(values) < 4:
        return np.full(values.shape[1], np.nan)
    return np.asarray(np.nanmedian(np.abs(np.diff(values, 3, axis=0)), axis=0))


def tool_off_flange(robot: pd.DataFrame, arm: Robot) -> Iterator[Finding]:
    """Find a tool that does not stay at its place on the flange; robot: a repaired table."""
    if "actual_TCP_pose_0" not in robot:
        return
    frames = robot.loc[
        ~robot["interpolated"], columns("actual_TCP_pose") + columns("actual_q", joint_count(robot))
    ]
    frames = frames.dropna(subset=["actual_TCP_pose_0", "actual_q_0"])
    frames = frames.iloc[:: max(1, len(frames) // 1000)]
    rotation, origin = link_frames(arm, channel(frames, "actual_q"))
    away = channel(frames, "actual_TCP_pose")[:, :3] - origin[:, -1]
    place = np.einsum("nij,ni->nj", rotation[:, -1], away)
    apart = float(np.median(np.linalg.norm(place - np.median(place, axis=0), axis=1)))
    if apart > TOOL:
        yield contradiction("tool off flange", arm=arm.name, distance_mm=1000 * apart)


def foreign_torque(
    means: BlockMeans, arm: Robot, payloads: Sequence[Payload | None]
) -> Iterator[Finding]:
    """Find a target_moment that is not the arm's; payloads: those that it may contain."""
    torque = means.torque
    if torque is None:
        return
    residual = _least_residual(means, torque, arm, payloads)
    share = size(residual) / size(torque)
    foreign, known = share > MODELLED, (means, torque, arm)
    arms = [*(_fitting_arms(*known) if foreign else _likelier_arms(*known, payloads))]
    if foreign or arms:
        fitting = [*arms, *_other_causes(means, torque, residual, arm)]
        code = "other torque of known cause" if fitting else "other torque"
        yield contradiction(code, arm=arm.name, share=share, causes=fitting)


def is_foreign(
    means: BlockMeans, torque: Array, arm: Robot, payloads: Sequence[Payload | None]
) -> bool:
    """Return whether a torque (M, 6) [Nm] cannot be that of an arm with any of some payloads."""
    return size(_least_residual(means, torque, arm, payloads)) > MODELLED * size(torque)


def _least_residual(
    means: BlockMeans, torque: Array, arm: Robot, payloads: Sequence[Payload | None]
) -> Array:
    return min((_residual(means, torque, arm.carrying(own)) for own in payloads), key=size)


def _residual(means: BlockMeans, torque: Array, arm: Robot) -> Array:
    """Return what neither the arm's gravity nor its inertia explains of a torque (M, 6) [Nm]."""
    return means.beside_inertia(torque - means.gravity(arm))


def _fits(means: BlockMeans, torque: Array, arm: Robot) -> bool:
    """Return whether an arm leaves so little of a torque (M, 6) [Nm] that it is its own."""
    return size(_residual(means, torque, arm)) < EXPLAINED * size(torque)


def _likelier_arms(
    means: BlockMeans, torque: Array, arm: Robot, payloads: Sequence[Payload | None]
) -> Iterator[Remark]:
    """Yield the described arm that explains the torque best, if it is likelier by far."""
    names = [arm.name, *(name for name in robot_names() if name != arm.name)]
    arms = [arm, *(described(name).mounted(arm.gravity) for name in names[1:])]
    likelihoods = [
        max(_likelihood(means, torque, one.carrying(own)) for own in payloads) for one in arms
    ]
    best = int(np.argmax(likelihoods))
    if likelihoods[best] - likelihoods[0] > SURE:
        yield remark("robot as cause", value=names[best])


def _likelihood(means: BlockMeans, torque: Array, arm: Robot) -> float:
    """Return the log-likelihood of a torque (M, 6) [Nm], each joint with a variance of its own."""
    variance = (_residual(means, torque, arm) ** 2).mean(axis=0) + PRECISE**2
    return float(means.log_likelihood(variance).sum())


def _fitting_arms(means: BlockMeans, torque: Array, arm: Robot) -> Iterator[Remark]:
    """Yield the described arms whose torque it is."""
    for name in robot_names():
        other = described(name).mounted(arm.gravity)
        if len(other.joints) == len(arm.joints) and _fits(means, torque, other):
            yield remark("robot as cause", value=name)


def _other_causes(
    means: BlockMeans, torque: Array, residual: Array, arm: Robot
) -> Iterator[Remark]:
    """Yield the payload, mounting, unit of positions and currents with which a torque is the arm's.

    residual: (M, 6) [Nm], what the arm leaves of the torque.
    """
    mass, left = _as_load(means, residual, arm)
    if LIGHT < mass < HEAVY and left < EXPLAINED * size(torque):
        yield remark("load as cause", value=mass)
    for gravity in MOUNTINGS:
        if _fits(means, torque, arm.mounted(gravity)):
            yield remark("mounting as cause", value=[*gravity])
    for unit, factor in (("rad", DEGREES), ("deg", 1 / DEGREES)):
        if _fits(replace(means, q=factor * means.q), torque, arm):
            yield remark("unit as cause", value=unit)
    for name, current in means.currents.items():
        if _fits(means, current, arm):
            yield remark("column as cause", value=name)
