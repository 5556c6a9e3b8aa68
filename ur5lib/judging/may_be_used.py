"""Whether a fitted parameter may be used: from the fit, its remarks and the arm alone."""

from collections.abc import Iterator
from dataclasses import fields
from operator import attrgetter
from typing import Any, NamedTuple

from ur5lib.judging.limits import MAX_HALF_INTERVAL
from ur5lib.records.codes import CauseCode
from ur5lib.records.fits import FrictionRow, TorqueConstant
from ur5lib.records.friction import TOTAL, Friction, Parameter
from ur5lib.records.verdicts import Reason, State, Use
from ur5lib.robots.description import Robot
from ur5lib.timeseries.metrics import NORMAL95

OFFSET = "offset"
UNKNOWN = ("prior_only", "undetermined", "no_motion", "unproven")  # nothing says that it is wrong
SAME_VELOCITY = 1.02  # of the fastest sample: no extrapolation
CONSTANT = "torque_constant"  # in a fit, the gain of measured torques has this name, too


class MayBeUsed(NamedTuple):
    """Whether a parameter may be used (yes, no), and the code of the reason against it, or of a
    doubt; "" without any.
    """

    use: Use
    reason: Reason

    @property
    def state(self) -> State:
        """The same as a state of verdicts."""
        if self.use == "yes":
            return "usable" if self.reason else "good"
        return "not determined" if self.reason in UNKNOWN else "do not use"


def may_be_used(
    parameter: Parameter, fitted: Friction, arm: Robot, is_touched: bool = False
) -> MayBeUsed:
    """Return whether a torque constant, a gain, an offset or friction of an arm may be used, and
    why not.

    is_touched: whether a force sensor reads contacts on a recording of the fit.
    """
    if is_touched and fitted.stopped is None:
        return MayBeUsed("no", "touched")
    for reason in _obstacles(parameter, fitted, arm):
        return MayBeUsed("no", reason)
    return MayBeUsed("yes", next(_doubts(parameter, fitted, arm), ""))


def _obstacles(parameter: Parameter, fitted: Friction, arm: Robot) -> Iterator[Reason]:
    """Yield the reasons against the use of a parameter, the gravest first."""
    codes, is_constant = codes_of(fitted, parameter.joint), parameter.name == CONSTANT
    if fitted.stopped is not None:
        yield "stopped"
    if CauseCode.UNLIKELY_CONSTANT in codes:
        yield "unlikely"
    if is_constant and contradicted(fitted, parameter.joint) is not None:
        yield "contradicted"
    if CauseCode.UNPROVEN_FIT in codes:
        yield "unproven"
    # links fitted to the measured efforts scale with these: any constant fits
    if is_constant and arm.links != "known":
        yield "unknown_links"
    if not is_constant and (CauseCode.NO_MOTION in codes or _rests(fitted)):
        yield "no_motion"
    if not parameter.determined:
        yield "prior_only" if parameter.rests_on_prior else "undetermined"


def _doubts(parameter: Parameter, fitted: Friction, arm: Robot) -> Iterator[Reason]:
    """Yield the doubts about a usable parameter, the largest first.

    Friction [Nm] is a current times the joint's constant, and has its doubts.
    """
    if _is_extrapolated(parameter, fitted):
        yield "extrapolated"
    if parameter.name == CONSTANT and _is_far(parameter, fitted):
        yield "far"
    if parameter.name == CONSTANT and _excludes_known(parameter, fitted):
        yield "excludes"
    if parameter.name not in (CONSTANT, OFFSET) and not _has_sure_constant(parameter, fitted, arm):
        yield "constant"
    if parameter.name != OFFSET and _is_imprecise(parameter):
        yield "imprecise"
    if CauseCode.ONE_PATH in codes_of(fitted, parameter.joint):
        yield "one_path"


def codes_of(fitted: Friction, joint: int) -> set[str]:
    """Return the codes of the remarks on a joint, counted from 1."""
    joints = fitted.fit.joints
    return {remark.code for remark in joints[joint - 1].remarks} if joints else set()


def contradicted(fitted: Friction, joint: int) -> float | None:
    """Return a joint's fitted constant if it contradicts the documented one, else None.

    joint: counted from 1.
    """
    joints = fitted.fit.joints
    return joints[joint - 1].contradicted if joints else None


def _rests(fitted: Friction) -> bool:
    """Return whether an arm was fitted only in postures at rest."""
    return bool(fitted.at_rest) and not fitted.from_


def _is_far(constant: Parameter, fitted: Friction) -> bool:
    """Return whether |k - k_documented| > 1.96 σ_documented."""
    known, joint = fitted.known_constants, constant.joint - 1
    if known is None:
        return False
    return bool(abs(constant.value - known.value[joint]) > NORMAL95 * known.std_error[joint])


def _excludes_known(constant: Parameter, fitted: Friction) -> bool:
    """Return whether a constant's 95 % interval excludes the documented one."""
    known, (low, high) = fitted.known_constants, constant.interval
    if known is None:
        return False
    value = known.value[constant.joint - 1]
    return bool(value < low or value > high)


def _is_extrapolated(parameter: Parameter, fitted: Friction) -> bool:
    """Return whether a total is that of a velocity above those of the fit."""
    if not parameter.name.startswith(TOTAL) or fitted.fastest is None:
        return False
    fastest = fitted.fastest[parameter.joint - 1]
    return bool(float(parameter.name.removeprefix(TOTAL)) > SAME_VELOCITY * fastest)


def _has_sure_constant(parameter: Parameter, fitted: Friction, arm: Robot) -> bool:
    """Return whether a joint's constant has no doubt but those that friction has, too."""
    own = (one for one in fitted.parameters if one.name == CONSTANT)
    mine = (may_be_used(one, fitted, arm) for one in own if one.joint == parameter.joint)
    return all(use.reason in ("", "one_path", "unknown_links") for use in mine)


def _is_imprecise(parameter: Parameter) -> bool:
    low, high = parameter.interval
    return bool(high - low >= 2 * MAX_HALF_INTERVAL * abs(parameter.value))


def friction_rows(fitted: Friction, arm: Robot, is_touched: bool = False) -> list[FrictionRow]:
    """Return the rows of torque constants, offsets, friction terms, and total friction at a load.

    A torque constant comes with its prior, and with the fitted value that contradicts this prior;
    is_touched: as of `may_be_used`.
    """
    loads = {} if fitted.load is None else dict(enumerate(fitted.load.tolist(), start=1))
    rows = [FrictionRow(**_values(row, fitted, arm, is_touched)) for row in fitted.parameters]
    rows += [
        FrictionRow(**_values(row, fitted, arm, is_touched), load=loads[row.joint])
        for row in fitted.totals
    ]
    return sorted(rows, key=attrgetter("joint"))


def torque_constants(
    fitted: Friction, arm: Robot, is_touched: bool = False
) -> Iterator[TorqueConstant]:
    """Yield only the torque constants of `friction_rows`, one for each joint with currents."""
    names = [field.name for field in fields(TorqueConstant) if field.name != CONSTANT]
    for row in friction_rows(fitted, arm, is_touched):
        if row.parameter == CONSTANT:
            same = {name: getattr(row, name) for name in names}
            yield TorqueConstant(torque_constant=row.value, **same)


def _values(row: Parameter, fitted: Friction, arm: Robot, is_touched: bool) -> dict[str, Any]:
    """Return the cells of a parameter's row in friction.csv, with `use`, `reason` and `state`."""
    (low, high), joint, known = row.interval, row.joint - 1, fitted.known_constants
    names = ["joint", "value", "std_error", "determined"]
    names += ["prior_share", "arm_share", "day_share", "run_share"]
    found: dict[str, Any] = {name: getattr(row, name) for name in names}
    found |= {"parameter": arm.measured.parameter(row.name), "low": low, "high": high}
    if row.name == CONSTANT and known is not None:
        found |= {"known": float(known.value[joint]), "known_std": float(known.std_error[joint])}
        found |= {"contradicted": contradicted(fitted, row.joint)}
    use = may_be_used(row, fitted, arm, is_touched)
    return found | use._asdict() | {"state": use.state}
