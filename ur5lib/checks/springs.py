"""Springs on the tool: what pulls on it throughout a recording, by where it is.

A spring of stiffness k, relaxed at p₀, takes Jᵀ k (p − p₀) of the motors, which gravity under
another mounting, exchanged joints or another constant would explain in part. It is the rival of
every stop sign by efforts.
"""

from dataclasses import replace
from operator import attrgetter
from typing import NamedTuple

import numpy as np

from ur5lib.channels import TORQUE
from ur5lib.checks.by_motion import MIN_ERRORS
from ur5lib.checks.checked import Checked
from ur5lib.checks.whole_motion import RIDGES, STRETCHES, Lead, Regression, WholeMotion, lead
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

# With a factor on each joint's gravity, what pulls on the tool leads by up to 0.36 in right logs of
# ten arms. One of a UR3 leads by 0.8, but pushes where it is pulled.
MIN_LEAD_OF_SPRING, MIN_ERRORS_OF_SPRING = 0.4, 2.0


class Spring(NamedTuple):
    """What pulls on the flange like a spring.

    pull: stiffness [N/m], and the force [N] without which it would be relaxed at the base (4,);
    error: of the stiffness [N/m], by leaving out stretches of time; lead: over no spring.
    """

    pull: Array
    error: float
    lead: Lead

    def is_shown(self) -> bool:
        """Return whether the efforts show it."""
        is_sure = self.pull[0] > MIN_ERRORS_OF_SPRING * self.error
        leads = self.lead.size > MIN_LEAD_OF_SPRING and self.lead.errors > MIN_ERRORS
        return bool(is_sure and leads)

    def finding(self, touched: bool) -> Finding:
        """Return the stop sign of a recording that a spring should not touch, or the warning of one
        of contacts.
        """
        stiffness = f"{number(self.pull[0], '.0f')} ± {number(self.error, '.1g')} N/m"
        pulls = f"something pulls on the tool throughout, as a spring of {stiffness} does"
        if touched:
            return Finding("robot", Found.CONTACT, "warning", 1, pulls)
        detail = f"{pulls}; give the recording the role contact, or record without it"
        return contradiction(CauseCode.SPRING_ON_TOOL, "payload", detail)


def pull_on_joints(arm: Robot, q: Array) -> Array:
    """Return the motors' torques (M, n, 4) by which they hold a spring, Jᵀ (p, e_x, e_y, e_z).

    q: (M, n) [rad].
    """
    _, place, jacobian = flange_kinematics(arm, q)
    forces = jacobian[:, :3].mT
    return np.concatenate([forces @ place[..., None], forces], axis=2)


def spring_on_tool(motion: WholeMotion) -> Spring:
    """Return the spring that explains the efforts best, in addition to the declared links, of
    currents with a factor a joint, since a constant is no spring, or to any links; measured torques
    of the opposite sign are its rival.
    """
    is_known, torques = motion.arm.tells_gravity(), [motion.torque]
    links = motion.links[:, :, None] * np.eye(len(motion.joints)) if is_known else motion.regressor
    if is_known and motion.arm.measured == TORQUE:
        torques = [sign * motion.torque - motion.links for sign in (1, -1)]
        links = links[:, :, :0]
    pull = pull_on_joints(motion.arm, motion.means.q)
    ridges, first = RIDGES[:1] if is_known else RIDGES, links.shape[2]
    held, sprung = (
        Regression(np.concatenate([links, *more, motion.friction], axis=2), ridges)
        for more in ([], [pull])
    )
    fits = sprung.coefficients(torques[0])[:, first : first + pull.shape[2]]
    error = float(np.sqrt(STRETCHES - 1) * fits[:, 0].std())
    own, rivals = sprung.misfit(torques[0]), map(held.misfit, torques)
    ahead = [lead(own, rival, motion.joints) for rival in rivals]
    return Spring(fits.mean(axis=0), error, min(ahead, key=attrgetter("size")))


def without_spring(checked: Checked, spring: Spring) -> Checked:
    """Return a recording without the efforts that a spring takes."""
    arm, name = checked.arm, checked.arm.measured.channel
    q, efforts = channel(checked.robot, "actual_q"), channel(checked.robot, name)
    torque = pull_on_joints(arm, np.nan_to_num(q)) @ spring.pull
    rest = efforts - torque / np.array(arm.maker_torque_constants())
    return replace(checked, robot=checked.robot.assign(**named(rest, name)))
