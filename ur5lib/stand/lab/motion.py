"""The targets of the joints, step by step, as URScript's motion commands set them."""

from collections.abc import Callable, Iterator
from itertools import count

import numpy as np

from ur5lib.stand.rig import STEP, Target
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.profiles import duration, trapezoid

REST = np.zeros(6)


class JointMotion:
    """The motion of the joints' targets under one command at a time.

    q, qd, qdd: the present targets (6,) [rad, rad/s, rad/s²]; moving: whether a command has not
    ended. Commands raise ValueError where a speed, an acceleration or a time is not positive.
    """

    def __init__(self, q: Array) -> None:
        """q: where the joints rest at first (6,) [rad]."""
        self.q, self.qd, self.qdd = q, REST, REST
        self._rows: Iterator[Target] = iter(())
        self.moving = False
        self._goal, self._rate, self._gain = q, 0.0, 0.0
        self._kind = ""

    def step(self) -> Target:
        """Return the targets of the next step."""
        row = next(self._rows, None)
        if row is None:
            self.moving, self._kind = False, ""
            row = self.q, REST, REST
        self.q, self.qd, self.qdd = row
        return row

    def movej(self, goal: Array, speed: float, acceleration: float) -> None:
        """Move to the angles `goal` (6,) [rad]; joints start and stop together.

        speed [rad/s], acceleration [rad/s²]: of the joint with the longest way.
        """
        _expect_positive(speed, acceleration)
        self._start("movej", self._move(goal, speed, acceleration))

    def stopj(self, deceleration: float) -> None:
        """Brake all joints; deceleration [rad/s²]: of the fastest one."""
        _expect_positive(deceleration)
        self._start("stopj", self._brake(deceleration))

    def servoj(self, goal: Array, lookahead: float) -> None:
        """Follow the angles `goal` (6,) [rad], which may be renewed at any time.

        lookahead [s]: how far the arm lags behind a goal of constant speed.
        """
        _expect_positive(lookahead)
        self._goal, self._rate = goal, 2 / lookahead
        if self._kind != "servoj":
            self._start("servoj", self._follow())

    def speedj(self, speeds: Array, acceleration: float) -> None:
        """Move at joint speeds (6,) [rad/s], which may be renewed; acceleration [rad/s²]."""
        _expect_positive(acceleration)
        self._goal, self._gain = speeds, acceleration
        if self._kind != "speedj":
            self._start("speedj", self._run())

    def freedrive(self, actual: Callable[[], tuple[Array, Array]]) -> None:
        """Follow the joints wherever they are pushed, as in freedrive.

        actual: returns their angles and speeds (6,) [rad, rad/s].
        """
        self._start("freedrive", ((*actual(), REST) for _ in count()))

    def _start(self, kind: str, rows: Iterator[Target]) -> None:
        self._kind, self._rows, self.moving = kind, rows, True

    def _brake(self, deceleration: float) -> Iterator[Target]:
        q, qd = self.q, self.qd
        seconds = np.abs(qd).max() / deceleration
        for k in range(1, int(np.ceil(seconds / STEP)) + 1):
            passed = min(k * STEP, seconds)
            remaining = 1 - passed / seconds
            yield q + qd * (1 + remaining) / 2 * passed, qd * remaining, -qd / seconds

    def _move(self, goal: Array, speed: float, acceleration: float) -> Iterator[Target]:
        yield from self._brake(acceleration)
        origin, way = self.q, goal - self.q
        if not way.any():
            return
        seconds = duration(way, speed, acceleration)[2]
        time: Array = STEP * np.arange(1, int(np.ceil(seconds / STEP)) + 1, dtype=np.float64)
        share = way / np.abs(way).max()
        parts = [np.outer(part, share) for part in trapezoid(time, way, speed, acceleration)]
        yield from zip(origin + parts[0], parts[1], parts[2], strict=True)

    def _follow(self) -> Iterator[Target]:
        """Approach the goal like a critically damped spring, which lags by 2/rate."""
        while True:
            qdd = self._rate * (self._rate * (self._goal - self.q) - 2 * self.qd)
            qd = self.qd + STEP * qdd
            yield self.q + STEP * qd, qd, qdd

    def _run(self) -> Iterator[Target]:
        while True:
            missing = self._goal - self.qd
            largest = np.abs(missing).max()
            qd = self.qd + missing * min(1.0, self._gain * STEP / largest if largest else 1.0)
            yield self.q + STEP * qd, qd, (qd - self.qd) / STEP


def _expect_positive(*values: float) -> None:
    if not all(0 < value < np.inf for value in values):
        raise ValueError("speeds, accelerations and times must be positive")
