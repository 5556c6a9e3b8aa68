"""The dashboard server, port 29999: one command a line, one answer a line.

Source: Universal Robots' dashboard server guide, CB-Series and e-Series.
"""

from asyncio import StreamReader, StreamWriter
from itertools import repeat

from ur5lab.doubles.control_box import ControlBox
from ur5lab.rtde_variables import RobotMode, RuntimeState, SafetyMode

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
    if line in (states := _states(box)):
        return states[line]
    command, _, argument = line.partition(" ")
    match command, argument.strip():
        case "power", "on":
            if box.robot_mode == RobotMode.POWER_OFF:
                box.robot_mode = RobotMode.IDLE
            return "Powering on"
        case "power", "off":
            box.stop()
            box.robot_mode = RobotMode.POWER_OFF
            return "Powering off"
        case "brake", "release":
            box.robot_mode = RobotMode.RUNNING
            return "Brake releasing"
        case "unlock", "protective stop":
            released = box.unlock()
            reason = "Cannot unlock protective stop until 5s after occurrence"
            return "Protective stop releasing" if released else reason
        case "load", name if name:
            box.loaded = name
            return f"Loading program: {name}"
        case "addToLog", text if text:
            box.say(text)
            return "Added log message"
        case "setUserRole", role if role:
            return f"Setting user role: {role}"
        case "popup", text if text:
            return "showing popup"
        case (("play" | "pause" | "stop"), ""):
            return _control(command, box)
    return f"could not understand: '{line}'"


def _control(command: str, box: ControlBox) -> str:
    """Play, pause or stop the program, and return the answer."""
    if command == "stop":
        box.stop()
        return "Stopped"
    if command == "pause" and box.state == RuntimeState.PLAYING:
        box.paused = True
        return "Pausing program"
    if command == "play" and box.state == RuntimeState.PAUSED:
        box.paused = False
        return "Starting program"
    if command == "play" and box.loaded and box.safety_mode == SafetyMode.NORMAL:
        box.run(repeat(None))
        return "Starting program"
    return f"Failed to execute: {command}"


def _states(box: ControlBox) -> dict[str, str]:
    """Return, by command, the answers to commands that only ask for a state."""
    loaded = f"Loaded program: {box.loaded}" if box.loaded else "No program loaded"
    return {
        "robotmode": f"Robotmode: {box.robot_mode.name}",
        "safetymode": f"Safetymode: {box.safety_mode.name}",
        "safetystatus": f"Safetystatus: {box.safety_mode.name}",
        "programState": f"{box.state.name} {box.loaded or '<unnamed>'}",
        "running": f"Program running: {str(box.state == RuntimeState.PLAYING).lower()}",
        "PolyscopeVersion": "URSoftware {}.{}.{}.{} (Jan 01 2024)".format(*box.software),
        "get robot model": box.arm.rig.robot.name.upper().removesuffix("E"),
        "get serial number": SERIAL_NUMBER,
        "get loaded program": loaded,
        "is in remote control": "true",
        "isProgramSaved": f"true {box.loaded}",
        "close safety popup": "closing safety popup",
        "restart safety": "Restarting safety",
        "close popup": "closing popup",
        "quit": "Disconnected",
        "shutdown": "Shutting down",
    }
