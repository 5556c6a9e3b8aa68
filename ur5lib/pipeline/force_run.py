"""A recording as a force estimate without a sensor sees it."""

import pandas as pd

from ur5lib.force.external_torque import joint_states
from ur5lib.force.template import Run
from ur5lib.tables import channel, period


def force_run(currents: pd.DataFrame, motion: pd.DataFrame, torque: str) -> Run | None:
    """Measured motion and the external torque of a name; None where no currents were recorded."""
    if f"{torque}_0" not in currents:
        return None
    qd, segment, step = channel(motion, "qd"), motion["segment"].to_numpy(), period(motion)
    states = joint_states(qd, segment, step)
    return Run(
        channel(motion, "q"),
        qd,
        channel(currents, torque),
        states,
        segment,
        step,
        channel(currents, "load_doubt"),
    )
