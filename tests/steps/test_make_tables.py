"""The study's tables from the rows of its recordings and arms."""

import re
from ast import literal_eval
from dataclasses import fields, replace
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.conftest import PROJECT
from tests.made_tables import COLUMNS, record, table
from ur5lib.force.residual_model import Residuals
from ur5lib.records.accelerations import Difference, ImuComparison
from ur5lib.records.codes import Found
from ur5lib.records.contacts import Contacts
from ur5lib.records.force_errors import Compared
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import CurrentError, Judgement
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot
from ur5lib.steps.make_tables import (
    OF_ARMS,
    OF_MOTION,
    OF_RECORDINGS,
    Fits,
    Inputs,
    joined,
    make_tables,
)
from ur5lib.tables import read_csv, write_csv

DETAIL = 'x, "y"'
ONE, TWO = Found.JITTER, Found.SPLIT
PARAMETER = {"joint": 2, "name": "coulomb", "value": 6.0, "std_error": 0.1, "interval": [5, 7]}


def made(arm: Robot, judgements: dict[str, Judgement], **more: Any) -> dict[str, pd.DataFrame]:
    """The tables of a study of one arm."""
    friction = record(Friction, {"parameters": [PARAMETER]})
    fits = {"rotors": Rotors(), "identification": Identification(), "friction": friction}
    nothing = {"compared": Compared(), "contacts": Contacts(), "comparison": ImuComparison()}
    known = {field: more.pop(field, {}) for field in nothing}
    recordings = {
        name: Inputs(**nothing | {f: own[name] for f, own in known.items() if name in own})
        for name in chain.from_iterable(known.values())
    }
    arms = {"ur5": Fits(identified=arm, **fits)}
    known = {"calibration": {"ur5": {}}, "residuals": {"ur5": Residuals()}}
    known |= {"parts": [], "unreadable": {}}
    return make_tables(judgements, recordings, arms, **known | more)


def judged(*findings: Found) -> Judgement:
    return Judgement(findings=[Finding("robot", name, "note", 1, DETAIL) for name in findings])


def test_rows_of_recordings_and_of_arms_make_one_table_each(ur5: Robot) -> None:
    """All tables are there, with all their columns, whether a recording has a row or none."""
    found = made(ur5, {"a": judged(ONE, TWO), "b": Judgement(), "c": judged(ONE)})
    assert {name: [*own] for name, own in found.items()} == COLUMNS
    rows = found["quality"]
    assert [*zip(rows["recording"], rows["code"], strict=True)] == [
        ("a", ONE),
        ("a", TWO),
        ("c", ONE),
    ]
    assert rows["detail"].eq(DETAIL).all()
    assert found["friction"][["robot", "parameter"]].to_numpy().tolist() == [["ur5", "coulomb"]]
    assert found["torque_constants"].empty
    assert found["force_mae"].empty


def test_a_recording_that_cannot_be_read_is_a_stop_sign_and_changes_no_other(ur5: Robot) -> None:
    known = {"a": judged(ONE), "c": judged(TWO)}
    rest, found = made(ur5, known), made(ur5, known, unreadable={"b": "line 3 is none"})
    for name in rest.keys() - {"quality"}:
        pd.testing.assert_frame_equal(found[name], rest[name])
    quality = found["quality"].set_index("recording")
    stop = quality.loc["b"]
    assert (stop["severity"], stop["code"]) == ("stop", Found.UNREADABLE)
    assert stop["detail"] == "line 3 is none"
    others = quality.drop(index="b")
    pd.testing.assert_frame_equal(others, rest["quality"].set_index("recording"))


def test_bands_of_acceleration_are_of_the_other_recordings(ur5: Robot) -> None:
    """Of those that are there."""
    difference = {"below 2 Hz": {"at rest": Difference(np.ones(6), np.ones((101, 6)))}}
    imu = ImuComparison(
        calibrated_on=["a", "b", "gone"], ranges=difference, plain_ranges=difference
    )
    judgements = dict.fromkeys("ab", Judgement())
    both, alone = (
        made(ur5, judgements, comparison={name: replace(imu) for name in names})
        for names in ("ab", "a")
    )
    assert {*both["acceleration_bands"]["recording"]} == {"a", "b"}
    assert alone["acceleration_bands"].empty


def test_what_steps_have_written_for_each_arm_is_joined_as_it_is(tmp_path: Path) -> None:
    """Numbers as text; cells may contain commas and quotation marks, an arm may have no row."""
    parts = []
    whole = pd.DataFrame({"value": [0.1, 1e-20, 3.0], "detail": [DETAIL, "", "z"]})
    for arm, rows in (("a", whole[:2]), ("b", whole[:0]), ("c", whole[2:])):
        for name in ("health", "other"):
            parts.append(tmp_path / arm / f"{name}.csv")
            write_csv(rows, parts[-1])
    found = joined(parts)
    assert found.keys() == {"health", "other"}
    write_csv(found["health"], tmp_path / "health.csv")
    write_csv(whole.assign(robot=["a", "a", "c"])[["robot", *whole]], tmp_path / "expected.csv")
    assert (tmp_path / "health.csv").read_text() == (tmp_path / "expected.csv").read_text()


def test_rows_are_written_plainly(tmp_path: Path) -> None:
    """As yes and no, and Python's own numbers; of a recording without a row, nothing."""
    numbers = dict.fromkeys(COLUMNS["current_rmse"][4:], np.float32(0.5))
    row = CurrentError(model="fitted", fitted=np.bool_(True), joint=np.int64(2), **numbers)
    plain = table(CurrentError, {"a": [row], "b": []})
    cells = [plain[name].item() for name in ("fitted", "joint", "rmse")]
    assert cells == ["yes", 2, 0.5]
    assert [type(cell) for cell in cells] == [str, int, float]
    write_csv(plain, tmp_path / "current_rmse.csv")
    back = read_csv(tmp_path / "current_rmse.csv")
    assert [*back] == COLUMNS["current_rmse"]
    assert back["recording"].tolist() == ["a"]


def test_the_rule_names_the_tables_that_the_step_makes() -> None:
    """As the workflow knows them without the library's classes."""
    rules = (PROJECT / "workflow" / "rules" / "common.smk").read_text()
    (named,) = re.findall(r"^TABLES = (\[.*?\])", rules, re.MULTILINE | re.DOTALL)
    assert sorted(literal_eval(named)) == sorted(OF_RECORDINGS | OF_MOTION | OF_ARMS)


# A sensor, and a role that says whether anything touches the arm

ROLES = {"fitted": "fit", "seen": "validate", "pushed": "contact"}


def sensed(contacts: int = 0, **more: Any) -> Compared:
    reading = {"largest_force_n": 33.4, "at_s": 1.0, "contacts": contacts}
    found: Compared = record(Compared, {"sensed": reading, **more})
    return found


def of_roles(arm: Robot, **more: Any) -> dict[str, pd.DataFrame]:
    names = {"judgements": dict.fromkeys(ROLES, Judgement())} | more
    return made(arm, **names, roles=ROLES)


def test_a_sensor_that_reads_contacts_beats_the_role(ur5: Robot) -> None:
    """As an error, which takes the place of the warning of its raw readings, not of the robot's."""
    raw = Judgement(
        findings=[
            Finding("force", Found.CONTACT, "warning", 9, "up to 42 N"),
            Finding("robot", Found.CONTACT, "warning", 1, "up to 42 N"),
        ]
    )
    judgements = dict.fromkeys(ROLES, raw)
    found = of_roles(ur5, judgements=judgements, compared=dict.fromkeys(ROLES, sensed(2)))
    rows = found["quality"].groupby("recording")
    for name, role in ROLES.items():
        own = rows.get_group(name).set_index(["device", "code"])
        assert (("force", "touched") in own.index) == (role != "contact")
        assert (("force", "contact") in own.index) == (role == "contact")
        assert ("robot", "contact") in own.index
    error = found["quality"].query("code == 'touched' and recording == 'seen'").iloc[0]
    assert (error["severity"], error["count"]) == ("error", 2)
    assert error["detail"] == (
        "the sensor reads up to 33 N in 2 contacts, although the role validate means that nothing "
        "touches the arm; give it the role contact"
    )


@pytest.mark.parametrize("others", [{"compared": dict.fromkeys(ROLES, sensed(0))}, {}])
def test_a_raw_contact_alone_stays_a_warning(ur5: Robot, others: dict[str, Any]) -> None:
    """As of an undeclared load that turns."""
    raw = Judgement(findings=[Finding("force", Found.CONTACT, "warning", 9, "up to 42 N")])
    found = of_roles(ur5, judgements=dict.fromkeys(ROLES, raw), **others)["quality"]
    assert [*found["code"]] == [Found.CONTACT] * 3


def test_what_sensor_and_contacts_tell_is_in_the_tables(ur5: Robot) -> None:
    beside = record(Compared, {"sensed": {}, "errors": [{}]})
    contacts = record(Contacts, {field.name: [{}] for field in fields(Contacts)})
    found = made(
        ur5,
        dict.fromkeys("ab", Judgement()),
        compared={"a": Compared(), "b": beside},
        contacts={"a": Contacts(), "b": contacts},
    )
    filled = {name for name, rows in found.items() if [*rows.get("recording", ())] == ["b"]}
    tables = {"sensed", "force_mae", "contact_errors", "detection", "fixed_threshold", "contacts"}
    tables |= {"contact_place"}
    assert filled == tables
