"""`ur5 record`: a session with the devices of a study, and the entry of what it recorded."""

import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from rich.console import Console
from rich.live import Live

from ur5lib.commands.emulated_lab import TRUTH, emulated_lab
from ur5lib.commands.named_lab import arm_of, checked_name, lab_of
from ur5lib.commands.recorded_entry import enter, entry_of
from ur5lib.errors import InputError
from ur5lib.recorder import live
from ur5lib.recorder.arm_identity import identify
from ur5lib.recorder.arm_motion import MotionError
from ur5lib.recorder.arm_state import ArmState, read_state
from ur5lib.recorder.capture import Status
from ur5lib.recorder.commanded_motion import AT_START, CommandedMotion, read_motion, refusals
from ur5lib.recorder.lab import Lab
from ur5lib.recorder.manifest import write_manifest
from ur5lib.recorder.move_program import is_program, plan, read_program
from ur5lib.recorder.mover import Mover, move_to_start
from ur5lib.recorder.session import Session
from ur5lib.robots.description import Robot
from ur5lib.study.reading import read_plain
from ur5lib.timeseries.arrays import Array

LOOK = 0.25  # s between looks at the devices
BRAKING = 10.0  # s; an arm that does not answer for so long stops by its own watchdog


@dataclass(frozen=True)
class RecordOptions:
    """What is to be recorded.

    name: of the recording; seconds: for how long, None until the motion ends or Ctrl-C; without:
    sensors of the study that are not there today; move: file of a motion, None for none; wait:
    least time [s] between the commands of such a file; by_hand: whether the arm is led by hand;
    yes: whether motions are confirmed beforehand.
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
    """Record with the devices of a study; returns how many stop signs and errors the files have.

    path: the study, which need not have recordings yet. Raises InputError when something is missing
    or forbidden; nothing moves and no file is left then.
    """
    plain = read_plain(path)
    robot = arm_of(plain, path).description()
    folder = Path("raw", checked_name(str(plain.get("study"))), checked_name(options.name))
    if folder.exists():
        raise InputError(f"{folder} exists; give the recording another name")
    laboratory: AbstractContextManager[Lab] = (
        emulated_lab(robot, options.role == "contact", folder)
        if options.emulate
        else nullcontext(lab_of(plain, path))
    )
    with laboratory as lab:
        devices = {n: d for n, d in lab.devices().items() if n not in options.without}
        address = lab.robot.address
        motion = None
        if options.move:
            motion = _prepare(options.move, robot, address, lab.table_m, options, console)
        elif options.by_hand:
            _expect_ready(address)
            _confirm("the arm gives way to your hand; hold it. Type yes: ", options, console)
        mover = Mover(address, motion) if motion or options.by_hand else None
        with Session(devices, folder) as session:
            session.identities()["robot"].update(_identity(lab))
            moved = f"{options.move} at {options.speed:g} of its speed" if motion else None
            write_manifest(folder, session.identities(), None, moved)
            _watch(session, mover, options.seconds, console)
        write_manifest(folder, session.identities(), session.statuses(), moved)
    _say_what_is_left(session.statuses(), options.role, mover, console)
    entry = {"name": options.name, "role": options.role, "folder": str(folder)}
    entry |= entry_of(lab, session.statuses())
    entry |= {"truth": TRUTH} if options.emulate else {}
    return enter(entry, path, plain, options.add, console)


def _identity(lab: Lab) -> dict[str, str]:
    """Return what the arm's dashboard tells of it, nothing where it cannot be asked."""
    try:
        return identify(lab.robot.address)
    except InputError:
        return {}


def _prepare(
    path: Path,
    robot: Robot,
    address: str,
    table: float | None,
    options: RecordOptions,
    console: Console,
) -> CommandedMotion:
    """Read and check a motion, ask, and move to its start.

    Raises InputError where it must not be made.
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
    if np.abs(state.q - motion.q[0]).max() > AT_START:
        try:
            move_to_start(address, motion)
        except MotionError as error:
            raise InputError(f"the arm did not reach the start: {error}") from error
    return motion


def _planned(path: Path, robot: Robot, present: Array, options: RecordOptions) -> CommandedMotion:
    """Return the motion that a file commands; present: the arm's posture (6,) [rad]."""
    if is_program(path):
        return plan(read_program(path), robot, present, options.speed, options.wait)
    if options.wait:
        raise InputError(f"--wait: {path} has no commands to wait between; leave it out")
    return read_motion(path, options.speed)


def _expect_ready(address: str) -> ArmState:
    """Return the state of an arm that could move. Raises InputError for any other."""
    state = read_state(address)
    if not state.ready:
        raise InputError(
            f"the arm is not ready (robot mode {state.robot_mode}, safety mode "
            f"{state.safety_mode}); release its brakes or clear the stop on the pendant"
        )
    return state


def _confirm(question: str, options: RecordOptions, console: Console) -> None:
    """Ask, unless the answer was given beforehand. Raises InputError without a yes."""
    if not options.yes and console.input(question).strip() != "yes":
        raise InputError("not confirmed; the arm was not moved")


def _angles(q: Any) -> str:
    return "(" + ", ".join(f"{angle:6.2f}" for angle in q) + ") rad"


def _watch(session: Session, mover: Mover | None, seconds: float | None, console: Console) -> None:
    """Show the devices until the time is over, the motion ends, all are gone, or Ctrl-C."""
    begin, said = time.monotonic(), set[str]()
    with _moving(mover), _shown(console) as show:
        try:
            while not _is_over(session.statuses(), mover, begin, seconds):
                time.sleep(LOOK)
                statuses = session.statuses()
                show(statuses)
                for warning in live.warnings(statuses, session.identities()):
                    if warning not in said:
                        said.add(warning)
                        console.print(f"warning: {warning}")
                if mover and any(status.ended for status in statuses.values()):
                    mover.stop()
        except KeyboardInterrupt:
            console.print("stopped by Ctrl-C")


@contextmanager
def _moving(mover: Mover | None) -> Iterator[None]:
    """Move the arm in the context; it rests when the context ends, however that ends."""
    if mover is None:
        yield
        return
    mover.start()
    try:
        yield
    finally:
        if mover.is_alive():
            mover.stop()
            mover.join(BRAKING)


@contextmanager
def _shown(console: Console) -> Iterator[Any]:
    """Yield what shows the devices, in place on a terminal, not at all elsewhere."""
    if not console.is_terminal:
        yield lambda _: None
        return
    with Live(console=console, transient=True, auto_refresh=False) as view:
        yield lambda statuses: view.update(live.table(statuses), refresh=True)


def _is_over(
    statuses: dict[str, Status], mover: Mover | None, begin: float, seconds: float | None
) -> bool:
    passed = seconds is not None and time.monotonic() - begin >= seconds
    done = mover is not None and not mover.is_alive()
    return passed or done or all(status.ended for status in statuses.values())


def _say_what_is_left(
    statuses: dict[str, Status], role: str, mover: Mover | None, console: Console
) -> None:
    console.print(live.table(statuses))
    still = live.unmoved(statuses["robot"])
    if role == "fit" and still:
        joints = ", ".join(map(str, still))
        console.print(
            f"warning: joint {joints} turned by less than {live.MOVED} rad: its friction cannot be "
            "identified from this recording"
        )
    if mover and mover.failure:
        console.print(f"warning: the motion ended early: {mover.failure}")
