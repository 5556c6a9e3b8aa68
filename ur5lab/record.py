"""`ur5 record`: a session with the devices of a study, and the entry of the recording."""

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rich.console import Console
from rich.live import Live

from ur5lab.doubles.lab_double import TRUTH_STEM, lab_double
from ur5lab.recorded_study import StudyFile, checked_name, entry_of
from ur5lab.recorder import display
from ur5lab.recorder.arm_motion import MotionError, Mover, move_to_start
from ur5lab.recorder.arm_state import ArmState, identify, read_state
from ur5lab.recorder.capture import Status
from ur5lab.recorder.commanded_motion import (
    START_TOLERANCE,
    CommandedMotion,
    read_motion,
    refusals,
)
from ur5lab.recorder.device import of_recorder
from ur5lab.recorder.move_program import is_program, planned_motion, read_program
from ur5lab.recorder.session import Session, is_taken, left_behind, taken, write_manifest
from ur5lib.errors import InputError
from ur5lib.robots.description import Robot
from ur5lib.study.devices import LabSettings
from ur5lib.study.turn import reserved
from ur5lib.timeseries.arrays import Array

POLL_PERIOD = 0.25  # s between queries of the devices' state
BRAKING_TIME = 10.0  # s to wait for the arm to stop; without an answer, its watchdog stops it


@dataclass(frozen=True)
class RecordOptions:
    """The options of `ur5 record`.

    name: of the recording; seconds: duration, None until the motion ends or Ctrl-C; without:
    sensors of the study that are not used; move: file of a motion, None for none; speed: factor of
    its speed; wait: least time [s] between the commands of such a file; by_hand: whether a person
    guides the arm; yes: whether motions are confirmed beforehand.
    """

    name: str
    role: Literal["fit", "validate", "contact"]
    seconds: float | None = None
    without: tuple[str, ...] = ()
    move: Path | None = None
    by_hand: bool = False
    speed: float = 0.25
    wait: float = 0.0
    yes: bool = False
    add: bool = False
    emulate: bool = False


def record(path: Path, options: RecordOptions, console: Console) -> int:
    """Record with the devices of a study; return the number of stop signs and errors in the files.

    path: the study, which need not have recordings yet. Raises InputError when something is missing
    or forbidden, before anything moves or is written.
    """
    study = StudyFile.read(path)
    robot = study.arm().description()
    folder = Path("raw", study.name(), checked_name(options.name))
    for line in filter(None, map(left_behind, sorted(folder.parent.glob("*")))):
        console.print(line)
    if is_taken(folder):
        raise taken(folder)
    _expect_extra(study, options)
    laboratory: AbstractContextManager[LabSettings] = (
        lab_double(robot, options.role == "contact", folder)
        if options.emulate
        else nullcontext(study.lab())
    )
    with reserved(folder), laboratory as lab:
        devices = {n: d for n, d in lab.devices().items() if n not in options.without}
        address = lab.robot.address
        motion = None
        if options.move:
            motion = _prepare(options.move, robot, address, lab.table_m, options, console)
        elif options.by_hand:
            _expect_ready(address)
            _confirm("the arm will be in freedrive; hold it. Type yes: ", options, console)
        mover = Mover(address, motion) if motion or options.by_hand else None
        with Session(devices, folder) as session:
            with suppress(InputError):  # if its dashboard does not answer
                vars(session.identities()["robot"]).update(identify(address))
            moved = f"{options.move} at {options.speed:g} of its speed" if motion else None
            write_manifest(folder, session.identities(), None, moved)
            _watch(session, mover, options.seconds, console)
        write_manifest(folder, session.identities(), session.statuses(), moved)
    _print_summary(session.statuses(), options.role, mover, console)
    entry = {"name": options.name, "role": options.role, "folder": str(folder)}
    entry |= entry_of(lab, session.statuses())
    entry |= {"truth": TRUTH_STEM} if options.emulate else {}
    return study.enter(entry, options.add, console)


def _expect_extra(study: StudyFile, options: RecordOptions) -> None:
    """Raise InputError where the package that reads an IMU is missing, before anything moves."""
    devices = ("imu",) if options.emulate else study.lab().devices()
    if "imu" in devices and "imu" not in options.without:
        of_recorder("serial", "reading the IMU, unless `--without imu` leaves it out,")


def _prepare(
    path: Path,
    robot: Robot,
    address: str,
    table: float | None,
    options: RecordOptions,
    console: Console,
) -> CommandedMotion:
    """Read and check a motion, ask for confirmation, and move to its start.

    Raises InputError for a forbidden motion.
    """
    state = _expect_ready(address)
    motion = _planned(path, robot, state.q, options)
    forbidden = [*refusals(motion, robot, state.q, table)]
    if forbidden:
        raise InputError("\n".join(f"{path}: {reason}" for reason in forbidden))
    console.print(f"the arm is at    {_angles(state.q)}")
    console.print(
        f"it will start at {_angles(motion.q[0])}, at {options.speed:g} of the full speed"
    )
    _confirm("move the arm? Type yes: ", options, console)
    if np.abs(state.q - motion.q[0]).max() > START_TOLERANCE:
        try:
            move_to_start(address, motion)
        except MotionError as error:
            raise InputError(f"the arm did not reach the start: {error}") from error
    return motion


def _planned(path: Path, robot: Robot, present: Array, options: RecordOptions) -> CommandedMotion:
    """Return the motion that a file commands; present: the arm's posture (6,) [rad]."""
    if is_program(path):
        return planned_motion(read_program(path), robot, present, options.speed, options.wait)
    if options.wait:
        raise InputError(f"--wait: {path} has no commands to wait between; leave it out")
    return read_motion(path, options.speed)


def _expect_ready(address: str) -> ArmState:
    """Return the arm's state. Raises InputError if it cannot move."""
    state = read_state(address)
    if not state.ready:
        raise InputError(
            f"the arm is not ready (robot mode {state.robot_mode}, safety mode "
            f"{state.safety_mode}); release its brakes or clear the stop on the pendant"
        )
    return state


def _confirm(question: str, options: RecordOptions, console: Console) -> None:
    """Ask for confirmation, unless given by an option. Raises InputError without a yes."""
    if not options.yes and console.input(question).strip() != "yes":
        raise InputError("not confirmed; the arm was not moved")


def _angles(q: Any) -> str:
    return "(" + ", ".join(f"{angle:6.2f}" for angle in q) + ") rad"


def _watch(session: Session, mover: Mover | None, seconds: float | None, console: Console) -> None:
    """Show the devices' state until `seconds` are over, the motion or all streams have ended, or
    Ctrl-C.
    """
    begin, printed = time.monotonic(), set[str]()
    with _moving(mover), _shown(console) as show:
        try:
            while not _is_over(session.statuses(), mover, begin, seconds):
                time.sleep(POLL_PERIOD)
                statuses = session.statuses()
                show(statuses)
                for warning in display.warnings(statuses, session.identities()):
                    if warning not in printed:
                        printed.add(warning)
                        console.print(f"warning: {warning}")
                if mover and any(status.ended for status in statuses.values()):
                    mover.stop()
        except KeyboardInterrupt:
            console.print("stopped by Ctrl-C")


@contextmanager
def _moving(mover: Mover | None) -> Iterator[None]:
    """Move the arm within the context; stop it at the end, also after an error."""
    if mover is None:
        yield
        return
    mover.start()
    try:
        yield
    finally:
        if mover.is_alive():
            mover.stop()
            mover.join(BRAKING_TIME)


@contextmanager
def _shown(console: Console) -> Iterator[Any]:
    """Yield a function that shows the devices' state in place on a terminal, and does nothing
    without one.
    """
    if not console.is_terminal:
        yield lambda _: None
        return
    with Live(console=console, transient=True, auto_refresh=False) as view:
        yield lambda statuses: view.update(display.table(statuses), refresh=True)


def _is_over(
    statuses: dict[str, Status], mover: Mover | None, begin: float, seconds: float | None
) -> bool:
    passed = seconds is not None and time.monotonic() - begin >= seconds
    done = mover is not None and not mover.is_alive()
    return passed or done or all(status.ended for status in statuses.values())


def _print_summary(
    statuses: dict[str, Status], role: str, mover: Mover | None, console: Console
) -> None:
    console.print(display.table(statuses))
    still = display.unmoved(statuses["robot"])
    if role == "fit" and still:
        joints = ", ".join(map(str, still))
        console.print(
            f"warning: joint {joints} turned by less than {display.MIN_TURN_FOR_FRICTION} rad: its "
            "friction cannot be identified from this recording"
        )
    if mover and mover.failure:
        console.print(f"warning: the motion ended early: {mover.failure}")
