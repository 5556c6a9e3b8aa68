"""Recordings read through their entries in a study, given as plain data."""

from collections.abc import Iterable, Mapping
from typing import Any

from ur5lib.checks.devices import checked_intake
from ur5lib.recordings import formats, intake
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import Intake
from ur5lib.recordings.recording import RawRecording
from ur5lib.records.account import AccountRow
from ur5lib.robots.description import Robot


def read_recording(entry: Mapping[str, Any]) -> RawRecording:
    return formats.read_recording(ENTRY.validate_python(entry))


def read_and_check(entry: Mapping[str, Any], arm: Robot, max_gap: float) -> Intake:
    repaired = intake.read_and_repair(ENTRY.validate_python(entry), arm, max_gap)
    return checked_intake(repaired, arm)


def in_words(account: Iterable[AccountRow]) -> str:
    """The rows of an account, a line each."""
    return "\n".join(
        f"{row.confidence}: {row.subject}: {row.taken_for}: {row.reason}" for row in account
    )
