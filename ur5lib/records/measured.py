"""One recording as the controller stated it, without any smoothing."""

from typing import Any, NamedTuple, Self

from ur5lib.records.signals import Signals
from ur5lib.timeseries.arrays import Array


class Measured(NamedTuple):
    """What the controller stated in one recording, without smoothing.

    time: (N,) [s]; period: [s]; q [rad], qd [rad/s], current [A, or torque Nm]: (N, n); qd: None
    where it was not recorded.
    """

    time: Array
    period: float
    q: Array
    qd: Array | None
    current: Array

    @classmethod
    def of(cls, signals: Signals) -> "Measured | None":
        """Return the controller's samples of a recording, None without positions or efforts."""
        if signals.actual_q is None or signals.effort is None:
            return None
        return cls(
            signals.time, signals.period, signals.actual_q, signals.actual_qd, signals.effort
        )

    def at(self, rows: Any) -> Self:
        """Return the samples `rows`, a slice or indices."""
        step = rows.step if isinstance(rows, slice) else 1
        qd, period = self.qd, self.period * (step or 1)
        some_qd = None if qd is None else qd[rows]
        return type(self)(self.time[rows], period, self.q[rows], some_qd, self.current[rows])
