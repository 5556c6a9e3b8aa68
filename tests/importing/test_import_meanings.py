"""What `ur5 import` takes columns for of which names or numbers alone tell too little."""

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.io

from tests.conftest import shared_folder
from tests.entries import in_words, read_recording
from tests.stored_files import Made, made_up_channels
from ur5lib.importing.contents import UserStatement, contents
from ur5lib.importing.files import ImportedRecording, add_to_study, import_files, write_study
from ur5lib.tables import channel


def case(name: str, folder: Path) -> Path:
    """A file of the public cases, unpacked into a folder."""
    stored = shared_folder("cases-6", "they are not published") / name
    if stored.suffix != ".gz":
        return stored
    (folder / stored.stem).write_bytes(gzip.decompress(stored.read_bytes()))
    return folder / stored.stem


def imported(path: Path, robot: str = "") -> tuple[ImportedRecording, str]:
    (one,) = import_files([path], UserStatement(robot))
    return one, in_words(one.account)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


@pytest.mark.parametrize(
    "names",
    [
        *("joint{n}", "J{n}", "A{n}", "axis{n}", "joint_{n}", "panda_joint{n}", "Joint {n} [deg]"),
        *("panda_joint{n}/position", "pos_panda_joint{n}", "{letter}", "{letter} [deg]"),
    ],
)
def test_bare_names_of_joints_are_positions(tmp_path: Path, made: Made, names: str) -> None:
    """Which is to be checked, unless a quantity is named, with the unit in brackets."""
    unit = 180 / np.pi if "deg" in names else 1.0
    columns = {
        names.format(n=n, letter=letter): unit * rows
        for (n, letter), rows in zip(enumerate("SLURBT", 1), made[1]["actual_q"].T, strict=True)
    }
    path = tmp_path / "run.csv"
    pd.DataFrame({"time": made[0]} | columns).to_csv(path, index=False)
    one, told = imported(path, "ur5")
    q = channel(read_recording(one.entry).robot.table, "actual_q")
    np.testing.assert_allclose(q, made[1]["actual_q"], atol=1e-12)
    assert ("to be: positions" in told) == ("pos" not in names)


@pytest.mark.parametrize("effort", ["A{n} Motormoment [Nm]", "A{n} Drehmoment [Nm]", ""])
def test_bare_names_beside_efforts_are_positions(tmp_path: Path, made: Made, effort: str) -> None:
    """As of KUKA's trace; alone, they may be anything of the joints."""
    columns = {"Zeit [s]": made[0]}
    for n in range(6):
        columns[f"A{n + 1} Ist [Grad]"] = np.degrees(made[1]["actual_q"][:, n])
        if effort:
            columns[effort.format(n=n + 1)] = 12 * made[1]["actual_current"][:, n]
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", sep=";", decimal=",", index=False)
    one, told = imported(tmp_path / "run.csv", "ur5")
    read = channel(read_recording(one.entry).robot.table, "actual_q")
    np.testing.assert_allclose(read, made[1]["actual_q"], atol=1e-9)
    sure = "assumed" if effort else "check"
    assert f"{sure}: A1 Ist [Grad] … A6 Ist [Grad]: actual_q [deg]" in told
    assert effort.format(n=1) in told


def test_seven_bare_names_are_joints_beside_a_pose(tmp_path: Path, made: Made) -> None:
    q = np.column_stack([made[1]["actual_q"], made[1]["actual_q"][:, 0]])
    columns = {"time": made[0]} | {f"current_pos_{axis}": np.sin(made[0]) for axis in "xyz"}
    columns |= {f"joint_{k + 1}": rows for k, rows in enumerate(q.T)}
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    one, _ = imported(tmp_path / "run.csv")
    assert one.entry["columns"][-7:] == [f"actual_q_{k}" for k in range(7)]


@pytest.mark.parametrize("robot", ["", "ur5"])
def test_seven_columns_are_no_wrench(tmp_path: Path, made: Made, robot: str) -> None:
    """With seven joints or six and a gripper's, external torques may have a wrench's name."""
    q = np.column_stack([made[1]["actual_q"], np.clip(made[1]["actual_q"][:, 0], 0, 1)])
    columns = {"time": made[0]} | {f"q_{k}": rows for k, rows in enumerate(q.T)}
    columns |= {f"TCPWrench_{k}": np.sin(made[0] + k) for k in range(7)}
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    _, told = imported(tmp_path / "run.csv", robot)
    assert "left out: TCPWrench_0 … TCPWrench_6: nothing: 7 columns, no wrench" in told


def test_a_second_clock_is_no_joint(tmp_path: Path, made: Made) -> None:
    """In a table without names, it would move every group of columns by one."""
    q, qd = made[1]["actual_q"], made[1]["actual_qd"]
    rows = np.column_stack([made[0], 1.7e9 + made[0], q, qd])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", fmt="%.9f")
    one, told = imported(tmp_path / "run.csv", "ur5")
    assert "column 2: nothing: another clock" in told
    np.testing.assert_allclose(
        channel(read_recording(one.entry).robot.table, "actual_q"), q, atol=1e-8
    )


def test_nameless_angles_without_velocities_are_the_slowest(tmp_path: Path, made: Made) -> None:
    """Which is to be checked, and the next is named; a drift of all columns is none."""
    time, channels = made
    drift = 30 + np.outer(time, np.linspace(0.01, 0.02, 6))
    rows = np.column_stack([time, channels["actual_current"], drift, channels["actual_q"]])
    np.savetxt(tmp_path / "run.csv", rows, delimiter=",", fmt="%.9f")
    one, told = imported(tmp_path / "run.csv", "ur5")
    read = channel(read_recording(one.entry).robot.table, "actual_q")
    np.testing.assert_allclose(read, channels["actual_q"], atol=1e-8)
    assert "check: column 14 … column 19: actual_q: the block of 6 columns" in told


@pytest.mark.parametrize("letters", ["SLURBT", "SLEURBT"])
def test_quantities_of_lettered_joints(tmp_path: Path, made: Made, letters: str) -> None:
    """As of Yaskawa's arms: in the order of their letters, below a header of their own."""
    motion = {name: made[1][f"actual_{name}"][:, [0, 1, 2, 3, 4, 5, 0][: len(letters)]]
              for name in ("q", "qd")}  # fmt: skip
    columns = {"TIME": made[0]} | {
        f"{letter}_{name}": motion[name.replace("POS", "q").replace("SPD", "qd")][:, k]
        for name in ("POS", "SPD")
        for k, letter in reversed([*enumerate(letters)])
    }
    text = pd.DataFrame(columns).to_csv(index=False)
    (tmp_path / "run.csv").write_text(f"/JOB MOTION.JBI\n///POS\n{text}")
    one, _ = imported(tmp_path / "run.csv")
    table = read_recording(one.entry).robot.table
    for name, rows in motion.items():
        np.testing.assert_allclose(channel(table, f"actual_{name}"), rows, atol=1e-9)


@pytest.mark.parametrize("robot", ["", "ur5"])
def test_pulses_are_to_be_checked_until_they_have_a_unit(
    tmp_path: Path, made: Made, robot: str
) -> None:
    """As Yaskawa's controllers count them, below a header of their own; the remedy reads them."""
    per_radian = np.array([85000.0, 90000.0, 70000.0, 58000.0, 58000.0, 34000.0])
    pulses = np.round(made[1]["actual_q"] * per_radian)
    columns = {f"{letter}_POS": rows for letter, rows in zip("SLURBT", pulses.T, strict=True)}
    text = pd.DataFrame({"TIME": made[0]} | columns).to_csv(index=False)
    (tmp_path / "run.csv").write_text(f"/JOB MOTION.JBI\n///PULSE\n{text}")
    one, told = imported(tmp_path / "run.csv", robot)
    assert "check: S_POS … T_POS: actual_q" in told
    assert "counts of encoders" in told
    assert "`units: {actual_q: […]}`" in told
    entry = one.entry | {"units": {"actual_q": (1 / per_radian).tolist()}}
    read = channel(read_recording(entry).robot.table, "actual_q")
    np.testing.assert_allclose(read, made[1]["actual_q"], atol=2e-5)


@pytest.mark.parametrize(
    ("positions", "velocities", "efforts", "effort_channel", "per_unit"),
    [
        ("axis{n}_rad", "axis{n}_rad_s", "axis{n}_A", "actual_current", 1.0),
        ("Joint {n} [deg]", "Joint {n} [deg/s]", "Motor {n} current [mA]", "actual_current", 1e-3),
        ("J{n}_rad", "J{n}_rad_s", "J{n}_torque [kgf.cm]", "actual_current_as_torque", 0.0980665),
        ("q{n} [rad]", "qd{n} [rad/s]", "torque{n} [N.cm]", "actual_current_as_torque", 0.01),
    ],
)
def test_units_in_names_say_what_their_columns_are(
    tmp_path: Path,
    made: Made,
    positions: str,
    velocities: str,
    efforts: str,
    effort_channel: str,
    per_unit: float,
) -> None:
    """Of joints and motors without a further name, and in units that a study does not have."""
    angle = 180 / np.pi if "deg" in positions else 1.0
    effort = made[1]["actual_current"] * (1.0 if effort_channel == "actual_current" else 10.0)
    columns = {
        name.format(n=n + 1): rows[:, n]
        for n in range(6)
        for name, rows in (
            (positions, angle * made[1]["actual_q"]),
            (velocities, angle * made[1]["actual_qd"]),
            (efforts, effort / per_unit),
        )
    }
    path = tmp_path / "run.csv"
    pd.DataFrame({"time": made[0]} | columns).to_csv(path, index=False)
    one, _ = imported(path, "ur5")
    table = read_recording(one.entry).robot.table
    for name, expected in (("actual_q", made[1]["actual_q"]), ("actual_qd", made[1]["actual_qd"])):
        np.testing.assert_allclose(channel(table, name), expected, atol=1e-12)
    np.testing.assert_allclose(channel(table, effort_channel), effort, atol=1e-9)


@pytest.mark.parametrize(
    ("names", "robot", "sure"),
    [
        ("q_{k}", "ur5", "assumed"),
        ("q_{k}", "", "check"),
        ("{motor}.pos", "ur5", "check"),  # servos have shares of each joint's range, too
    ],
)
def test_a_described_arm_s_angles_are_no_shares(
    tmp_path: Path, made: Made, names: str, robot: str, sure: str
) -> None:
    motors = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    q = np.degrees(made[1]["actual_q"])
    q *= 95 / np.abs(q).max()
    columns = {names.format(k=k, motor=motors[k]): q[:, k] for k in range(6)}
    pd.DataFrame({"time": made[0]} | columns).to_csv(tmp_path / "run.csv", index=False)
    _, told = imported(tmp_path / "run.csv", robot)
    first, *_, last = columns
    assert f"{sure}: {first} … {last}: actual_q [deg]" in told


def test_counts_of_encoders_are_no_degrees(tmp_path: Path, made: Made) -> None:
    counts = np.round(made[1]["actual_q"] * 101 * 65536 / 2 / np.pi)
    table = pd.DataFrame({f"position_{k}": counts[:, k] for k in range(6)})
    table.assign(time=made[0]).to_csv(tmp_path / "run.csv", index=False)
    _, told = imported(tmp_path / "run.csv")
    assert "counts of encoders" in told


def test_joints_by_name_are_nothing_beside_positions(tmp_path: Path, made: Made) -> None:
    q = made[1]["actual_q"]
    table = pd.DataFrame({"time": made[0]})
    for k in range(6):
        table[f"actual_q_{k}"], table[f"joint{k}"] = q[:, k], np.sin(made[0] + k)
    table.to_csv(tmp_path / "run.csv", index=False)
    one, _ = imported(tmp_path / "run.csv", "ur5")
    np.testing.assert_allclose(channel(read_recording(one.entry).robot.table, "actual_q"), q)


@pytest.mark.parametrize(
    ("factors", "velocity", "said"),
    [
        ([4e4, 3.8e4, 4.1e4, 2.6e4, 2.5e4, 1.2e4], "", "counts of encoders"),
        ([30, 33, 45, 20, 25, 32], "", "ask for the calibration file"),
        ([30, 33, 45, 20, 25, 32], "qd_{k}", "a factor a joint, so no angles"),
    ],
)
def test_a_factor_a_joint_makes_no_angle(
    tmp_path: Path, made: Made, factors: list[float], velocity: str, said: str
) -> None:
    """Neither counts nor shares of each joint's range, which velocities in rad/s show."""
    columns = {"time": made[0]}
    columns |= {f"q_{k}": factors[k] * made[1]["actual_q"][:, k] for k in range(6)}
    columns |= {velocity.format(k=k): made[1]["actual_qd"][:, k] for k in range(6) if velocity}
    pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
    _, told = imported(tmp_path / "run.csv")
    assert "proven: q_0 … q_5" not in told
    assert said in told


def test_pushes_make_no_milliamperes() -> None:
    """Constants that are known, and the channel's name, come before a likelihood."""
    one, told = imported(case("pushed_at_rest.csv", Path()), "ur5")
    assert "units" not in one.entry
    assert "far better" not in told


def test_a_following_error_is_no_torque(tmp_path: Path) -> None:
    one, told = imported(case("06_effort_is_position_error.csv.gz", tmp_path))
    assert one.arm == "my_arm"
    assert "as a following error, it lags behind all joints by 0.016 s times" in told


@pytest.mark.parametrize(
    ("robot", "channel", "factors"),
    [
        ("", "actual_current_as_torque", "no force is stated until it is named"),
        ("ur5e", "actual_current", "by gravity, one unit is 1.53, 1.5 Nm on joints 2, 3"),
    ],
)
def test_per_cent_of_rated_torques_are_kept_in_an_unknown_unit(
    tmp_path: Path, robot: str, channel: str, factors: str
) -> None:
    """The first row of the account says so, with the option that ends it."""
    one, told = imported(case("07_percent_of_rated.csv.gz", tmp_path), robot)
    assert one.entry["units"] == {channel: "unknown"}
    assert "a share of a rating, or counts, by its name" in told
    assert factors in told
    assert "--unit" in one.account[0].reason
    assert "unknown" in one.account[0].reason


def test_a_range_proves_no_angle(tmp_path: Path) -> None:
    one, told = imported(case("11_normalised_ranges.csv.gz", tmp_path))
    assert one.arm == "my_arm"
    assert "check: shoulder_pan.pos … wrist_roll.pos: actual_q [deg]" in told
    assert "ask for the calibration file" in told


def test_a_pose_proves_bare_names(tmp_path: Path) -> None:
    one, told = imported(case("14_bare_joint_names.csv.gz", tmp_path))
    assert (one.arm, one.entry["units"]) == ("ur5e", {"actual_q": "deg"})
    assert "proven: joint1 … joint6: actual_q [deg]" in told


def test_gears_explain_a_torque_of_motors(tmp_path: Path) -> None:
    one, told = imported(case("16_motor_side_torque.csv.gz", tmp_path), "ur5e")
    assert one.entry["units"] == {"actual_current_as_torque": [101.0] * 6}
    assert "multiplied by the gear ratio, 101: it is then 0.981, 1 times the torque" in told


@pytest.mark.parametrize(("planned", "role"), [(1.0, "fit"), (0.0, "contact")])
def test_a_hand_that_leads_the_arm_plans_no_acceleration(
    tmp_path: Path, made: Made, planned: float, role: str
) -> None:
    time, channels = made
    q, qd = channels["actual_q"], channels["actual_qd"]
    quantities = {"actual_q": q, "actual_qd": qd, "target_q": q, "target_qd": qd}
    quantities["target_qdd"] = planned * np.gradient(qd, time, axis=0)
    columns = {f"{name}_{k}": rows[:, k] for name, rows in quantities.items() for k in range(6)}
    pd.DataFrame({"time": time} | columns).to_csv(tmp_path / "run.csv", index=False)
    one, told = imported(tmp_path / "run.csv", "ur5")
    assert one.entry["role"] == role
    assert ("as of an arm that a hand leads" in told) == (role == "contact")
    assert "target_qdd" in one.entry["columns"]


def test_one_driver_has_one_order(tmp_path: Path) -> None:
    """A file in which too little moves to tell it alone is read like the one beside it."""
    table = pd.read_csv(case("base_fit.csv.gz", tmp_path))
    quantities = {"q": "actual_q", "dq": "actual_qd", "i": "actual_current"}
    renamed = {
        f"{channel}_{joint}": f"{name}{column}"
        for name, channel in quantities.items()
        for column, joint in enumerate((2, 1, 0, 3, 4, 5))
    }
    moving = table.rename(columns=renamed)[["time", *renamed.values()]]
    moving.to_csv(tmp_path / "moving.csv", index=False)
    noise = np.random.default_rng(1).normal(0, 1e-3, (600, 19)) * moving.columns.str.startswith("i")
    resting = moving.iloc[0] + 0.05 * (moving[:600] - moving.iloc[0]) + noise
    resting.assign(time=moving["time"]).to_csv(tmp_path / "resting.csv", index=False)
    paths = [tmp_path / "resting.csv", tmp_path / "moving.csv"]
    for robot in ("", "ur5e"):
        alone, told = imported(paths[0], robot)
        assert "what moves shows no other" in told
        first, second = import_files(paths, UserStatement(robot))
        assert alone.entry["columns"] != first.entry["columns"] == second.entry["columns"]
        assert "as in moving.csv, of the same form: one driver, one order" in in_words(
            first.account
        )


@pytest.mark.parametrize(("robot", "settled"), [("kuka-kr300", True), ("ur5", False)])
def test_numbers_in_names_settle_the_order(
    tmp_path: Path, made: Made, robot: str, settled: bool
) -> None:
    """Whatever is before them; of a UR, they may count the names of joints, elbow first."""
    q, qd = made[1]["actual_q"], made[1]["actual_qd"]
    columns = {f"pos_meas_joint{k + 1}": q[:, k] for k in range(6)}
    columns |= {f"vel_meas_joint{k + 1}": qd[:, k] for k in range(6)}
    pd.DataFrame({"time": made[0]} | columns).to_csv(tmp_path / "run.csv", index=False)
    _, told = imported(tmp_path / "run.csv", robot)
    assert ("as named in pos_meas_joint1 … pos_meas_joint6" in told) == settled


@pytest.mark.parametrize("factor", [1e3, -1.0])
def test_what_a_file_proves_hangs_on_no_other(tmp_path: Path, factor: float) -> None:
    """Neither its unit nor its sign, nor does a stop sign come from a file beside it."""
    table = pd.read_csv(case("base_fit.csv.gz", tmp_path)).drop(
        columns="timestamp", errors="ignore"
    )
    table.to_csv(tmp_path / "amperes.csv", index=False)
    currents = table.columns[table.columns.str.startswith("actual_current_")]
    table[currents] *= factor
    table[: len(table) // 2].to_csv(tmp_path / "other.csv", index=False)
    (alone,) = import_files([tmp_path / "other.csv"], UserStatement("ur5e"))
    _, beside = import_files(
        [tmp_path / "amperes.csv", tmp_path / "other.csv"], UserStatement("ur5e")
    )
    assert (beside.entry, beside.account) == (alone.entry, alone.account)


def test_one_driver_has_one_unit(tmp_path: Path) -> None:
    """Of two parts of a UR3's recording, one alone seems to be in Nm; both are whole milliamperes
    times the constants that the other proves.
    """
    bag = shared_folder("ur3-cb", "they are recordings of a real UR3") / "id2.bag"
    file = contents(bag)
    stamps = file.clocks.stamps["/arm/stamp"]
    parts = {block.names[0].removeprefix("/arm/"): block.rows for block in file.blocks}
    columns = {f"{n}_{k}": rows[:, k] for n, rows in parts.items() for k in range(6)}
    table, paths = pd.DataFrame({"time": stamps} | columns), []
    for k in range(2):
        start = stamps[0] + 8 * k
        paths.append(tmp_path / f"part_{k}.csv")
        table[(stamps >= start) & (stamps < start + 8)].to_csv(paths[k], index=False)
    alone = import_files(paths[:1], UserStatement("ur3"))[0].entry
    first, second = import_files(paths, UserStatement("ur3"))
    assert alone["units"] == {"actual_current_as_torque": "opposite"}
    assert first.entry["units"] == second.entry["units"]
    assert "whole milliamperes by these factors" in in_words(first.account)
    study = tmp_path / "mine.yaml"
    write_study([second], study)
    alone = import_files(paths[:1], UserStatement("ur3"))
    add_to_study(alone, study)
    assert "part_1 of this study has actual_current [[-0.07" in in_words(alone[0].account)


@pytest.mark.parametrize("lacking", [1, 2])
def test_a_joint_that_is_missing_is_counted(tmp_path: Path, made: Made, lacking: int) -> None:
    table = pd.DataFrame({"time": made[0]})
    for k in range(6):
        table[f"q_{k}"] = made[1]["actual_q"][:, k]
    for k in range(6 - lacking):
        table[f"current_{k}"] = made[1]["actual_current"][:, k]
    table.to_csv(tmp_path / "run.csv", index=False)
    _, told = imported(tmp_path / "run.csv", "ur5")
    assert f"the arm has 6: {lacking} missing" in told


def test_the_likeliest_arm_tells_a_wrench_s_frame(tmp_path: Path) -> None:
    """Of an arm that nobody names: to be checked, with the arm."""
    one, told = imported(case("09_wrench_in_base_axes.csv.gz", tmp_path))
    assert one.arm == "my_arm"
    assert "actual_TCP_force" in one.entry["columns"]
    assert "is ur5e or like it; in the base's frame" in told


@pytest.mark.parametrize("turned", [False, True])
def test_a_matrix_of_a_file_is_a_table(tmp_path: Path, made: Made, turned: bool) -> None:
    """Without names and clock: its rate is what velocities say of positions."""
    time, channels = made
    matrix = np.hstack([channels[name] for name in ("actual_q", "actual_qd", "actual_current")])
    scipy.io.savemat(tmp_path / "run.mat", {"data": matrix.T if turned else matrix})
    one, _ = imported(tmp_path / "run.mat", "ur5")
    assert one.entry["rate"] == pytest.approx(1 / np.diff(time).mean(), rel=0.01)
    table = read_recording(one.entry).robot.table
    for name in ("actual_q", "actual_qd"):
        np.testing.assert_allclose(channel(table, name), channels[name], atol=1e-12)


def test_a_public_matrix_is_read() -> None:
    folder = shared_folder("ur10-picknplace", "its PROVENANCE.md names the source")
    one, told = imported(folder / "URpickNplace.mat", "ur10")
    assert one.entry["rate"] == pytest.approx(124.5, abs=1)
    assert "the derivative of urPicknPlace_0 … urPicknPlace_5 on 6 joints" in told
