"""The stop sign of efforts in an unknown unit: what gravity shows of it, and how to end it."""

from ur5lib.channels import CURRENT
from ur5lib.checks.arm import torque_constants
from ur5lib.checks.block_means import BlockMeans
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot

MIN_BLOCKS = 8  # by which gravity shows gains


def unknown_unit(means: BlockMeans, arm: Robot) -> Finding:
    """Return the stop sign of efforts in an unknown unit, with the gains that gravity shows; arm:
    with its payload.
    """
    name, unit = arm.measured.channel, arm.measured.unit
    detail = (
        f"the unit of {name} is unknown, so that no force follows from it: {_gains(means, arm)}; "
        f"name the unit: `ur5 import` with --unit {name}={unit}, m{unit} or the SI value of one "
        "unit of the file, or that of each joint as 0.1,0.2,…, or `units` in the study"
    )
    return contradiction(CauseCode.UNKNOWN_UNIT, "", detail)


def _gains(means: BlockMeans, arm: Robot) -> str:
    """Return in words what one unit of the efforts is, by gravity, and what is expected."""
    enough = len(means.q) >= MIN_BLOCKS and means.has_efforts() and arm.tells_gravity()
    fit = torque_constants(means, arm) if enough else None
    if fit is None or not fit.ratio:
        return "gravity does not show what one unit of it is"
    gains = ", ".join(number(ratio * fit.known[joint], ".3g") for joint, ratio in fit.ratio.items())
    usual = ", ".join(dict.fromkeys(number(fit.known[joint], ".3g") for joint in fit.ratio))
    joints = ", ".join(str(joint + 1) for joint in fit.ratio)
    plural = "s" if len(fit.ratio) > 1 else ""
    side = ": the motors' side, or wrong masses?" if arm.measured != CURRENT else ""
    return (
        f"by gravity, one unit is {gains} Nm on joint{plural} {joints}, where "
        f"1 {arm.measured.unit} would be {usual} Nm{side}"
    )
