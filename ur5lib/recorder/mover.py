"""The thread that moves the arm while it is recorded."""

import threading
import time
from collections.abc import Callable

from ur5lib.errors import InputError
from ur5lib.recorder.arm_motion import ArmMotion, MotionError
from ur5lib.recorder.commanded_motion import ACCELERATION, SPEED, CommandedMotion

REST = 1.0  # s at rest before and after a motion, from which a force sensor's bias is estimated
RATE = 125.0  # Hz, of servoj, which every controller supports


class Mover(threading.Thread):
    """Executes a motion, or lets the arm be led by hand; failure: why it ended early, if it did."""

    def __init__(self, address: str, motion: CommandedMotion | None) -> None:
        """motion: None to lead by hand until `stop`."""
        super().__init__(daemon=True)
        self._address, self._motion = address, motion
        self._arm = ArmMotion(address)
        self._over = threading.Event()
        self.failure: str | None = None

    def run(self) -> None:
        """Move; the thread ends when the arm rests again."""
        try:
            with self._arm:
                time.sleep(REST)
                if not self._over.is_set():
                    self._execute()
                time.sleep(REST)
        except (MotionError, InputError) as error:
            self.failure = str(error)

    def stop(self) -> None:
        """Stop the arm."""
        self._over.set()
        self._arm.stop()

    def _execute(self) -> None:
        done: Callable[[], bool] = self._over.is_set
        if self._motion is None:
            self._arm.lead_by_hand(done)
        elif self._motion.time is None:
            share = self._motion.speed
            self._arm.move_through(self._motion.q, SPEED * share, ACCELERATION * share)
        else:
            self._arm.stream(self._motion.at_rate(RATE), RATE)


def move_to_start(address: str, motion: CommandedMotion) -> None:
    """Move by movej to where a motion starts. Raises MotionError, InputError."""
    with ArmMotion(address) as arm:
        share = motion.speed
        arm.move_through(motion.q[:1], SPEED * share, ACCELERATION * share)
