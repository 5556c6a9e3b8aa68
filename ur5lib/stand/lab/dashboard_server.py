"""The dashboard server, port 29999: one command a line, one answer a line.

Source: Universal Robots' dashboard server guide, CB-Series and e-Series.
"""

import asyncio
from collections.abc import Callable, Iterator

from ur5lib.stand.lab.connection import Connection
from ur5lib.stand.lab.control_box import ControlBox, RobotMode, RuntimeState, SafetyMode

WELCOME = "Connected: Universal Robots Dashboard Server"
SERIAL_NUMBER = "20260000001"
PROGRAM_STATES = {
    RuntimeState.STOPPED: "STOPPED",
    RuntimeState.PLAYING: "PLAYING",
    RuntimeState.PAUSED: "PAUSED",
}


class DashboardClient(Connection):
    """One client's connection."""

    def __init__(self, box: ControlBox) -> None:
        super().__init__(box)
        self._text = ""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Send the welcome line."""
        super().connection_made(transport)
        self._send(WELCOME)

    def data_received(self, data: bytes) -> None:
        """Answer all complete lines."""
        *lines, self._text = (self._text + data.decode("utf-8", "replace")).split("\n")
        for line in lines:
            self._send(answer(line.strip(), self.box))
            if line.strip() in ("quit", "shutdown"):
                self.transport.close()

    def _send(self, text: str) -> None:
        self.transport.write(f"{text}\n".encode())


def answer(line: str, box: ControlBox) -> str:
    """Execute a command and return the answer to it."""
    if line in COMMANDS:
        return COMMANDS[line](box)
    for start, command in WITH_ARGUMENT.items():
        if line.startswith(f"{start} "):
            return command(box, line.removeprefix(start).strip())
    return f"could not understand: '{line}'"


def _robot_mode(box: ControlBox) -> str:
    return f"Robotmode: {box.robot_mode.name}"


def _safety_mode(box: ControlBox) -> str:
    return f"Safetymode: {box.safety_mode.name}"


def _safety_status(box: ControlBox) -> str:
    return f"Safetystatus: {box.safety_mode.name}"


def _program_state(box: ControlBox) -> str:
    return f"{PROGRAM_STATES[box.state]} {box.loaded or '<unnamed>'}"


def _running(box: ControlBox) -> str:
    return f"Program running: {str(box.state == RuntimeState.PLAYING).lower()}"


def _version(box: ControlBox) -> str:
    return "URSoftware {}.{}.{}.{} (Jan 01 2024)".format(*box.software)


def _model(box: ControlBox) -> str:
    return box.arm.rig.robot.name.upper().removesuffix("E")


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
    box.run(_idle())
    return "Starting program"


def _idle() -> Iterator[None]:
    while True:
        yield


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


def _fixed(text: str) -> Callable[[ControlBox], str]:
    return lambda _: text


COMMANDS: dict[str, Callable[[ControlBox], str]] = {
    "robotmode": _robot_mode,
    "safetymode": _safety_mode,
    "safetystatus": _safety_status,
    "programState": _program_state,
    "running": _running,
    "PolyscopeVersion": _version,
    "get robot model": _model,
    "get serial number": _fixed(SERIAL_NUMBER),
    "get loaded program": _loaded,
    "is in remote control": _fixed("true"),
    "isProgramSaved": lambda box: f"true {box.loaded}",
    "power on": _power_on,
    "power off": _power_off,
    "brake release": _brake_release,
    "unlock protective stop": _unlock,
    "close safety popup": _fixed("closing safety popup"),
    "restart safety": _fixed("Restarting safety"),
    "close popup": _fixed("closing popup"),
    "play": _play,
    "stop": _stop,
    "pause": _pause,
    "quit": _fixed("Disconnected"),
    "shutdown": _fixed("Shutting down"),
}
WITH_ARGUMENT: dict[str, Callable[[ControlBox, str], str]] = {
    "load": _load,
    "popup": lambda _, __: "showing popup",
    "addToLog": _log,
    "setUserRole": lambda _, role: f"Setting user role: {role}",
}
