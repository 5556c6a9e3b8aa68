"""Joint torques of every link model, of the payload, and the momentum of the arm."""

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.pipeline.carried import Carried
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


def joint_torques(robot: Robot, load: Carried, signals: Signals, motion: Motion) -> Torques:
    """Return the torques of all link models, and the momentum terms of the fullest one.

    robot: under the recording's gravity; load: what it carries.
    """
    given = {model: LinkModel(robot.carrying(load.told), model) for model in robot.models}
    measured = motion.q, motion.qd, motion.qdd
    target = signals.target_q, signals.target_qd, signals.target_qdd
    known = [states for states in target if states is not None]
    true = LinkModel(robot.carrying(load.payload), robot.fullest_model())
    return Torques(
        time=signals.time,
        segment=signals.segment,
        interpolated=signals.interpolated,
        target={
            name: model.inverse_dynamics(*known) for name, model in given.items() if len(known) == 3
        },
        measured={name: model.inverse_dynamics(*measured) for name, model in given.items()},
        payload_torque=payload_torque(robot, load, motion),
        momentum=true.momentum(motion.q, motion.qd),
        coriolis_torque=true.coriolis_torque(motion.q, motion.qd),
        gravity_torque=true.gravity_torque(motion.q),
    )


def payload_torque(robot: Robot, load: Carried, motion: Motion) -> Array:
    """Return the torque (N, 6) [Nm] of the payload at the measured motion, minus that of the one
    configured in the controller.
    """
    if load.payload == load.told:
        return 0 * motion.q
    true, given = (
        LinkModel(robot.carrying(payload), robot.fullest_model()).inverse_dynamics(
            motion.q, motion.qd, motion.qdd
        )
        for payload in (load.payload, load.told)
    )
    return true - given
