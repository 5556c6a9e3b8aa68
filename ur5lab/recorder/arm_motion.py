"""Motion of an arm by ur_rtde's control interface: way-points, a streamed trajectory, by hand.

Nothing here checks whether a motion is safe: the caller must.
"""

import threading
import time
from collections.abc import Callable
from typing import Any, Self

from ur5lab.recorder.arm_state import read_state
from ur5lab.recorder.commanded_motion import FULL_ACCELERATION, FULL_SPEED, CommandedMotion
from ur5lab.recorder.device import of_recorder
from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array

WATCHDOG_RATE = 4.0  # Hz; the controller stops the arm when this program writes less often
PROGRAM_START_TIMEOUT = 5.0  # s; for the start of the control program
POLL_INTERVAL = 0.01  # s; between queries of a motion's state
STOP_DECELERATION = 5.0  # rad/s²; of `stop`
SERVOJ_LOOKAHEAD, SERVOJ_GAIN = 0.1, 300.0  # s, 1; URScript's defaults
REST_TIME = 1.0  # s; rest before and after a motion, which shows a force sensor's bias
SERVOJ_RATE = 125.0  # Hz; every controller supports servoj at this rate
CATCH_UP_TIME = 3 * SERVOJ_LOOKAHEAD  # s; the arm reaches the last point of a stream within it


class MotionError(Exception):
    """Raised where the arm does not execute a motion: a protective stop, an ended program, a lost
    connection.
    """


class ArmMotion:
    """Commands to the arm at an address: `with ArmMotion(address) as motion:`.

    Every motion returns whether it was completed: False if `stop` was called, after which no
    further motion begins. From the first motion on, the controller stops the arm by itself if this
    program dies.
    """

    def __init__(self, address: str) -> None:
        self._address = address
        self._control: Any = None
        self._lock = threading.Lock()  # ur_rtde's commands share registers
        self._stopped = threading.Event()
        self._streams = False

    def __enter__(self) -> Self:
        """Connect and load ur_rtde's control program; the arm does not move.

        Raises InputError when ur_rtde is not installed or the controller does not answer.
        """
        read_state(self._address)  # fails fast and clearly, where ur_rtde would block
        rtde_control = of_recorder("rtde_control", "moving the arm")
        try:
            self._control = rtde_control.RTDEControlInterface(self._address)
        except (RuntimeError, ValueError) as error:
            raise InputError(
                f"the controller at {self._address} does not take a program ({error}); switch it "
                "to remote control, release its brakes and unlock its protective stop"
            ) from error
        return self

    def __exit__(self, *_: object) -> None:
        """Stop the arm, where it moves, and disconnect."""
        self.stop()
        if self._is_connected():
            self._control.stopScript()
        self._control.disconnect()

    def move_through(self, way_points: Array, speed: float, acceleration: float) -> bool:
        """Move by movej to each way-point (n, 6) [rad] in turn, stopping there.

        speed [rad/s], acceleration [rad/s²]: of the joint with the longest way. Raises MotionError.
        """
        self._prepare()
        return all(self._move_to(point, speed, acceleration) for point in way_points)

    def stream(self, q: Array, rate: float) -> bool:
        """Follow joint angles (N, 6) [rad] at `rate` [Hz] by servoj, from the present posture.

        If this program is late, it skips points to keep the timing. Raises MotionError.
        """
        self._prepare()
        start, last = time.monotonic(), len(q) - 1
        end = last / rate + CATCH_UP_TIME
        self._streams = True
        while (passed := time.monotonic() - start) < end and not self._stopped.is_set():
            point = q[min(int(passed * rate), last)]
            self._command(
                "servoJ", point.tolist(), 0.0, 0.0, 1 / rate, SERVOJ_LOOKAHEAD, SERVOJ_GAIN
            )
            time.sleep(max(0.0, 1 / rate - (time.monotonic() - start - passed)))
        self._command("servoStop", STOP_DECELERATION)
        self._streams = False
        return not self._stopped.is_set()

    def lead_by_hand(self, done: Callable[[], bool]) -> bool:
        """Let a person lead the arm until `done`. Raises MotionError."""
        self._prepare()
        self._command("teachMode")
        self._wait(done)
        self._command("endTeachMode", even_stopped=True)
        return not self._stopped.is_set()

    def stop(self) -> None:
        """Brake all joints; may be called from any thread, and ends the present motion."""
        self._stopped.set()
        with self._lock:
            if self._is_connected() and self._control.isProgramRunning():
                if self._streams:
                    self._control.servoStop(STOP_DECELERATION)
                self._control.stopJ(STOP_DECELERATION)

    def _move_to(self, point: Array, speed: float, acceleration: float) -> bool:
        before = self._control.getAsyncOperationProgressEx().operationId()

        def has_ended() -> bool:
            progress = self._control.getAsyncOperationProgressEx()
            return progress.operationId() != before and not progress.isAsyncOperationRunning()

        self._command("moveJ", point.tolist(), speed, acceleration, True)
        self._wait(has_ended)
        return not self._stopped.is_set()

    def _prepare(self) -> None:
        """Load the control program anew where it has ended, and start the watchdog."""
        if not self._control.isProgramRunning():
            if not read_state(self._address).ready:
                raise MotionError(self._refusal("a motion"))
            self._command("reuploadScript")
            until = time.monotonic() + PROGRAM_START_TIMEOUT
            while not self._control.isProgramRunning() and time.monotonic() < until:
                time.sleep(POLL_INTERVAL)
        self._command("setWatchdog", WATCHDOG_RATE)

    def _command(self, name: str, *arguments: Any, even_stopped: bool = False) -> None:
        """Call a command of ur_rtde, unless the arm was stopped."""
        try:
            with self._lock:
                if self._stopped.is_set() and not even_stopped:
                    return
                if not self._is_connected():
                    raise MotionError(f"the connection to {self._address} is lost")
                done = getattr(self._control, name)(*arguments)
        except RuntimeError as error:
            raise MotionError(f"the connection to {self._address} is lost: {error}") from error
        if not done:
            raise MotionError(self._refusal(name))

    def _is_connected(self) -> bool:
        """Return whether the controller is connected; if not, ur_rtde repeats the last state."""
        return self._control is not None and self._control.isConnected()

    def _wait(self, done: Callable[[], bool]) -> None:
        """Wait until a motion is done or stopped, and feed the watchdog."""
        while not self._stopped.is_set() and not done():
            self._command("kickWatchdog")
            time.sleep(POLL_INTERVAL)

    def _refusal(self, name: str) -> str:
        """Return a sentence on why the arm does not execute a command."""
        try:
            state = read_state(self._address)
        except InputError as error:
            return str(error)
        return (
            f"{self._address} does not execute {name}: robot mode {state.robot_mode}, safety mode "
            f"{state.safety_mode}, program {'runs' if state.program_runs else 'stopped'}"
        )


class Mover(threading.Thread):
    """A thread that executes a motion, or lets a person guide the arm; failure: why it ended early,
    if it did.
    """

    def __init__(self, address: str, motion: CommandedMotion | None) -> None:
        """Take a motion; None to lead the arm by hand until `stop`."""
        super().__init__(daemon=True)
        self._address, self._motion = address, motion
        self._arm = ArmMotion(address)
        self._over = threading.Event()
        self.failure: str | None = None

    def run(self) -> None:
        """Move; the thread ends when the arm rests again."""
        try:
            with self._arm:
                time.sleep(REST_TIME)
                if not self._over.is_set():
                    self._execute()
                time.sleep(REST_TIME)
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
            self._arm.move_through(self._motion.q, FULL_SPEED * share, FULL_ACCELERATION * share)
        else:
            self._arm.stream(self._motion.at_rate(SERVOJ_RATE), SERVOJ_RATE)


def move_to_start(address: str, motion: CommandedMotion) -> None:
    """Move by movej to where a motion starts. Raises MotionError, InputError."""
    with ArmMotion(address) as arm:
        share = motion.speed
        arm.move_through(motion.q[:1], FULL_SPEED * share, FULL_ACCELERATION * share)
