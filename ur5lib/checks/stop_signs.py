"""Stop signs: what in a recording contradicts the study so much that no forces may be stated."""

from collections.abc import Container, Iterator

from ur5lib.channels import MEASURED_CURRENT, MOST_JOINTS, SENSED_TORQUE, columns
from ur5lib.checks.arm import (
    contradictions_by_gravity,
    foreign_mountings,
    likeliest,
    torque_constants,
)
from ur5lib.checks.channels import misread_velocities
from ur5lib.checks.checked import MIN_BLOCKS, Checked
from ur5lib.checks.currents import (
    exchanged_currents,
    foreign_currents,
    turned_currents,
    undeclared_load,
)
from ur5lib.checks.delays import delayed_currents
from ur5lib.checks.exchanged_channels import (
    exchanged_current,
    exchanged_motion,
    names_equal_to_targets,
)
from ur5lib.checks.sensed_torques import constant_torques, exchanged_torques, foreign_size
from ur5lib.checks.targets import scaled_currents
from ur5lib.checks.tool import tool_off_flange
from ur5lib.checks.torques import foreign_torque
from ur5lib.records.accepted import KINDS, up_to_first_standing
from ur5lib.records.quality import Finding, contradiction

CHECKED_COLUMNS = {"time", "segment", "interpolated"}.union(  # columns, as far as recorded
    columns("actual_TCP_pose"),
    *(columns(f"actual_{name}", MOST_JOINTS) for name in ("q", "qd", "current")),
    *(columns(f"target_{name}", MOST_JOINTS) for name in ("q", "qd", "current", "moment")),
)


def stop_signs(checked: Checked, accepted: Container[str] = ()) -> list[Finding]:
    """Return the stop signs of a recording, of which the columns CHECKED_COLUMNS are enough.

    accepted: kinds of stop signs that the study accepts, behind which others are looked for.
    """
    copied = [*names_equal_to_targets(checked.robot, checked.step)]
    simulated = [contradiction("simulated", names=copied)] if copied else []
    if simulated and KINDS["simulated"] not in accepted:
        return simulated  # nothing else follows from it
    channels = [*exchanged_motion(checked.robot), *exchanged_current(checked.robot)]
    of_channels = [contradiction("exchanged channels", name=name) for name in channels]
    of_arm = up_to_first_standing(_contradictions(checked), accepted)
    return [*simulated, *of_channels, *of_arm]


def _contradictions(checked: Checked) -> Iterator[Finding]:
    """Yield what contradicts the arm and what it carries, the strongest evidence first."""
    robot, arm, loaded = checked.robot, checked.arm, checked.loaded
    yield from misread_velocities(robot, checked.step)
    means = checked.means
    if len(means.q) < MIN_BLOCKS:
        return
    yield from foreign_torque(means, arm, checked.payloads)
    yield from tool_off_flange(robot, arm)
    if checked.delays is not None:  # whatever arm and units are
        name = SENSED_TORQUE if arm.senses_torque() else MEASURED_CURRENT
        yield from delayed_currents(checked.delays, checked.driven, name)
    if checked.answers is not None:
        yield from exchanged_currents(checked.answers)
    if arm.senses_torque() and MEASURED_CURRENT in means.currents:
        yield from constant_torques(means)
        if arm.links != "known":
            yield from foreign_size(means, arm)
        yield from exchanged_torques(means, loaded)
        if checked.tells_signs_by_friction():
            yield from turned_currents(means, loaded)
    if not arm.tells_gravity():
        return
    if checked.tells_by_gravity() and means.torque is None:  # which has shown arm and joints
        shown = means, loaded, checked.others, checked.fitted, checked.driven
        yield from contradictions_by_gravity(*shown)
    else:
        yield from _mounting(checked)
        yield from foreign_currents(means, loaded)
    if checked.answers is not None and checked.driven:
        yield from turned_currents(means, loaded)
        yield from scaled_currents(means, checked.odd_targets)
    if checked.fitted:  # elsewhere, the fit finds an undeclared load
        configured = arm.carrying(checked.configured)
        yield from undeclared_load(means, configured, loaded, checked.odd_targets)


def _mounting(checked: Checked) -> Iterator[Finding]:
    """Find another mounting; a push at rest is like one, but for torque constants that none has."""
    means, loaded = checked.means, checked.loaded
    if MEASURED_CURRENT not in means.currents or loaded.senses_torque():
        return
    if checked.tells_by_gravity() or torque_constants(means, loaded).foreign():
        yield from likeliest(foreign_mountings(means, loaded, checked.driven))
