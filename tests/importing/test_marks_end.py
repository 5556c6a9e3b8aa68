"""What a mark names ends it: with the true value of its option, import marks it no more, and the
channel is right.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import chdir
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.importing.net import SHARED, UNKNOWN, Import, made_imports, state
from tests.importing.test_import_random_forms import wrongs
from tests.random_forms import BY_NAME, IN_AMPERES, SERVOS, SEVEN, RandomLog, drawn
from ur5lib.channels import MEASURED_EFFORTS
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.records.account import AccountRow
from ur5lib.robots.description import load_robot, robot_path

OPTIONS = re.compile(r"--(robot|rate|unit|columns|joints)(?: (\w+)=)?")
IN_THE_ENTRY = ": opposite`"  # the sign, under `units`, which the option --unit writes
MOST_ROUNDS = 6
CLOCK = {"time", "t", "timestamp", "Time", "stamp", "__time"}
COUNTS = 2.69e-3  # A of one


class Truth(NamedTuple):
    """What options state of a log; unit: of its effort, by channel; angle: of its positions."""

    robot: str
    rate: float
    unit: tuple[str, str]
    angle: str = "rad"
    columns: tuple[str, ...] = ()
    numbers: tuple[int, ...] = ()


def truth_of(log: RandomLog) -> Truth:
    count = log.channels["actual_q"].shape[1]
    turned = log.form["order"] == "by name" and count == len(BY_NAME) and is_in_file_order(log)
    numbers = tuple(joint + 1 for joint in (BY_NAME if turned else range(count)))
    robot, rate = log.arm.name if log.arm else "", 1 / float(log.time[1])
    return Truth(robot, rate, unit_of(log), log.form["angle"], tuple(columns_of(log)), numbers)


def unit_of(log: RandomLog) -> tuple[str, str]:
    """The channel of a log's measured effort, and its unit as an option states it."""
    form, joints = log.form, log.channels["actual_q"].shape[1]
    channel = "actual_current" if form["effort"] in IN_AMPERES else "actual_current_as_torque"
    channel = "actual_torque" if form["arm"] == SEVEN else channel
    sign = np.full(joints, -1.0 if form["sign"] == "opposite" else 1.0)
    sign[2] = -1.0 if form["sign"] == "one turned" else sign[2]
    if form["effort"] in ("A", "mA", "Nm") and (sign > 0).all():
        return channel, form["effort"]
    of_ur = log.arm if form["arm"] == "ur" else None
    most = [of_ur.motor(k).torque_max for k in of_ur.joint_numbers] if of_ur else [1.0] * joints
    sizes = {"mA": 1e-3, "counts": COUNTS, "motors": 101.0}
    sizes |= {"permille": np.array(most) / 1000, "percent": np.array(most) / 100}
    values = sign * sizes.get(form["effort"], 1.0)
    if form["order"] == "by name" and is_in_file_order(log):
        values = values[[*BY_NAME]]
    return channel, ",".join(f"{value:.6g}" for value in values)


def is_in_file_order(log: RandomLog) -> bool:
    """Whether nothing in a log names its joints, so that values are in the order of its columns."""
    return log.form["names"] not in ("ros", "plotjuggler", "named bag")


def columns_of(log: RandomLog) -> list[str]:
    """`--columns` of a log: channels in the order of a table without names, else by name."""
    channels = {"q": "actual_q", "qd": "actual_qd", "target": "target_q"}
    effort = "-" if log.effort is None else unit_of(log)[0]
    channels |= dict.fromkeys(("i", "tau"), effort)
    if log.form["names"] != "none":
        return [f"{channels[q]}={n[0]}" for q, n in log.quantities.items() if q in channels]
    found = list[str]()
    for column in log.table:
        quantity = next((q for q, names in log.quantities.items() if column in names), "")
        channel, names = channels.get(quantity, "-"), log.quantities.get(quantity, [column])
        if column in CLOCK:
            found.append("time")
        elif channel == "-":
            found.append("-")
        elif column == names[0]:
            found.append(channel)
    return found


def ended(truth: Truth, stated: UserStatement, row: AccountRow) -> UserStatement | None:
    """The statement with the true value of the first option that a mark names and that is not
    stated yet, None without one.
    """
    channel_of_effort, unit = truth.unit
    for option, channel in OPTIONS.findall(row.reason):
        if option == "robot" and truth.robot and stated.robot != truth.robot:
            return replace(stated, robot=truth.robot)
        if option == "rate" and not stated.rate:
            return replace(stated, rate=truth.rate)
        of_effort = channel in (*MEASURED_EFFORTS, channel_of_effort)
        if option == "unit" and of_effort and channel_of_effort not in stated.units:
            return replace(stated, units={**stated.units, channel_of_effort: unit})
        if option == "unit" and channel == "actual_q" and channel not in stated.units:
            return replace(stated, units={**stated.units, channel: truth.angle})
        if option == "joints" and not stated.joint_numbers:
            return replace(stated, joint_numbers=truth.numbers)
        if option == "columns" and not stated.columns:
            return replace(stated, columns=truth.columns)
    if IN_THE_ENTRY in row.reason and channel_of_effort not in stated.units:
        return replace(stated, units={**stated.units, channel_of_effort: unit})
    return None


def rounds(
    path: Path, told: UserStatement, truth: Truth
) -> Iterator[tuple[UserStatement, ImportedRecording]]:
    """Statements and imports, each with what ends a mark of the one before."""
    stated = told
    for _ in range(MOST_ROUNDS):
        (found,) = import_files([path], stated)
        yield stated, found
        further = (ended(truth, stated, row) for row in marks(found))
        new = next(filter(None, further), None)
        if new is None:
            return
        stated = new


def marks(found: ImportedRecording) -> list[AccountRow]:
    return [row for row in found.account if row.confidence == "check"]


def left(log: RandomLog) -> list[str]:
    """What is marked or wrong after all rounds, but for arms that nobody describes."""
    if log.effort is not None:  # in whatever unit
        log.channels.setdefault(unit_of(log)[0], log.effort)
    try:
        (_, first), *others = rounds(log.path, log.told, truth_of(log))
    except InputError as error:
        if log.form["names"] == "none":  # which is refused until its columns are named
            return []
        return [str(error)]
    if not others:
        return [row.reason for row in marks(first) if not is_arm_to_describe(log, row)]
    found = others[-1][1]
    undone = [row for row in marks(found) if not is_arm_to_describe(log, row)]
    return [*(f"{row.subject}: {row.reason}" for row in undone), *wrongs(log, found)[0]]


def is_arm_to_describe(log: RandomLog, row: AccountRow) -> bool:
    """Whether a mark asks for a description that a drawn log has no URDF for."""
    return log.form["arm"] == SERVOS and row.subject == "robot" and "ur5 describe" in row.reason


@pytest.mark.parametrize("seed", range(16))
def test_marks_of_random_forms_end(seed: int, tmp_path: Path) -> None:
    with chdir(tmp_path):
        log = drawn(seed, tmp_path)
        assert left(log) == [], log.form


@pytest.mark.slow
@pytest.mark.thorough
def test_marks_of_three_hundred_forms_end(tmp_path: Path) -> None:
    undone = dict[int, list[str]]()
    for seed in range(300):
        folder = tmp_path / str(seed)
        folder.mkdir()
        with chdir(folder):
            undone[seed] = left(drawn(seed, folder))
    assert {seed: own for seed, own in undone.items() if own} == {}


def made_truth(one: Import) -> Truth:
    """The truth of a form that the net makes of a log of a UR10e."""
    arm, kind = load_robot(robot_path("ur10e")), Path(one.file).name
    rated = [arm.motor(joint).torque_max / 100 for joint in arm.joint_numbers]
    values: Mapping[str, tuple[str, Sequence[float]]] = {
        "per cent": ("actual_current_as_torque", rated),
        "one factor": ("actual_current", [1 / 0.37]),
        "turned": ("actual_current", [-1.0] * 6),
    }
    own = next((pair for name, pair in values.items() if f" {name} " in kind), None)
    if own is not None:
        unit = own[0], ",".join(f"{value:.6g}" for value in own[1])
    else:
        names = {" A ": "A", " mA ": "mA", " Nm ": "Nm"}
        written = next((unit for name, unit in names.items() if name in kind), "Nm")
        channel = "actual_current" if "A" in written else "actual_current_as_torque"
        unit = "actual_torque_less_gravity" if "less gravity" in kind else channel, written
    columns = () if "nameless" not in kind else ("time", "actual_q", "actual_qd", unit[0])
    return Truth("ur10e", 100.0, unit, columns=columns, numbers=(1, 2, 3, 4, 5, 6))


KINDS = ("A", "mA", "Nm", "less gravity", "one factor", "per cent", "turned")


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.skipif(not SHARED.is_dir(), reason="the reference data are not here")
def test_marks_of_the_nets_forms_end(kind: str, tmp_path: Path) -> None:
    log = "20_01_31-unload"
    tried = [
        one for one in made_imports(SHARED, tmp_path) if f"{log} {kind} " in one.file
    ]  # fmt: skip
    assert len(tried) == 6
    for one in tried:
        truth = made_truth(one)
        *_, (_, found) = rounds(one.path, one.told, truth)
        assert marks(found) == [], one.file
        assert found.arm == truth.robot
        columns = found.entry["columns"]
        channel = truth.unit[0] if truth.unit[0] in columns else "actual_current"
        assert channel in columns, (one.file, columns)
        taken = next(r.taken_for for r in found.account if r.taken_for.startswith(channel))
        known = [own for name, own in one.truth.items() if name != "robot"]
        assert UNKNOWN not in taken or UNKNOWN in known, one.file
        assert known == [UNKNOWN] or state(taken, "proven", known[0]) in ("right", ""), one.file
