"""Torque thresholds as a URScript function."""

from collections.abc import Iterable

import numpy as np

from ur5lib.topics.thresholds.torque_thresholds import LEVELS, Thresholds

FUNCTION = """\
# {robot}: external torques [Nm] that {rate:.3g} of the samples without contact exceed, by joint and
# speed, of {count} recordings. True where a joint's torque is beyond its own.
def ur5lib_touched():
  local resting = {resting}
  local slow = {slow}
  local fast = {fast}
  local fast_from = {fast_from}
  local torque = get_joint_torques()
  local speed = get_actual_joint_speeds()
  local joint = 0
  while joint < 6:
    local most = resting[joint]
    if norm(speed[joint]) > fast_from[joint]:
      most = fast[joint]
    elif norm(speed[joint]) > {slow_from}:
      most = slow[joint]
    end
    if norm(torque[joint]) > most:
      return True
    end
    joint = joint + 1
  end
  return False
end
"""


def in_urscript(found: Thresholds) -> str:
    """Return the text of a URScript function that compares the controller's own torques with the
    lower thresholds.
    """
    level = next(iter(LEVELS))
    resting, slow, fast = (_listed(row) for row in found.by_speed[level])
    return FUNCTION.format(
        robot=found.robot,
        rate=LEVELS[level],
        count=len(found.recordings),
        resting=resting,
        slow=slow,
        fast=fast,
        fast_from=_listed(found.edges[2]),
        slow_from=f"{found.edges[1][0]:g}",
    )


def _listed(values: Iterable[float]) -> str:
    return f"[{', '.join(f'{value:.3f}' for value in np.asarray(values))}]"
