"""The dashboard server, port 29999: one command a line, one answer a line.

Source: Universal Robots' dashboard server guide, CB-Series and e-Series.
"""

from asyncio import StreamReader, StreamWriter
from collections.abc import Callable
from itertools import repeat

from ur5lib.doubles.control_box import ControlBox
from ur5lib.robots.rtde_variables import RobotMode, RuntimeState, SafetyMode

WELCOME = "Connected: Universal Robots Dashboard Server"
SERIAL_NUMBER = "20260000001"


async def serve(box: ControlBox, reader: StreamReader, writer: StreamWriter) -> None:
    """Answer all lines of a client until it hangs up or quits."""
    writer.write(f"{WELCOME}\n".encode())
    while data := await reader.readline():
        line = data.decode("utf-8", "replace").strip()
        writer.write(f"{answer(line, box)}\n".encode())
        if line in ("quit", "shutdown"):
            return


def answer(line: str, box: ControlBox) -> str:
    """Execute a command and return the answer to it."""
    if line in COMMANDS:
        return COMMANDS[line](box)
    for start, command in WITH_ARGUMENT.items():
        if line.startswith(f"{start} "):
            return command(box, line.removeprefix(start).strip())
    return f"could not understand: '{line}'"


def _power_on(box: ControlBox) -> str:
    if box.robot_mode == RobotMode.POWER_OFF:
        box.robot_mode = RobotMode.IDLE
    return "Powering on"


def _power_off(box: ControlBox) -> str:
    box.stop()
    box.robot_mode = RobotMode.POWER_OFF
    return "Powering off"


def _brake_release(box: ControlBox) -> str:
    box.robot_mode = RobotMode.RUNNING
    return "Brake releasing"


def _unlock(box: ControlBox) -> str:
    if box.unlock():
        return "Protective stop releasing"
    return "Cannot unlock protective stop until 5s after occurrence"


def _play(box: ControlBox) -> str:
    if box.state == RuntimeState.PAUSED:
        box.paused = False
        return "Starting program"
    if not box.loaded or box.safety_mode != SafetyMode.NORMAL:
        return "Failed to execute: play"
    box.run(repeat(None))
    return "Starting program"


def _stop(box: ControlBox) -> str:
    box.stop()
    return "Stopped"


def _pause(box: ControlBox) -> str:
    if box.state != RuntimeState.PLAYING:
        return "Failed to execute: pause"
    box.paused = True
    return "Pausing program"


def _load(box: ControlBox, name: str) -> str:
    box.loaded = name
    return f"Loading program: {name}"


def _loaded(box: ControlBox) -> str:
    return f"Loaded program: {box.loaded}" if box.loaded else "No program loaded"


def _log(box: ControlBox, text: str) -> str:
    box.say(text)
    return "Added log message"


COMMANDS: dict[str, Callable[[ControlBox], str]] = {
    "robotmode": lambda box: f"Robotmode: {box.robot_mode.name}",
    "safetymode": lambda box: f"Safetymode: {box.safety_mode.name}",
    "safetystatus": lambda box: f"Safetystatus: {box.safety_mode.name}",
    "programState": lambda box: f"{box.state.name} {box.loaded or '<unnamed>'}",
    "running": lambda box: f"Program running: {str(box.state == RuntimeState.PLAYING).lower()}",
    "PolyscopeVersion": lambda box: "URSoftware {}.{}.{}.{} (Jan 01 2024)".format(*box.software),
    "get robot model": lambda box: box.arm.rig.robot.name.upper().removesuffix("E"),
    "get serial number": lambda _: SERIAL_NUMBER,
    "get loaded program": _loaded,
    "is in remote control": lambda _: "true",
    "isProgramSaved": lambda box: f"true {box.loaded}",
    "power on": _power_on,
    "power off": _power_off,
    "brake release": _brake_release,
    "unlock protective stop": _unlock,
    "close safety popup": lambda _: "closing safety popup",
    "restart safety": lambda _: "Restarting safety",
    "close popup": lambda _: "closing popup",
    "play": _play,
    "stop": _stop,
    "pause": _pause,
    "quit": lambda _: "Disconnected",
    "shutdown": lambda _: "Shutting down",
}
WITH_ARGUMENT: dict[str, Callable[[ControlBox, str], str]] = {
    "load": _load,
    "popup": lambda _, __: "showing popup",
    "addToLog": _log,
    "setUserRole": lambda _, role: f"Setting user role: {role}",
}
