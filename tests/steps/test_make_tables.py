"""The study's tables from the rows of its recordings and arms."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.made_tables import record
from ur5lib.force.residual_model import Residuals
from ur5lib.records.accelerations import Difference, ImuComparison
from ur5lib.records.contacts import Detected
from ur5lib.records.force_errors import Compared
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import Judgement
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot
from ur5lib.steps.make_tables import bands_of_accelerations, joined, make_tables
from ur5lib.tables import read_csv, write_csv
from ur5lib.tidy import columns, rows_of, table

DETAIL = 'x, "y"'
PARAMETER = {"joint": 2, "name": "coulomb", "value": 6.0, "std_error": 0.1, "interval": [5, 7]}


def made(arm: Robot, judgements: dict[str, Judgement], **more: Any) -> dict[str, pd.DataFrame]:
    """The tables of a study of one arm."""
    friction = record(Friction, {"parameters": [PARAMETER]})
    more = {"beside_sensor": {}, "contacts": {}} | more
    fits = {"rotors": Rotors(), "identification": Identification(), "calibration": {}}
    fits |= {"fitted": friction, "residuals": Residuals()}
    each = {name: {"ur5": own} for name, own in {"arm": arm, **fits}.items()}
    return make_tables(
        judgements, **{"parts": [], "unreadable": {}, "beside_imu": {}} | each | more
    )


def judged(*findings: str) -> Judgement:
    return Judgement(findings=[Finding("robot", name, "note", 1, DETAIL) for name in findings])


def test_rows_of_recordings_and_of_arms_make_one_table_each(ur5: Robot) -> None:
    """All tables are there, with all their columns, whether a recording has a row or none."""
    found = made(ur5, {"a": judged("one", "two"), "b": Judgement(), "c": judged("one")})
    assert {name: [*own] for name, own in found.items()} == columns()
    rows = found["quality"]
    assert [*zip(rows["recording"], rows["finding"], strict=True)] == [
        ("a", "one"),
        ("a", "two"),
        ("c", "one"),
    ]
    assert rows["detail"].eq(DETAIL).all()
    assert found["friction"][["robot", "parameter"]].to_numpy().tolist() == [["ur5", "coulomb"]]
    assert found["torque_constants"].empty
    assert found["force_mae"].empty


def test_a_recording_that_cannot_be_read_is_a_stop_sign_and_changes_no_other(ur5: Robot) -> None:
    known = {"a": judged("one"), "c": judged("two")}
    rest, found = made(ur5, known), made(ur5, known, unreadable={"b": "line 3 is none"})
    for name in rest.keys() - {"quality"}:
        pd.testing.assert_frame_equal(found[name], rest[name])
    quality = found["quality"].set_index("recording")
    stop = quality.loc["b"]
    assert (stop["severity"], stop["finding"]) == ("stop", "unreadable")
    assert stop["detail"] == "line 3 is none"
    others = quality.drop(index="b")
    pd.testing.assert_frame_equal(others, rest["quality"].set_index("recording"))


def test_bands_of_acceleration_are_of_the_other_recordings(ur5: Robot) -> None:
    """Of those that are there."""
    difference = {"below 2 Hz": {"at rest": Difference(np.ones(6), np.ones((101, 6)))}}
    imu = ImuComparison(
        calibrated_on=["a", "b", "gone"], ranges=difference, plain_ranges=difference
    )
    bands = bands_of_accelerations({name: replace(imu) for name in "ab"})
    assert {*bands["recording"]} == {"a", "b"}
    assert bands_of_accelerations({"a": imu}).empty


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
    """As yes and no, Python's own numbers, and nothing that is no column."""
    row = {"fitted": np.bool_(True), "joint": np.int64(2), "rmse": np.float32(0.5), "grid": []}
    (plain,) = rows_of("current_rmse", [row])
    assert plain == {"fitted": "yes", "joint": 2, "rmse": 0.5}
    assert [type(value) for value in plain.values()] == [str, int, float]
    write_csv(table("current_rmse", {"a": [row], "b": []}), tmp_path / "current_rmse.csv")
    back = read_csv(tmp_path / "current_rmse.csv")
    assert [*back] == columns()["current_rmse"]
    assert back["recording"].tolist() == ["a"]


# A sensor, and a role that says whether anything touches the arm

ERRORS = {"mae": {"Fx": 2.0, "nx": 0.1}}
DOUBT = {"code": "disputed bias", "text": "only 30% of the samples agree"}
ROLES = {"fitted": "fit", "seen": "validate", "pushed": "contact"}


def sensed(contacts: int = 0, **more: Any) -> Compared:
    felt = {"largest": 33.4, "at_s": 1.0, "contact": 0.1, "contacts": contacts}
    found: Compared = record(Compared, {"felt": felt, **more})
    return found


def of_roles(arm: Robot, roles: dict[str, str] | None = ROLES, **more: Any) -> dict[str, Any]:
    names = {"judgements": dict.fromkeys(ROLES, Judgement())} | more
    return made(arm, **names, roles=roles)


def test_a_sensor_that_reads_contacts_beats_the_role(ur5: Robot) -> None:
    """As an error, which takes the place of the warning of its raw readings, not of the robot's."""
    raw = Judgement(
        findings=[
            Finding("force", "contact", "warning", 9, "up to 42 N"),
            Finding("robot", "contact", "warning", 1, "up to 42 N"),
        ]
    )
    judgements = dict.fromkeys(ROLES, raw)
    found = of_roles(ur5, judgements=judgements, beside_sensor=dict.fromkeys(ROLES, sensed(2)))
    rows = found["quality"].groupby("recording")
    for name, role in ROLES.items():
        own = rows.get_group(name).set_index(["device", "finding"])
        assert (("force", "touched") in own.index) == (role != "contact")
        assert (("force", "contact") in own.index) == (role == "contact")
        assert ("robot", "contact") in own.index
    error = found["quality"].query("finding == 'touched' and recording == 'seen'").iloc[0]
    assert (error["severity"], error["count"]) == ("error", 2)
    assert error["detail"] == (
        "the sensor reads up to 33 N in 2 contacts, although the role validate means that nothing "
        "touches the arm; give it the role contact"
    )


@pytest.mark.parametrize("others", [{"beside_sensor": dict.fromkeys(ROLES, sensed(0))}, {}])
def test_a_raw_contact_alone_stays_a_warning(ur5: Robot, others: dict[str, Any]) -> None:
    """As of an undeclared load that turns."""
    raw = Judgement(findings=[Finding("force", "contact", "warning", 9, "up to 42 N")])
    found = of_roles(ur5, judgements=dict.fromkeys(ROLES, raw), **others)["quality"]
    assert [*found["finding"]] == ["contact"] * 3


def detected_by(*alarms: dict[str, Any]) -> dict[str, Detected]:
    same = {"force": [3.0, 0.0, 4.0], "force_std": [1.0] * 3, "q": [0.0]}
    raised = [same | one for one in alarms]
    found: dict[str, Detected] = record(dict[str, Detected], {"Fmap": {"raised": raised}})
    return found


def loaded(taken: str) -> Judgement:
    return Judgement({"payload": [{"mass": 2.0, "taken": taken}]})


@pytest.mark.parametrize(
    ("roles", "own", "taken", "kinds"),
    [
        (ROLES, {}, "no", ["false", "false", "contact"]),
        (None, {}, "no", ["contact"] * 3),
        (ROLES, {}, "yes", ["contact"] * 3),
        (ROLES, {"off_flange": True}, "no", ["false", "false", "off_flange"]),
        (ROLES, {"kind": "load"}, "no", ["load"] * 3),
        (ROLES, {"at_sensor": True}, "no", ["contact"] * 3),
        (ROLES, {"at_sensor": False}, "no", ["false"] * 3),
    ],
)
def test_the_kinds_of_alarms_by_role_load_and_sensor(
    ur5: Robot, roles: dict[str, str] | None, own: dict[str, Any], taken: str, kinds: list[str]
) -> None:
    contacts = dict.fromkeys(ROLES, detected_by(own))
    judgements = dict.fromkeys(ROLES, loaded(taken))
    found = of_roles(ur5, roles, judgements=judgements, contacts=contacts)
    assert dict(found["contacts"][["recording", "kind"]].to_numpy()) == dict(
        zip(ROLES, kinds, strict=True)
    )


@pytest.mark.parametrize(
    ("doubt", "estimate", "uses"),
    [
        (None, "Fmap", [("no", "fitted"), ("yes", ""), ("yes", "")]),
        (None, "static", [("no", "fitted"), *[("yes", "uncalibrated")] * 2]),
        (DOUBT, "Fmap", [("no", "fitted"), *[("no", "sensor_bias")] * 2]),
        (DOUBT, "static", [("no", "fitted"), *[("no", "sensor_bias")] * 2]),
    ],
)
def test_which_errors_of_the_force_may_be_relied_on(
    ur5: Robot, doubt: dict[str, Any] | None, estimate: str, uses: list[tuple[str, str]]
) -> None:
    """Of forces in contact, also in those that are missed; nothing is said of other errors."""
    periods = dict.fromkeys(["contact", "missed", "free", "all"], ERRORS)
    errors = {kind: {estimate: periods} for kind in ("compensated", "corrected")}
    own = sensed(errors=errors, offset_doubt=doubt)
    rows = of_roles(ur5, beside_sensor=dict.fromkeys(ROLES, own))["force_mae"]
    judged = (rows["kind"] == "compensated") & rows["during"].isin(["contact", "missed"])
    judged &= rows["component"] == "Fx"
    assert rows.loc[~judged, ["use", "reason"]].isna().all(axis=None)
    assert {*rows.loc[judged, "during"]} == {"contact", "missed"}
    for name, use in zip(ROLES, uses, strict=True):
        told = rows[judged & (rows["recording"] == name)]
        assert {*zip(told["use"], told["reason"], strict=True)} == {use}
