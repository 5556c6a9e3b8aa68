"""Postures at rest, without time: torque constants by gravity, and what gravity cannot tell."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from tests.current_study import coefficients, noisy, smooth
from tests.current_study import prior as known_prior
from tests.recordings.test_recordings_of_joints import sensing
from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.checked import arms_alike
from ur5lib.checks.postures import _likelier_arm
from ur5lib.commands.check import look_through
from ur5lib.errors import InputError
from ur5lib.identification.at_rest import AtRest
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.current_samples import ZeroPhaseLowpass, prior_of
from ur5lib.identification.currents import parameters
from ur5lib.recordings.entries import ENTRY, Files
from ur5lib.recordings.postures import read_postures
from ur5lib.records.codes import Found
from ur5lib.records.friction import Friction, Parameter
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.steps.fit_friction import ContradictionError, fitted_friction
from ur5lib.steps.read_postures import checked_postures
from ur5lib.study.reading import parse_study
from ur5lib.timeseries.arrays import Array

ROWS, DRY = 680, 0.05  # Coulomb friction, of the motor's largest torque
Drawn = tuple[Array, Array, Array]  # positions, currents, torque constants


@cache
def described(name: str) -> Robot:
    return load_robot(robot_path(name))


def drawn(
    arm: Robot,
    typical: Array,
    rows: int = ROWS,
    seed: int = 0,
    payload: Payload | None = None,
    spread: float = 0.08,
) -> Drawn:
    """Postures of an arm with constants near typical ones; static friction holds it, too."""
    random = np.random.default_rng(seed)
    joints, most = len(arm.joints), np.array(arm.torque_limits())
    q = random.uniform(-2.5, 2.5, (rows, joints))
    constants = typical * np.exp(random.normal(0, spread, joints))
    torque = gravity_torque(arm.carrying(payload), arm.chosen_model, q)
    return q, (torque + random.uniform(-DRY, DRY, q.shape) * most) / constants, constants


def of_ur(name: str, **how: Any) -> Drawn:
    return drawn(described(name), 1 / prior(name).inverse_constant.mean, **how)


@cache
def prior(name: str) -> Any:
    return prior_of(described(name), [])


def written(folder: Path, q: Array, current: Array) -> dict[str, Any]:
    """A log of postures, and its entry."""
    np.savetxt(folder / "log.csv", np.column_stack([q, current]), delimiter=",", fmt="%.6f")
    names = [f"{name}_{j}" for name in ("actual_q", "actual_current") for j in range(q.shape[1])]
    entry = {"format": "table-csv", "folder": str(folder), "file": "log.csv", "columns": names}
    return entry | {"still": True}


def entry_of(folder: Path, q: Array, current: Array, **changes: Any) -> Files:
    return ENTRY.validate_python(written(folder, q, current) | changes)


def constants_of(friction: Friction) -> list[Parameter]:
    return [row for row in friction.parameters if row.name == "torque_constant"]


def fitted(
    folder: Path, name: str, q: Array, current: Array, payload: Payload | None = None
) -> Friction:
    """The fit of an arm to postures alone, as the workflow does it."""
    arm = described(name)
    postures, _ = checked_postures(entry_of(folder, q, current), arm, payload, None)
    torque = postures.held_torque(arm, arm.chosen_model)
    known = replace(prior(name), at_rest=AtRest.of([(torque, postures.current)]))
    return fitted_friction([], known, ZeroPhaseLowpass(4, 2.0))


# Torque constants


@pytest.mark.parametrize("name", ["ur5", "ur16e"])
def test_gravity_tells_the_constants_of_the_joints_that_bear(tmp_path: Path, name: str) -> None:
    """Within their errors on as many arms as should, whatever friction at rest holds."""
    away = []
    for seed in range(8):
        q, current, truth = of_ur(name, seed=seed)
        friction = fitted(tmp_path, name, q, current)
        rows = constants_of(friction)
        away += [(row.value - truth[row.joint - 1]) / row.std_error for row in rows]
        assert [row.joint for row in rows if row.determined] == [2, 3, 4]
        for row in rows[1:4]:
            assert row.std_error < 0.04 * row.value
    assert 0.7 < np.sqrt(np.mean(np.square(away))) < 1.3


def test_friction_is_what_is_typical(tmp_path: Path) -> None:
    """Of a recording at rest, it is unknown; of unknown motors, it is not stated at all."""
    q, current, truth = of_ur("ur16e")
    friction = fitted(tmp_path, "ur16e", q, current)
    others = [row for row in friction.parameters if row.name != "torque_constant"]
    assert others
    assert all(row.prior_share > 0.999 for row in others)
    arm = described("ur16e")
    torque = gravity_torque(arm, arm.chosen_model, q)
    alone = replace(prior_of(arm, []), typical={}, at_rest=AtRest.of([(torque, current)]))
    friction = fitted_friction([], alone, ZeroPhaseLowpass(4, 2.0))
    assert not friction.fit.joints
    assert friction.refused is not None
    assert len(constants_of(friction)) == len(friction.parameters) == 6
    assert constants_of(friction)[1].value == pytest.approx(truth[1], rel=0.03)


def test_a_payload_lets_a_wrist_bear_something(tmp_path: Path) -> None:
    load = Payload(mass=3.0, center_of_mass=(0.0, 0.0, 0.15))
    q, current, truth = of_ur("ur5", payload=load)
    rows = constants_of(fitted(tmp_path, "ur5", q, current, load))
    assert [row.joint for row in rows if row.determined] == [2, 3, 4, 5]
    for row in rows[1:5]:
        assert abs(row.value - truth[row.joint - 1]) < 4 * row.std_error


def test_the_mean_of_friction_at_rest_changes_no_constant(tmp_path: Path) -> None:
    q, current, _ = of_ur("ur5")
    right = constants_of(fitted(tmp_path, "ur5", q, current))
    shifted = constants_of(fitted(tmp_path, "ur5", q, current + 0.5))
    for own, other in zip(right, shifted, strict=True):
        assert own.value == pytest.approx(other.value, rel=1e-4)


def test_constants_of_another_unit_are_refused(tmp_path: Path) -> None:
    q, current, _ = of_ur("ur5", rows=25)  # too few for a stop sign
    with pytest.raises(ContradictionError):
        fitted(tmp_path, "ur5", q, 4 * current)


def test_postures_and_motion_tell_constants_together() -> None:
    """The constants gain, friction stays what the motions show."""
    records, known = noisy(range(3)), known_prior()
    random = np.random.default_rng(1)
    torque = random.normal(0, 20, (400, 6))
    slope = np.array([coefficients(joint)[0] for joint in range(6)])
    current = (torque + random.uniform(-5, 5, torque.shape)) * slope
    together = replace(known, at_rest=AtRest.of([(torque, current)]))
    without, beside = (
        {(row.joint, row.name): row for row in parameters(fit_currents(records, smooth, own))}
        for own in (known, together)
    )
    for joint in range(1, 7):
        own, other = beside[joint, "torque_constant"], without[joint, "torque_constant"]
        assert abs(own.value - 1 / slope[joint - 1]) < 4 * own.std_error
        assert own.std_error < 1.1 * other.std_error
        friction = beside[joint, "coulomb"], without[joint, "coulomb"]
        assert abs(friction[0].value - friction[1].value) < 2 * friction[1].std_error
    told = sum(beside[j, "torque_constant"].std_error for j in range(1, 7))
    assert told < 0.8 * sum(without[j, "torque_constant"].std_error for j in range(1, 7))


def test_any_number_of_joints_may_rest(tmp_path: Path) -> None:
    arm = sensing(7)
    q, torque, _ = drawn(arm, np.ones(7), spread=0.0)
    names = [f"{name}_{j}" for name in ("actual_q", "actual_torque") for j in range(7)]
    entry = entry_of(tmp_path, q, torque, columns=names)
    postures, quality = checked_postures(entry, arm, None, None)
    assert not postures.contradictions.stop_signs
    assert quality.frames == ROWS
    held = postures.held_torque(arm, arm.chosen_model)
    known = replace(prior_of(arm, []), at_rest=AtRest.of([(held, postures.current)]))
    rows = constants_of(fitted_friction([], known, ZeroPhaseLowpass(4, 2.0)))
    assert len(rows) == 7
    for row in rows:
        assert row.value == pytest.approx(1.0, abs=4 * row.std_error)


# Reading


def test_rows_of_one_posture_are_one(tmp_path: Path) -> None:
    """Their friction is one: ten rows of it are no ten witnesses."""
    q, current, _ = of_ur("ur5", rows=40)
    noise = np.random.default_rng(2).normal(0, 1e-4, (400, 6))
    entry = entry_of(tmp_path, np.repeat(q, 10, axis=0) + noise, np.repeat(current, 10, axis=0))
    table, quality = read_postures(entry, described("ur5"))
    assert (quality.rows, quality.frames) == (400, 40)
    np.testing.assert_allclose(table[[f"actual_q_{j}" for j in range(6)]], q, atol=1e-3)
    np.testing.assert_allclose(table["actual_current_1"], current[:, 1], atol=1e-5)


def test_postures_without_currents_are_refused(tmp_path: Path) -> None:
    q, current, _ = of_ur("ur5", rows=40)
    entry = entry_of(tmp_path, q, current, columns=["actual_q", "-", "-", "-", "-", "-", "-"])
    with pytest.raises(
        InputError, match=r"log.csv: has no actual_current_0 .*; name their columns"
    ):
        read_postures(entry, described("ur5"))


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"columns": ["time", "actual_q", "actual_current"]}, "both `time` and `still`; remove"),
        ({"rate": 125}, "has `rate`; remove"),
        ({"from_s": 3}, "has `from_s`; remove"),
        ({"force_sensor": {"file": "f.csv", "columns": ["time", "ft"]}}, "`force_sensor`; remove"),
        ({"role": "contact"}, "role contact; give it the role fit"),
    ],
)
def test_what_needs_time_contradicts_rest(
    tmp_path: Path, changes: dict[str, Any], fault: str
) -> None:
    entry = written(tmp_path, np.zeros((2, 6)), np.zeros((2, 6)))
    entry |= {"name": "p", "robot": "ur5", "role": "fit"} | changes
    with pytest.raises(InputError, match=f"`recordings.0.`.*{fault}"):
        parse_study({"study": "s", "title": "t", "recordings": [entry]}, "study.yaml")


def test_the_entry_of_files_alone_is_checked_too(tmp_path: Path) -> None:
    entry = written(tmp_path, np.zeros((2, 6)), np.zeros((2, 6)))
    with pytest.raises(ValidationError, match="names no `time`"):
        ENTRY.validate_python(entry | {"still": False})


# Checks


def checked(folder: Path, name: str, q: Array, current: Array) -> list[Finding]:
    """What `ur5 check` says of postures."""
    entry = written(folder, q, current) | {"name": "p", "robot": name, "role": "fit"}
    study = parse_study({"study": "s", "title": "t", "recordings": [entry]}, "study.yaml")
    return look_through(study.recordings[0], study)[0].findings


@pytest.mark.parametrize("name", ["ur5", "ur3e", "ur16e", "ur20"])
@pytest.mark.parametrize("rows", [60, ROWS])
def test_right_postures_have_a_note_on_what_was_not_checked(
    tmp_path: Path, name: str, rows: int
) -> None:
    for seed in range(4):
        q, current, _ = of_ur(name, rows=rows, seed=seed)
        (found,) = checked(tmp_path, name, q, current)
        assert (found.code, found.severity, found.count) == ("postures", "note", rows)
        shares = dict(re.findall(r"joint (\d): (\d+)%", found.detail))
        assert int(shares["2"]) > 85
        hidden = re.search(r"; joints ([\d, ]+), on which gravity hardly shows", found.detail)
        assert hidden is not None
        assert {"1", "6"} <= {*hidden[1].split(", ")}


ORDER = [0, 2, 1, 3, 4, 5]
MISTAKES = {
    "another arm": lambda q, i: ("ur3", q, i),
    "exchanged currents": lambda q, i: ("ur5", q, i[:, ORDER]),
    "exchanged joints": lambda q, i: ("ur5", q[:, ORDER], i[:, ORDER]),
    "elbow first": lambda q, i: ("ur5", q[:, [2, 1, 0, 3, 4, 5]], i[:, [2, 1, 0, 3, 4, 5]]),
    "milliampere": lambda q, i: ("ur5", q, 1000 * i),
    "degrees": lambda q, i: ("ur5", np.degrees(q), i),
    "newton-metres": lambda q, i: ("ur5", q, 10.7 * i),
    "turned current": lambda q, i: ("ur5", q, i * [1, -1, 1, 1, 1, 1]),
    "turned current of the elbow": lambda q, i: ("ur5", q, i * [1, 1, -1, 1, 1, 1]),
    "turned joint": lambda q, i: ("ur5", q * [1, -1, 1, 1, 1, 1], i),
    "other columns": lambda q, i: ("ur5", q, np.random.default_rng(5).normal(size=i.shape)),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_what_gravity_contradicts_is_said(tmp_path: Path, mistake: str) -> None:
    q, current, _ = of_ur("ur5", rows=300, seed=3)
    severe = [
        one
        for one in checked(tmp_path, *MISTAKES[mistake](q, current))
        if one.severity in ("stop", "error")
    ]
    assert len(severe) == 1


def test_an_arm_that_is_far_likelier_is_not_called_alike(tmp_path: Path) -> None:
    q, current, _ = of_ur("ur5", rows=300, seed=3)
    sign, note = checked(tmp_path, "ur3", q, current)
    named = re.search(r"`robot: (\w+)`", sign.detail)
    assert named is not None
    assert not re.search(rf"\b{named[1]}\b", note.detail)


@pytest.mark.parametrize(("parts", "told"), [(1, False), (10, True)])
def test_another_arm_is_told_by_most_postures(parts: int, told: bool) -> None:
    """Not by those of one part, as of a hand on the arm."""
    arm = described("ur3")
    q, current, _ = of_ur("ur5", rows=300, seed=3)
    own = gravity_torque(arm, arm.chosen_model, q) * prior("ur3").inverse_constant.mean
    share = np.arange(len(q)) * 10 // len(q) < parts
    currents = {"actual_current": np.where(share[:, None], current, own)}
    means = BlockMeans(q, 0 * q, 0 * q, None, currents, offset=True, independent=1.0)
    assert (_likelier_arm(means, arm, arms_alike(arm, None)) is not None) == told


def test_a_larger_arm_is_doubted_by_its_constants(tmp_path: Path) -> None:
    """Its gravity is alike: the constants alone tell it."""
    q, current, _ = of_ur("ur5", rows=300, seed=3)
    doubts = [one for one in checked(tmp_path, "ur10e", q, current) if one.severity == "warning"]
    assert [one.code for one in doubts] == [Found.TORQUE_CONSTANTS]


def held_by_friction(seed: int, constants: Array, part: bool = False) -> tuple[Array, Array]:
    """Postures of a UR5 whose static friction is anything up to 1.5 Nm on a wrist, or a part of
    what gravity pulls, at most that.
    """
    arm, random = described("ur5"), np.random.default_rng(seed)
    q, most = random.uniform(-2.5, 2.5, (ROWS, 6)), np.array([6.7] * 3 + [1.5] * 3)
    torque = gravity_torque(arm, arm.chosen_model, q)
    share = random.uniform(0 if part else -1, 1, q.shape)
    return q, (torque - share * (torque.clip(-most, most) if part else most)) / constants


def published(of: str) -> Array:
    """Torque constants of a UR5: of its motors in newer arms, or of the thesis's table."""
    arm = described("ur5")
    newer = of == "newer arms"
    return np.array(arm.family_torque_constants() if newer else arm.maker_torque_constants())


@pytest.mark.parametrize(
    ("constants", "part"), [("newer arms", False), ("table", False), ("newer arms", True)]
)
def test_ordinary_static_friction_is_no_reason_to_doubt(
    tmp_path: Path, constants: str, part: bool
) -> None:
    """A wrist's is as large as what it bears, and the constants known of it differ by 1.8."""
    for seed in range(4):
        (found,) = checked(tmp_path, "ur5", *held_by_friction(seed, published(constants), part))
        assert (found.code, found.severity) == ("postures", "note")


@pytest.mark.parametrize("joint", [1, 2])
@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_a_wrong_constant_is_doubted_where_gravity_is_large(
    tmp_path: Path, joint: int, factor: float
) -> None:
    for seed in range(4):
        wrong = published("newer arms") * np.where(np.arange(6) == joint, factor, 1.0)
        found = checked(tmp_path, "ur5", *held_by_friction(seed, wrong))
        assert [one.code for one in found if one.severity != "note"] == [
            "contradiction" if factor < 1 else Found.TORQUE_CONSTANTS
        ]


def test_few_postures_check_nothing(tmp_path: Path) -> None:
    q, current, _ = of_ur("ur5", rows=20)
    (found,) = checked(tmp_path, "ur10e", q, current)
    assert "too few to check arm, units and the joints' order" in found.detail
