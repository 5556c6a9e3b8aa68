"""The parts of a study that `ur5 record` reads, and the entry that it adds."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import yaml
from pydantic import TypeAdapter, ValidationError
from rich.console import Console

from ur5lab.recorder.capture import Status
from ur5lab.recorder.opened import file_entry
from ur5lib.commands.check import print_findings_of
from ur5lib.errors import InputError
from ur5lib.strict import explain
from ur5lib.study.arms import ArmSettings, Name, NamedArm
from ur5lib.study.devices import LabSettings
from ur5lib.study.reading import PlainData, parse_study, read_plain
from ur5lib.study.turn import reserved
from ur5lib.tables import write_text

DEVICES_EXAMPLE = "devices: {robot: {address: 192.168.1.10}}"


@dataclass(frozen=True)
class StudyFile:
    """A study's file and its content; recordings may be added to it."""

    path: Path
    plain: PlainData

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a study's file. Raises InputError if it is no study."""
        return cls(path, read_plain(path))

    def name(self) -> str:
        """Return the study's name. Raises InputError where it is not allowed."""
        return checked_name(str(self.plain.get("study")))

    def lab(self) -> LabSettings:
        """Return the devices that the study names. Raises InputError with all mistakes."""
        if "devices" not in self.plain:
            raise InputError(f"{self.path} has no `devices`; add, for example, {DEVICES_EXAMPLE}")
        try:
            return LabSettings.model_validate(self.plain["devices"])
        except ValidationError as error:
            mistakes = [
                explain(detail, LabSettings.model_json_schema()) for detail in error.errors()
            ]
            lines = [f"{self.path}: devices: {text}" for text in mistakes]
            raise InputError("\n".join(lines)) from error

    def arm(self) -> ArmSettings:
        """Return the arm of the study. Raises InputError where it names no described arm."""
        try:
            robot = TypeAdapter[Any](NamedArm).validate_python(self.plain.get("robot"))
        except ValidationError as error:
            raise InputError(
                f"{self.path}: `robot` names no described arm; give one, e.g. `robot: ur5e`"
            ) from error
        return ArmSettings(arm=robot) if isinstance(robot, str) else robot

    def enter(self, entry: dict[str, Any], add: bool, console: Console) -> int:
        """Check an entry, then append or print it; return the number of stop signs and errors."""
        alone = {"study": self.plain["study"], "title": self.plain.get("title", "")}
        whole = alone | {"robot": self.plain["robot"], "recordings": [entry]}
        severe = print_findings_of(parse_study(whole, str(self.path)))
        text = yaml.safe_dump([entry], sort_keys=False, allow_unicode=True)
        if add and self._append(text):
            added = f"{self.path}: {entry['name']} added"
            console.print(f"{added}; next: ur5 run {self.path}")
        else:
            console.print(f"add to `recordings` of {self.path}:\n{text}", soft_wrap=True)
        return severe

    def _append(self, text: str) -> bool:
        """Append an entry as text to the file, after what others have appended since it was read;
        return False where its layout prevents that.
        """
        with reserved(self.path, wait=True):
            return self._append_alone(text)

    def _append_alone(self, text: str) -> bool:
        lines = self.path.read_text(encoding="utf-8").rstrip() + "\n"
        plain = read_plain(self.path)
        lines += "" if "recordings" in plain else "recordings:\n"
        whole = [*(plain.get("recordings") or []), *yaml.safe_load(text)]
        for indent in ("", "  "):
            candidate = lines + "".join(f"{indent}{line}\n" for line in text.splitlines())
            try:
                read = yaml.safe_load(candidate)
            except yaml.YAMLError:
                continue
            if read == {**plain, "recordings": whole}:
                write_text(candidate, self.path)
                return True
        return False


def checked_name(name: str) -> str:
    """Return the name of a recording unchanged. Raises InputError where it is not allowed."""
    try:
        return str(TypeAdapter[str](Name).validate_python(name))
    except ValidationError as error:
        raise InputError(
            f"{name!r} cannot name a recording; use letters, digits, `_`, `-` and dots"
        ) from error


def entry_of(lab: LabSettings, statuses: dict[str, Status]) -> dict[str, Any]:
    """Return the keys of a recording's entry that name the files of all devices that sent
    samples.
    """
    keys = file_entry(lab.robot, "robot.csv")
    for name, device in lab.devices().items():
        if name != "robot" and name in statuses and statuses[name].samples:
            keys[name] = file_entry(device, f"{name}.csv")
    return keys
