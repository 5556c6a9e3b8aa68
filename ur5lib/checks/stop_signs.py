"""Stop signs: what in a recording contradicts the study so much that no forces may be stated."""

from collections.abc import Container, Iterator, Sequence

from ur5lib.channels import CURRENT, MOST_JOINTS, TORQUE, UNKNOWN_UNIT, columns
from ur5lib.checks.arm import (
    Cause,
    foreign_constants,
    foreign_mountings,
    likeliest,
    torque_constants,
)
from ur5lib.checks.by_motion import MotionChecks
from ur5lib.checks.channels import untold_motion
from ur5lib.checks.checked import MIN_BLOCKS, Checked
from ur5lib.checks.currents import (
    MILLIAMPERE_CODES,
    exchanged_currents,
    follows_its_model,
    foreign_currents,
    undeclared_load,
)
from ur5lib.checks.delays import delayed_currents, delayed_joint
from ur5lib.checks.exchanged_channels import (
    exchanged_current,
    exchanged_motion,
    names_equal_to_targets,
)
from ur5lib.checks.load_changes import changed_loads
from ur5lib.checks.rectified import rectified_efforts
from ur5lib.checks.sensed_torques import constant_torques, foreign_size
from ur5lib.checks.springs import spring_on_tool, without_spring
from ur5lib.checks.targets import scaled_currents
from ur5lib.checks.tool import tool_off_flange
from ur5lib.checks.torques import foreign_torque
from ur5lib.checks.unknown_unit import unknown_unit
from ur5lib.checks.velocities import misread_velocities
from ur5lib.records.accepted import up_to_first_standing
from ur5lib.records.codes import CauseCode
from ur5lib.records.quality import Finding, contradiction
from ur5lib.tables import channel

CHECKED_COLUMNS = {"time", "segment", "interpolated", UNKNOWN_UNIT}.union(  # as far as recorded
    columns("actual_TCP_pose"),
    *(columns(f"actual_{name}", MOST_JOINTS) for name in ("q", "qd", "current", "torque")),
    *(columns(f"target_{name}", MOST_JOINTS) for name in ("q", "qd", "current", "moment")),
    (f"filled_{kind}_{name}" for kind in ("actual", "target") for name in ("q", "current")),
)
LIKE_A_SPRING = ("constants", "mounting")  # signs that what is left of one brings


def stop_signs(checked: Checked, accepted: Container[str] = ()) -> list[Finding]:
    """Return the stop signs of a recording; of those of arm and efforts, up to the first that the
    study does not accept, and in place of those that a spring causes in contact, its warning.

    checked: the columns CHECKED_COLUMNS are enough; accepted: kinds of stop signs.
    """
    if UNKNOWN_UNIT in checked.robot:  # no newton from the unknown, and nothing else follows
        return [unknown_unit(checked.means, checked.loaded)]
    copied = [*names_equal_to_targets(checked.robot, checked.step)]
    simulated = [_simulated(copied)] if copied else []
    if simulated and simulated[0].kind not in accepted:
        return simulated  # nothing else follows from it
    smooth = [*exchanged_current(checked.robot)]  # or smoothed by whoever wrote the log
    channels = [
        *exchanged_motion(checked.robot),
        *(smooth if smooth and follows_its_model(checked.means, checked.loaded) else []),
    ]
    of_arm = _with_springs(checked, accepted)
    return [*simulated, *map(_exchanged_channels, channels), *of_arm]


def _with_springs(checked: Checked, accepted: Container[str]) -> list[Finding]:
    """Return what contradicts the arm, as `stop_signs`; where a spring on the tool explains it, so
    that it is gone without, the sign of this, or a warning where the role allows a contact.
    """
    found = [*up_to_first_standing(_contradictions(checked), accepted)]
    if not found or checked.motion is None:
        return found
    spring = spring_on_tool(checked.motion.motion)
    if not spring.is_shown():
        return found
    rest = [*up_to_first_standing(_contradictions(without_spring(checked, spring)), accepted)]
    if any((one.cause, one.joints) == (found[0].cause, found[0].joints) for one in rest):
        return found
    beside = [one for one in rest if one.kind not in LIKE_A_SPRING]
    return beside or [spring.finding(checked.touched)]


def _simulated(names: Sequence[str]) -> Finding:
    detail = (
        f"{' and '.join(names)} equals its target to the last bit, as a simulator's log has it and "
        "no real arm's, so that nothing about an arm follows from this; take a recording of the "
        "arm itself, or correct the columns"
    )
    return contradiction(CauseCode.SIMULATED, "targets", detail)


def _exchanged_channels(name: str) -> Finding:
    detail = (
        f"actual_{name} and target_{name} are exchanged: actual_{name} has no noise, like a "
        "target; correct the columns"
    )
    return contradiction(CauseCode.EXCHANGED_CHANNELS, "targets", detail)


def _contradictions(checked: Checked) -> Iterator[Finding]:
    """Yield what contradicts the arm and what it carries, the strongest evidence first."""
    robot, arm, loaded = checked.robot, checked.arm, checked.loaded
    positions, segment = channel(robot, "actual_q"), robot["segment"].to_numpy()
    yield from untold_motion(positions, segment, checked.step, arm.velocity_limits())
    yield from misread_velocities(robot, checked.step)
    means = checked.means
    if len(means.q) < MIN_BLOCKS:
        return
    yield from foreign_torque(means, arm, checked.payloads)
    yield from tool_off_flange(robot, arm)
    name = arm.measured.channel
    if checked.shows_currents() and checked.tells_signs_by_friction():
        yield from rectified_efforts(means, loaded, name)
    if checked.delays is not None:  # whatever arm and units are
        found = delayed_currents(checked.delays, checked.driven, name)
        yield from (one for one in found if one.severity == "stop")
    if checked.answers is not None:
        yield from exchanged_currents(checked.answers)
    if arm.measured == TORQUE and means.has_efforts():
        yield from constant_torques(means)
        yield from foreign_size(means, loaded)
    yield from _of_efforts(checked)
    if checked.fitted and checked.shows_currents():
        yield from changed_loads(means, loaded, fitted=True)
    if checked.delays is not None:
        late = delayed_joint(checked.delays, checked.driven, name, robot)
        yield from (one for one in late if one.severity == "stop")
    if checked.answers is not None and checked.driven and arm.tells_gravity():
        yield from scaled_currents(means, checked.odd_targets)
    if checked.motion is not None and checked.driven and checked.contact is None:
        yield from checked.motion.weak_currents()
    if checked.fitted and arm.tells_gravity():  # elsewhere, the fit finds an undeclared load
        configured = arm.carrying(checked.configured)
        yield from undeclared_load(means, configured, loaded, checked.odd_targets)


def _of_efforts(checked: Checked) -> Iterator[Finding]:
    """Yield the likeliest cause of efforts that contradict arm, mounting, order or unit, then what
    contradicts signs and motors.
    """
    means, loaded, motion = checked.means, checked.loaded, checked.motion
    units = [*foreign_currents(means, loaded)] if loaded.tells_gravity() else []
    explain_units = (own for own in _changes(checked) if _explains(own, units, motion))
    yield from likeliest([*_mountings(checked), *explain_units])
    yield from units
    if motion is not None:
        yield from motion.turned_by_friction()
    if checked.tells_by_gravity() and means.torque is None and loaded.measured == CURRENT:
        yield from foreign_constants(means, loaded, checked.others, checked.fitted)


def _changes(checked: Checked) -> Iterator[Cause]:
    """Yield exchanges, signs and arms that explain the motion better. If the controller's torque
    was recorded, it has shown arm and order, so that only efforts may be exchanged or turned.
    """
    motion, arm = checked.motion, checked.loaded
    if motion is None:
        return
    yield from (own for own in motion.exchanges_of_efforts() if not _is_answered(checked, own))
    yield from motion.turned_by_links()
    if checked.means.torque is None:
        yield from motion.exchanges_of_joints()
        if arm.has_ur_motors():
            yield from motion.other_arms([one for one in checked.others if one.name != arm.name])


def _is_answered(checked: Checked, exchange: Cause) -> bool:
    """Return whether currents answer the motion of their own joints, so that two are not exchanged,
    although the links explain the efforts better so: friction that hides gravity may be like them.
    """
    j, k = (joint - 1 for joint in exchange.finding.joints)
    return checked.answers is not None and bool(checked.answers.of_exchanges()[j, k] < 0)


def _explains(cause: Cause, units: list[Finding], motion: MotionChecks | None) -> bool:
    """Return whether a cause explains foreign units, too, and better than the opposite sign does;
    true without any, false for milliamperes. units: the findings of foreign units.
    """
    causes = {one.cause for one in units}
    if causes.intersection(MILLIAMPERE_CODES):
        return False
    is_opposite = CauseCode.OPPOSITE_CURRENT in causes
    if motion is not None and is_opposite and cause.gain < motion.gain_of_opposite():
        return False
    return not causes or not any(foreign_currents(cause.means, cause.arm))


def _mountings(checked: Checked) -> Iterator[Cause]:
    """Yield another mounting that explains the efforts better: by any links if those of the arm may
    be wrong, else by its gravity.
    """
    motion = checked.motion
    causes = [] if motion is None or checked.loaded.has_ur_motors() else motion.other_mountings()
    for own in [*causes] or _mountings_by_gravity(checked):
        yield own if motion is None else own._replace(gain=motion.gain_of_arm(own.arm))


def _mountings_by_gravity(checked: Checked) -> Iterator[Cause]:
    """Yield another mounting under which the described gravity explains the efforts better. A push
    at rest looks like one, and counts only if the torque constants are of no motor, either.
    """
    means, loaded, motion = checked.means, checked.loaded, checked.motion
    if not means.has_efforts() or not loaded.tells_gravity():
        return
    if checked.tells_by_gravity() or (
        loaded.measured == CURRENT and torque_constants(means, loaded).foreign()
    ):
        brakes = motion is not None and bool(motion.braked())
        drives = motion is not None and bool(motion.driven_by_friction())
        yield from foreign_mountings(means, loaded, brakes, drives)
