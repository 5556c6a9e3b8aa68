"""Predicted currents, and the torques from motor currents."""

from dataclasses import dataclass

import numpy as np

from ur5lib.records.table import JOINTS, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array, Mask


@dataclass(frozen=True, kw_only=True)
class Currents(SegmentedTable):
    """The effort that motion without contact needs, and the external torque, (N, 6) each.

    predicted_current and current_band, half its 95 % band [A], or, where torques are measured,
    predicted_torque and torque_band [Nm]; external_torque: the environment acting on the arm [Nm];
    load_doubt: standard deviation from the error of an estimated load [Nm]; gear_torque,
    friction_torque: transmitted torque and friction of the gears in the same motion without contact
    [Nm]; load_loss: signed friction per transmitted torque [Nm/Nm]; all three low-passed as the
    external torque; tared: (N,), where the external torque is relative to an untouched span, None
    without one. All None if no currents were recorded, or no recording could be fitted.
    """

    predicted_current: Array | None = channel("predicted_current", "A", JOINTS, optional=True)
    current_band: Array | None = channel("current_band", "A", JOINTS, optional=True)
    predicted_torque: Array | None = channel("predicted_torque", "Nm", JOINTS, optional=True)
    torque_band: Array | None = channel("torque_band", "Nm", JOINTS, optional=True)
    external_torque: Array | None = channel("tau_ext", "Nm", JOINTS, optional=True)
    load_doubt: Array | None = channel("load_doubt", "Nm", JOINTS, optional=True)
    gear_torque: Array | None = channel("tau_gears", "Nm", JOINTS, optional=True)
    friction_torque: Array | None = channel("tau_friction", "Nm", JOINTS, optional=True)
    load_loss: Array | None = channel("load_loss", "Nm/Nm", JOINTS, optional=True)
    tared: Mask | None = channel("tared", "1", dtype=np.bool_, optional=True)

    @property
    def predicted(self) -> Array | None:
        """Return the predicted efforts (N, n), torques [Nm] or currents [A]."""
        return self.predicted_current if self.predicted_torque is None else self.predicted_torque

    @property
    def band(self) -> Array | None:
        """Return the half-width (N, n) of the 95 % band of the predicted efforts."""
        return self.current_band if self.torque_band is None else self.torque_band
