"""The entry of a new recording, checked and appended to its study."""

from pathlib import Path
from typing import Any

import yaml
from rich.console import Console

from ur5lib.commands.check import print_findings_of
from ur5lib.recorder.capture import Status
from ur5lib.recorder.lab import Lab
from ur5lib.study.reading import parse_study
from ur5lib.tables import write_text


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
