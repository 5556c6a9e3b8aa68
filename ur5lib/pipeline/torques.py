"""Joint torques of every link model, of the payload, and the momentum of the arm."""

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.pipeline.carried import Carried
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot


def joint_torques(robot: Robot, load: Carried, signals: Signals, motion: Motion) -> Torques:
    """Return the torques of all link models, and the momentum terms of the fullest one.

    robot: under the recording's gravity; load: what it carries.
    """
    given = {model: LinkModel(robot.carrying(load.configured), model) for model in robot.models}
    states, fullest = (motion.q, motion.qd, motion.qdd), robot.fullest_model()
    measured = {name: model.inverse_dynamics(*states) for name, model in given.items()}
    target = signals.target_q, signals.target_qd, signals.target_qdd
    known = [values for values in target if values is not None]
    true = LinkModel(robot.carrying(load.payload), fullest)
    # what the payload adds to the one that the controller was given
    added = np.zeros_like(motion.q)
    if load.payload != load.configured:
        added = true.inverse_dynamics(*states) - measured[fullest]
    return Torques(
        time=signals.time,
        segment=signals.segment,
        interpolated=signals.interpolated,
        target={
            name: model.inverse_dynamics(*known) for name, model in given.items() if len(known) == 3
        },
        measured=measured,
        payload_torque=added,
        momentum=true.momentum(motion.q, motion.qd),
        coriolis_torque=true.coriolis_torque(motion.q, motion.qd),
        gravity_torque=true.gravity_torque(motion.q),
    )
