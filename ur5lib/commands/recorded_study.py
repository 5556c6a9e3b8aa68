"""What `ur5 record` reads from a study, and the entry of a new recording that it adds."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import TypeAdapter, ValidationError
from rich.console import Console

from ur5lib.commands.check import print_findings_of
from ur5lib.errors import InputError
from ur5lib.recorder.capture import Status
from ur5lib.recorder.lab import Lab
from ur5lib.study.arms import Arm, Name, NamedArm
from ur5lib.study.reading import parse_study
from ur5lib.study.schema import explain
from ur5lib.tables import write_text

EXAMPLE = "devices: {robot: {address: 192.168.1.10}}"


def lab_of(plain: dict[str, Any], path: Path) -> Lab:
    """Return the devices that a study names. Raises InputError with all mistakes."""
    if "devices" not in plain:
        raise InputError(f"{path} has no `devices`; add, for example, {EXAMPLE}")
    try:
        return Lab.model_validate(plain["devices"])
    except ValidationError as error:
        mistakes = [explain(detail, Lab.model_json_schema()) for detail in error.errors()]
        raise InputError("\n".join(f"{path}: devices: {text}" for text in mistakes)) from error


def arm_of(plain: dict[str, Any], path: Path) -> Arm:
    """Return the arm of a study. Raises InputError where it names no described arm."""
    try:
        robot = TypeAdapter[Any](NamedArm).validate_python(plain.get("robot"))
    except ValidationError as error:
        raise InputError(
            f"{path}: `robot` names no described arm; give one, e.g. `robot: ur5e`"
        ) from error
    return Arm(arm=robot) if isinstance(robot, str) else robot


def checked_name(name: str) -> str:
    """Return the name of a recording. Raises InputError where it is not allowed."""
    try:
        return str(TypeAdapter[str](Name).validate_python(name))
    except ValidationError as error:
        raise InputError(
            f"{name!r} cannot name a recording; use letters, digits, `_`, `-` and dots"
        ) from error


def entry_of(lab: Lab, statuses: dict[str, Status]) -> dict[str, Any]:
    """Return the keys of an entry with the files of all devices that sent samples."""
    keys = lab.robot.entry("robot.csv")
    for name, device in lab.devices().items():
        if name != "robot" and name in statuses and statuses[name].samples:
            keys[name] = device.entry(f"{name}.csv")
    return keys


def enter(
    entry: dict[str, Any], path: Path, plain: dict[str, Any], add: bool, console: Console
) -> int:
    """Check an entry, then append it to the study, or print it; returns stop signs and errors."""
    alone = {"study": plain["study"], "title": plain.get("title", "")}
    study = parse_study(alone | {"robot": plain["robot"], "recordings": [entry]}, str(path))
    severe = print_findings_of(study)
    text = yaml.safe_dump([entry], sort_keys=False, allow_unicode=True)
    if add and _append(text, entry, path, plain):
        console.print(f"{path}: {entry['name']} added; next: snakemake --configfile {path}")
    else:
        console.print(f"add to `recordings` of {path}:\n{text}", soft_wrap=True)
    return severe


def _append(text: str, entry: dict[str, Any], path: Path, plain: dict[str, Any]) -> bool:
    """Append an entry as text to the study's file; return False where its layout prevents that."""
    lines = path.read_text(encoding="utf-8").rstrip() + "\n"
    lines += "" if "recordings" in plain else "recordings:\n"
    for indent in ("", "  "):
        candidate = lines + "".join(f"{indent}{line}\n" for line in text.splitlines())
        try:
            read = yaml.safe_load(candidate)
        except yaml.YAMLError:
            continue
        if read == plain | {"recordings": [*(plain.get("recordings") or []), entry]}:
            write_text(candidate, path)
            return True
    return False
