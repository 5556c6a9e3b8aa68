"""The effort of motion without contact, with no measured one: of states, motions, recordings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias, TypedDict, Unpack, overload

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from ur5lib.chain.recordings import Recordings
from ur5lib.chain.steps import Files
from ur5lib.errors import InputError, briefly
from ur5lib.identification.samples import CurrentSamples, Smooth, SteadyStates
from ur5lib.jobs.memory import record_of
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import CurrentFit
from ur5lib.records.motion import SAME_POSTURE, Motion, posture_change
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.friction import usual_at_rest
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import period as period_of

LONGER = 1.5  # a step of this many periods is a gap
NO_MASS = "payload: {}; give a mass [kg], or a mass and its centre (x, y, z) in frame {} [m]"


Angles: TypeAlias = ArrayLike | Recordings
Rates: TypeAlias = ArrayLike | None
Load: TypeAlias = float | tuple[float, Sequence[float]] | None


class Circumstances(TypedDict, total=False):
    """What may be said of a motion; see `Model.torque`."""

    payload: Load
    period: float | None
    after: Rates


class Asked(Protocol):
    """What a method answers: an array, or a pair of arrays where `return_std` is true."""

    @overload
    def __call__(
        self, q: Angles, qd: Rates = None, qdd: Rates = None,
        *, return_std: Literal[False] = False, **more: Unpack[Circumstances],
    ) -> Array: ...  # fmt: skip

    @overload
    def __call__(
        self, q: Angles, qd: Rates = None, qdd: Rates = None,
        *, return_std: Literal[True], **more: Unpack[Circumstances],
    ) -> tuple[Array, Array]: ...  # fmt: skip


def asked(method: Callable[..., Any]) -> Asked:
    """Return a method as it is, with the types of its answers."""
    return method


class Effort(NamedTuple):
    """The effort of a motion without contact and its standard deviation, (N, n) each [A], or [Nm]
    of an arm that measures torques; torque: of motors that this current drives, and its own.
    """

    value: Array
    std: Array
    torque: Array
    torque_std: Array

    def as_torque(self) -> "Effort":
        """Return the torque [Nm] of motors that this current drives."""
        return self._replace(value=self.torque, std=self.torque_std)


@dataclass(frozen=True)
class Fits:
    """The fit of a motion, and the one that has a part in its rest, if one path was fitted."""

    own: CurrentFit
    usual: CurrentFit | None = None


@dataclass(frozen=True)
class States:
    """Joint states (N, n) [rad, rad/s, rad/s²]; time: (N,) [s] of one motion, None of states in any
    order; alone: whether a single state (n,) was given.
    """

    q: Array
    qd: Array
    qdd: Array
    time: Array | None
    alone: bool

    @classmethod
    def of(cls, q: Any, qd: Any, qdd: Any, period: float | None, joints: int) -> "States":
        """Take arrays, or frames of which the index `time` is that of a motion.

        Raises InputError where they are no states of so many joints.
        """
        angles = _array("q", q, "rad", joints)
        rate = _broadcast("qd", qd, "rad/s", joints, angles.shape)
        acceleration = _broadcast("qdd", qdd, "rad/s²", joints, angles.shape)
        rows, rates, accelerations = map(np.atleast_2d, (angles, rate, acceleration))
        return cls(rows, rates, accelerations, _time(q, period, len(rows)), angles.ndim == 1)

    def motion(self) -> Motion:
        """Return them as a motion; without a time, a second apart."""
        time = np.arange(len(self.q), dtype=float) if self.time is None else self.time
        step = np.diff(time, prepend=time[:1])
        gaps = step > LONGER * (np.median(step[1:]) if len(step) > 1 else 1.0)
        nothing = np.zeros_like(self.q)
        return Motion(
            time=time, segment=np.cumsum(gaps), q=self.q, qd=self.qd, qdd=self.qdd, q_std=nothing,
            qd_std=nothing, qdd_std=nothing, motor_qd=self.qd,
        )  # fmt: skip


def effort_of_states(
    states: States,
    arm: Robot,
    fit: Fits,
    lowpass: Butterworth,
    before: Sequence[Motion],
) -> Effort:
    """Return the effort of states, or of a motion by time.

    arm: with its payload; before: the motions before one by time, oldest first.
    """
    from ur5lib.dynamics.link_model import LinkModel  # torch, which takes seconds to load

    model = LinkModel(arm, arm.fullest_model())
    torque = model.inverse_dynamics(states.q, states.qd, states.qdd)
    kind, smooth = CurrentSamples, ends_kept(lowpass)
    if states.time is None:
        kind, smooth = SteadyStates, _as_it_is
    found = _effort(states.motion(), arm, torque, fit, smooth, before, kind)
    return Effort(*(one[0] for one in found)) if states.alone else found


def effort_of_recording(
    own: Files,
    arm: Robot,
    load: Payload | None,
    fit: Fits,
    lowpass: Butterworth,
    before: Sequence[Motion],
    day: str,
) -> Effort:
    """Return the effort of a recording's motion, without its measured one.

    own: its files after `compute_torques`; arm: as mounted; load: that nobody declared; day: its
    date, ISO 8601 or empty.
    """
    from ur5lib.dynamics.link_model import LinkModel

    motion, torques = record_of(Motion, own["motion"]), record_of(Torques, own["torques"])
    torque = torques.measured[arm.fullest_model()] + torques.payload_torque
    if load is not None:
        model, state = arm.fullest_model(), (motion.q, motion.qd, motion.qdd)
        loaded, bare = (LinkModel(one, model) for one in (arm.carrying(load), arm))
        torque = torque + loaded.inverse_dynamics(*state) - bare.inverse_dynamics(*state)
    temperature = record_of(Signals, own["signals"]).joint_temperatures
    return _effort(
        motion, arm, torque, fit, ends_kept(lowpass), before, day=day, temperature=temperature
    )


def _effort(
    motion: Motion,
    arm: Robot,
    torque: Array,
    fit: Fits,
    smooth: Smooth,
    before: Sequence[Motion],
    kind: type[CurrentSamples] = CurrentSamples,
    **known: Any,
) -> Effort:
    from ur5lib.identification.current_samples import motion_samples, with_inertial
    from ur5lib.identification.currents import (  # scipy loads for a while
        band,
        motor_torque,
        predict,
        torque_constants,
    )

    bare = motion_samples("", motion, arm, torque, before, kind)
    samples = with_inertial(replace(bare, **known), arm)
    current, std = predict(fit.own, samples), band(fit.own, samples, smooth) / NORMAL95
    found = Effort(
        current, std, motor_torque(fit.own, current), np.abs(torque_constants(fit.own)) * std
    )
    if fit.usual is None:
        return found
    other = predict(fit.usual, samples)
    torque = motor_torque(fit.usual, other)
    return found._replace(
        value=usual_at_rest(current, other, samples.qd),
        torque=usual_at_rest(found.torque, torque, samples.qd),
    )


def joined(efforts: Sequence[Effort], with_std: bool) -> Any:
    """Return efforts one after the other, (N, n), or (n,) of one state; with their standard
    deviations as a pair.
    """
    value, std = (
        efforts[0][k] if len(efforts) == 1 else np.concatenate([one[k] for one in efforts])
        for k in (0, 1)
    )
    return (value, std) if with_std else value


def _as_it_is(values: Array, _: CurrentSamples) -> Array:
    return values


def ends_kept(lowpass: Butterworth) -> Smooth:
    """Return a low-pass that leaves the ends, where it would extrapolate, as they are."""
    from ur5lib.identification.current_samples import ZeroPhaseLowpass

    def smooth(values: Array, record: CurrentSamples) -> Array:
        smoothed = ZeroPhaseLowpass(*lowpass)(values, record)
        return np.where(np.isnan(smoothed), values, smoothed)

    return smooth


def motion_before(after: Any, own: States, joints: int) -> list[Motion]:
    """Return the motion before another, from its angles (M, n) [rad] in the same steps.

    Raises InputError where the other begins elsewhere, or is none.
    """
    if own.time is None:
        raise InputError(
            "after: states in any order follow nothing; give a frame by time, or period="
        )
    q, step = np.atleast_2d(_array("after", after, "rad", joints)), period_of(own.time)
    qd = np.gradient(q, step, axis=0) if len(q) > 1 else np.zeros_like(q)
    earlier = States(q, qd, 0 * q, step * np.arange(len(q), dtype=float), False).motion()
    moved = np.abs(posture_change(earlier, own.motion())).max()
    if not moved <= SAME_POSTURE:
        raise InputError(
            f"after: that motion ends {moved:.2g} rad from where this one begins; give what was "
            "directly before"
        )
    return [earlier]


def payload_of(given: Any, joints: int) -> Payload | None:
    """Return the load on the flange that a caller states, none of 0 kg: a mass [kg], or (mass,
    centre of mass (3,) [m]). Raises InputError for anything else.
    """
    if given is None:
        return None
    try:
        parts: list[Any] = [given] if isinstance(given, Real) else [*given]
        mass, *center = parts
        x, y, z = map(float, center[0]) if center else (0.0, 0.0, 0.0)
        return Payload(mass=float(mass), center_of_mass=(x, y, z)) if mass != 0 else None
    except (TypeError, ValueError) as error:
        raise InputError(NO_MASS.format(briefly(given), joints)) from error


def _array(name: str, given: Any, unit: str, joints: int) -> Array:
    """Return given numbers as (n,) or (N, n). Raises InputError for anything else."""
    try:
        found = np.array(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name}: {briefly(given)} holds no numbers; give them [{unit}]"
        ) from error
    if found.ndim not in (1, 2) or found.shape[-1] != joints or not found.size:
        raise InputError(
            f"{name} has the shape {np.shape(given)}, but the arm {joints} joints; give "
            f"({joints},) or (N, {joints}) [{unit}]"
        )
    if not np.isfinite(found).all():
        raise InputError(f"{name} has cells that are no numbers; leave these rows out")
    return found


def _broadcast(name: str, given: Any, unit: str, joints: int, shape: tuple[int, ...]) -> Array:
    """Return given numbers in a shape; a single one, as 0, is that of all joints."""
    if given is None:
        raise InputError(
            f"{name} is missing; give {shape} [{unit}], or 0 of an arm that keeps still"
        )
    found = (
        np.full(shape, given, float)
        if isinstance(given, Real)
        else _array(name, given, unit, joints)
    )
    if found.shape != shape:
        raise InputError(f"{name} has the shape {found.shape}, but q {shape}; give one of each q")
    return found


def _time(q: Any, period: float | None, count: int) -> Array | None:
    """Return the times (N,) [s] of a motion: those of a frame's index, or by a period."""
    if period is not None:
        if not (isinstance(period, Real) and 0 < float(period) < np.inf):
            raise InputError(f"period: {briefly(period)}; give the seconds between samples")
        return float(period) * np.arange(count, dtype=float)
    if isinstance(q, pd.DataFrame) and q.index.name == "time":
        return q.index.to_numpy(float)
    return None
