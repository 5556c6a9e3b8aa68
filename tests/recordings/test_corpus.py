"""Damaged recordings: the right data with the damage named, or one clear error. Nothing else."""

import re
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given

from tests.command import time_limit
from tests.corpus import Base, Case, bases, other_cases, usual_cases
from tests.damage import DRAWS, compare, drawn, findings
from tests.entries import read_and_check
from ur5lib.commands.check import print_tables, unusable
from ur5lib.commands.console import text_console
from ur5lib.errors import InputError
from ur5lib.recordings.intake import Intake
from ur5lib.records.codes import Found
from ur5lib.records.quality import Device, Quality
from ur5lib.robots.description import Robot

pytestmark = pytest.mark.slow

WIDTH = 1000  # of the terminal, so that no line is broken
SECONDS = 10  # for one recording
JARGON = re.compile(
    r"Traceback|Error\b|Exception|Arrow|pandas|numpy|NoneType|dtype|KeyError|0x[0-9a-f]+"
)
PLACE = "the folder"
PRINTED = set[str]()  # the findings that were printed without fault, without their numbers


@dataclass(frozen=True)
class Answer:
    """What a recording gave: data or an error, and how the data compare with the undamaged.

    quality: as `ur5 check` prints it, the error among the findings;
    wrong: cells that are told as received but differ; lost: frames fewer; named: new findings.
    """

    error: str | None
    quality: Quality
    wrong: int = 0
    lost: int = 0
    named: frozenset[str] = frozenset()


def answer(case: Case, arm: Robot, whole: Intake) -> Answer:
    """Take a damaged recording in and compare it with the undamaged one."""
    with TemporaryDirectory() as folder:
        entry = case.written(Path(folder))
        try:
            with time_limit(SECONDS):
                taken = read_and_check(entry, arm, max_gap=0.1)
        except InputError as error:
            answer = str(error).replace(folder, PLACE)  # its name is random
            return Answer(answer, unusable(error))
    named = findings(taken) - findings(whole)
    wrong, lost = compare(taken.robot, whole.robot, start_of(case), case.base.name != "table")
    if case.part != "robot":
        assert (wrong, lost) == (0, 0), "a sensor's damage took the robot's data with it"
        wrong, lost = compare_sensor(taken, whole, "imu" if case.part == "imu" else "force")
    return Answer(None, taken.quality, wrong, lost, frozenset(name for name, _, _ in named))


def start_of(case: Case) -> float:
    """How much later than the undamaged recording's the clock of this one starts [s]."""
    if case.expected.lost == 0:
        return 0.0
    rows = case.base.text(next(iter(case.base.files)), 0).rows
    return float(rows[case.expected.lost][0]) - float(rows[0][0])


def compare_sensor(taken: Intake, whole: Intake, device: Device) -> tuple[int, int]:
    """The same for a sensor, on its own clock."""
    if device not in taken.sensors:
        return 0, len(whole.sensors[device])
    mine, truth = (
        intake.sensors[device].assign(segment=0, interpolated=False) for intake in (taken, whole)
    )
    wrong, lost = compare(mine, truth, 0.0, True)
    starts = [intake.quality.starts[device].seconds for intake in (taken, whole)]
    return wrong + int(abs(starts[0] - starts[1]) > 1e-3) * len(mine), lost


@pytest.fixture(scope="module")
def undamaged(thesis_data: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Base]:
    return bases(tmp_path_factory.mktemp("corpus"), thesis_data)


@pytest.fixture(scope="module")
def wholes(undamaged: list[Base], ur5: Robot) -> dict[str, Intake]:
    return {base.name: read_and_check(base.recording, ur5, 0.1) for base in undamaged}


def test_the_undamaged_ones_are_read_without_complaint(wholes: dict[str, Intake]) -> None:
    for base, whole in wholes.items():
        assert {name for name, _, _ in findings(whole)} <= {
            Found.NO_SENSOR,
            Found.IRREGULAR_STEPS,
        }, base


def test_every_damaged_recording_gets_an_honest_answer(
    undamaged: list[Base], wholes: dict[str, Intake], ur5: Robot
) -> None:
    """All of them in one test, so that the list of those that fail reads as one."""
    cases = [case for base in undamaged for case in usual_cases(base)]
    assert len(cases) >= 200
    assert len({case.label for case in cases}) == len(cases)
    objections = {case.label: objection(case, ur5, wholes[case.base.name]) for case in cases}
    told = [f"{label}: {text}" for label, text in objections.items() if text]
    assert not told, "\n".join(told)


@drawn(12)
@given(draw=DRAWS)
def test_so_does_any_damage_to_any_recording(
    undamaged: list[Base], wholes: dict[str, Intake], ur5: Robot, draw: Random
) -> None:
    case = draw.choice([case for base in undamaged for case in other_cases(base)])
    assert objection(case, ur5, wholes[case.base.name]) is None, case.label


def objection(case: Case, arm: Robot, whole: Intake) -> str | None:
    """What is dishonest, or not as expected, in the answer to a damaged recording."""
    try:
        given = answer(case, arm, whole)
    except Exception as error:
        return f"{type(error).__name__}: {error}"  # what must never reach a user
    if fault := fault_of_print(case, given.quality):
        return fault
    if given.error is not None:
        return fault_of_error(case, given.error)
    if (given.wrong or given.lost) and not given.named:
        return f"silently wrong: {given}"
    return None if as_expected(case, given) else f"{case.expected} but {given}"


def fault_of_print(case: Case, quality: Quality) -> str | None:
    """What is wrong with the tables that `ur5 check` prints of a recording, each once but for
    numbers.
    """
    form = re.sub(r"\d+", "0", str([case.base.name, *quality.findings]))
    if form in PRINTED and "steering" not in case.kind:
        return None
    console = text_console(file=(screen := StringIO()), width=WIDTH)
    failed = print_tables(console, {case.base.name: quality}, {})
    printed = screen.getvalue()
    if not printed.replace("\n", "").isprintable():
        return f"prints control characters: {printed!r}"
    wanted = {finding.code.words for finding in quality.findings}
    wanted |= {"[/x][red]:x:"} if "steering" in case.kind else set()
    left_out = {text for text in wanted if text not in printed}
    errors = sum(finding.severity == "error" for finding in quality.findings)
    if left_out or failed != errors:
        return f"prints no {left_out}, {failed} errors"
    PRINTED.add(form)
    return None


def fault_of_error(case: Case, error: str) -> str | None:
    if case.expected.outcome != "refused" or not re.search(case.expected.words, error):
        return f"{case.expected} but error: {error}"
    clear = "\n" not in error and "; " in error and PLACE in error
    return None if clear and not JARGON.search(error) else f"unclear: {error}"


def as_expected(case: Case, given: Answer) -> bool:
    expected = case.expected
    if expected.outcome == "same":
        return not (given.wrong or given.lost or given.named)
    if expected.outcome == "repaired":
        return given.wrong == 0 and expected.words in given.named
    return expected.outcome == "told" and expected.words in given.named
