"""The rows of the thesis's tables."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ur5lib.records.friction import Friction
from ur5lib.records.signals import Signals, is_led
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import largest_error, mean_absolute_error
from ur5lib.topics.thesis.records import ClosedLoop, GainSummary
from ur5lib.topics.thesis.torque_lines import PublishedConstants

GAIN_UNITS = {"position": "1/s2", "velocity": "1/s"}


@dataclass(frozen=True, kw_only=True)
class LoopError:
    """A row of closed_loop_mae.csv: mean and largest absolute error of a joint in closed loop, in
    q [rad] and qd [rad/s] against the measured motion, in torque [Nm] against the controller's.

    model: of the loop's gains, "target" of the targets themselves.
    """

    model: str
    joint: int
    quantity: str
    mae: float
    max: float


@dataclass(frozen=True, kw_only=True)
class EstimatedGain:
    """A row of gains.csv: K0 (position) or K1 (velocity) of a joint; a value only if the recording
    determines it.

    low, high: of the range that fits equally well, None where it reaches a search bound.
    """

    joint: int
    gain: str
    unit: str
    value: float | None = None
    std_error: float | None = None
    low: float | None
    high: float | None
    determined: bool


@dataclass(frozen=True, kw_only=True)
class PublishedGain:
    """A row of published_gains.csv: whether a model's published gains fit a joint as well as the
    best ones; cost, least_cost, limit: as in `tracking_cost`.
    """

    model: str
    joint: int
    cost: float
    least_cost: float
    limit: float
    fits: bool


@dataclass(frozen=True, kw_only=True)
class TorqueConstant:
    """A row of published_constants.csv: the line of Equation 6.5 of a joint that moves, by one
    direction of regression.

    torque_constant [Nm/A], offset, mean_torque [Nm]; correlation: of torque with current, with and
    without friction.
    """

    regression: str
    joint: int
    torque_constant: float
    torque_constant_std_error: float
    offset: float
    offset_std_error: float
    mean_torque: float
    correlation: float
    correlation_without_friction: float


@dataclass(frozen=True, kw_only=True)
class PrintedFriction:
    """A row of printed_friction.csv: a parameter of a joint's motor and friction as printed.

    parameter: named as in friction.csv; printed: in its unit.
    """

    joint: int
    parameter: str
    printed: float


@dataclass(frozen=True, kw_only=True)
class ListedErratum:
    """An error in the published work, and its treatment here: a row of errata.csv."""

    place: str
    error: str
    choice: str


def loop_errors(loop: ClosedLoop, signals: Signals) -> Iterator[LoopError]:
    """Yield errors in closed loop under each set of gains, and of the targets themselves;
    interpolated frames are left out.
    """
    received = ~signals.interpolated

    def errors(quantity: str, states: Mapping[str, Array], measured: Array) -> Iterator[LoopError]:
        for model, own in states.items():
            pair = own[received], measured[received]
            figures = zip(mean_absolute_error(*pair), largest_error(*pair), strict=True)
            for joint, (mae, most) in enumerate(figures, start=1):
                yield LoopError(model=model, joint=joint, quantity=quantity, mae=mae, max=most)

    for quantity in ("q", "qd") if loop.qd else ():
        target = {"target": getattr(signals, f"target_{quantity}")}
        states = getattr(loop, quantity) | target
        yield from errors(quantity, states, getattr(signals, f"actual_{quantity}"))
    if signals.target_moment is not None and not is_led(signals):
        yield from errors("torque", loop.torque, signals.target_moment)


def estimated_gains(gains: GainSummary) -> Iterator[EstimatedGain]:
    """Yield the gains of the closed loop."""
    for joint, found in enumerate(gains.joints, start=1):
        for name, unit in GAIN_UNITS.items():
            gain = getattr(found, name)
            bounds = gain.grid[0], gain.grid[-1]
            yield EstimatedGain(
                joint=joint,
                gain=name,
                unit=unit,
                value=gain.best if gain.determined else None,
                std_error=gain.std_error if gain.determined else None,
                low=None if gain.low in bounds else gain.low,
                high=None if gain.high in bounds else gain.high,
                determined=gain.determined,
            )


def published_gains(gains: GainSummary) -> Iterator[PublishedGain]:
    """Yield whether published gains fit as well as the best ones, of joints with a moving
    target."""
    for model, costs in gains.published.items():
        for joint, (cost, found) in enumerate(zip(costs, gains.joints, strict=True), start=1):
            if found.excited:
                yield PublishedGain(
                    model=model,
                    joint=joint,
                    cost=cost,
                    least_cost=found.cost,
                    limit=found.limit,
                    fits=bool(cost <= found.limit),
                )


def torque_constants(constants: PublishedConstants) -> Iterator[TorqueConstant]:
    """Yield torque constants and offsets of moving joints by both directions of regression."""
    for regression, line in constants.lines.items():
        for k in np.flatnonzero(np.isfinite(line.torque_constant)):
            yield TorqueConstant(
                regression=regression,
                joint=int(k) + 1,
                torque_constant=line.torque_constant[k],
                torque_constant_std_error=line.torque_constant_std[k],
                offset=line.offset[k],
                offset_std_error=line.offset_std[k],
                mean_torque=constants.mean_torque[k],
                correlation=constants.correlation[k],
                correlation_without_friction=constants.correlation_without_friction[k],
            )


def printed_friction(friction: Friction, arm: Robot) -> Iterator[PrintedFriction]:
    """Yield the printed values of the fitted parameters."""
    published: dict[str, tuple[float, ...]] = {}
    if arm.current_to_torque is not None:
        published["torque_constant"] = tuple(arm.current_to_torque.torque_constant)
        published["offset"] = tuple(arm.current_to_torque.offset)
    if arm.friction is not None:
        published |= {"coulomb": tuple(arm.friction.coulomb)}
        published |= {"viscous": tuple(arm.friction.viscous)}
    for row in friction.parameters:
        if row.name in published:
            yield PrintedFriction(
                joint=row.joint,
                parameter=arm.measured.parameter(row.name),
                printed=published[row.name][row.joint - 1],
            )
