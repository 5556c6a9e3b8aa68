"""Estimates beside the truth: what a row says, and what there is no truth of."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import PROJECT
from tests.house.test_benchmarks import run_benchmark
from tests.topics.pages import section, shown
from ur5lib.records.clocks import SettledClock
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction, Parameter
from ur5lib.records.models import Rotors, Terms
from ur5lib.records.motion import FusedMotion, Motion
from ur5lib.report.results import Results
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.smoothing.fused_motion import no_fused_motion
from ur5lib.stand.plan import Imu
from ur5lib.stand.truth import TrueParameters, Truth
from ur5lib.tables import as_record
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.truth.beside import (
    COLUMNS,
    Row,
    clock_rows,
    errors,
    friction_rows,
    imu_rows,
    rotor_rows,
    values,
    wrench_rows,
)
from ur5lib.topics.truth.compare_with_truth import joint_acceleration_rows

TRUTH = as_record(
    TrueParameters,
    {
        "robot": "ur5", "gravity": (0.0, 0.0, -9.81), "model": "C",
        "plan": {"seed": 0, "payload": None, "undeclared_payload": None, "imu": None},
        "clocks": {"imu": {"offset_s": 0.02, "drift_ppm": -3000}},
        "drive": {"torque_constant": [10.0] * 6},
        "friction": {
            "coulomb": [8.0] * 6, "viscous": [9.0] * 6, "load": [0.05] * 6,
            "periodic": [0.4] * 6, "phase": [0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0],
            "coulomb_warming": [-0.003] * 6, "viscous_warming": [-0.009] * 6,
        },
    },
)  # fmt: skip
CLOCK = SettledClock(0.03, 0.01, -0.0029, 2e-5, "motion", warning=None, end_std=0.01)


COUNT = 100


def series(value: float) -> Array:
    return np.full((COUNT, 6), value)


def made_motion() -> Motion:
    """Accelerations of 1 rad/s², with a deviation of 0.4 rad/s²."""
    names = ("q", "qd", "q_std", "qd_std", "motor_qd")
    states = dict.fromkeys(names, series(0.0)) | {"qdd": series(1.0), "qdd_std": series(0.4)}
    return Motion(time=0.008 * np.arange(COUNT), segment=np.zeros(COUNT, np.int64), **states)


def made_truth() -> Truth:
    """Accelerations of 0.5 rad/s², and a wrench of 10 N and Nm."""
    names = ("q", "qd", "motor_torque", "friction_torque", "contact_torque")
    told = {"qdd": series(0.5), "wrench": series(10.0)} | dict.fromkeys(names, series(0.0))
    return Truth(time=0.008 * np.arange(COUNT), **told)


def motions() -> dict[str, Motion]:
    fused: FusedMotion = no_fused_motion()  # of a recording without a valid IMU
    return {"encoders": made_motion(), "encoders+imu": fused}


def test_an_interval_holds_the_truth_or_not() -> None:
    """Without an estimate, as of a joint that did not move, there is no row."""
    rows = values("x", "abcd", "m", [0] * 4, [1.9, 2.0, 5.0, np.nan], [1.0, 1.0, np.nan, np.nan])
    assert [row["index"] for row in rows] == ["a", "b", "c"]
    assert [row["within95"] for row in rows[:2]] == ["yes", "no"]
    assert [row["std_error"] for row in rows[:2]] == [1.0, 1.0]
    assert pd.isna([rows[2]["within95"], rows[2]["std_error"]]).all()


def test_few_recordings_make_wide_intervals() -> None:
    """Three recordings leave two degrees of freedom: 4.3 standard errors instead of 1.96."""
    terms = [Terms(np.full(6, size), *np.zeros((3, 6))) for size in (4.0, 1.0)]
    for recordings, inside in (("abc", "yes"), ("abcdefghijklmnop", "no"), ("a", "no")):
        rows = list(rotor_rows(Rotors([*recordings], *terms), [0.5] * 6))
        assert {row["within95"] for row in rows} == {inside}


def test_errors_stand_beside_those_of_zero() -> None:
    truth, found = np.array([[3.0, 0.0], [np.nan, 1.0]]), np.array([[5.0, 1.0], [0.0, 0.0]])
    rows = errors("x", "ab", "m", truth, found, "fast")
    assert [(row["estimate"], row["zero"]) for row in rows] == [(2.0, 3.0), (1.0, 0.0)]
    assert {row["quantity"] for row in rows} == {"x_rmse"}


def test_clocks_without_drift_have_no_row_of_it() -> None:
    rows = list(clock_rows({"imu": replace(CLOCK, drift=None, drift_std=None)}, TRUTH))
    assert [(row["quantity"], row["within95"]) for row in rows] == [("clock_offset", "yes")]
    drift = list(clock_rows({"imu": CLOCK}, TRUTH))[1]
    assert drift["estimate"] == pytest.approx(-2900)
    assert drift["within95"] == "no"


def friction_beside_truth(*names: str, joint: int, value: float, half: float) -> list[Row]:
    """The rows of fitted values with intervals of this half width."""
    interval = value - half, value + half
    fitted = [
        Parameter(joint, name, value, 0.19, interval, 0.0, 1.0, 0.0, 0.0, True) for name in names
    ]
    return list(friction_rows(Friction(parameters=fitted), TRUTH.drive, TRUTH.friction))


def test_friction_that_the_stand_lacks_has_no_truth() -> None:
    names = "coulomb", "root", "torque_constant"
    rows = friction_beside_truth(*names, joint=2, value=8.1, half=0.2)
    found = {row["quantity"]: row["truth"] for row in rows}
    assert found == {"coulomb": 8.0, "torque_constant": 10.0}


@pytest.mark.parametrize(("half", "inside"), [(0.5, "yes"), (0.3, "no")])
def test_friction_is_held_against_the_interval_that_is_stated(half: float, inside: str) -> None:
    (row,) = friction_beside_truth("coulomb", joint=1, value=8.4, half=half)
    assert row["within95"] == inside


def test_an_imu_s_mounting_is_in_radians() -> None:
    counts = {"mounting": 3, "tilt": 2, "gyroscope_bias": 3, "place": 3}
    zeros = {f"{part}{end}": np.zeros(n) for part, n in counts.items() for end in ("", "_std")}
    calibration = ImuCalibration(**zeros, described=np.array([4.0, 5, 6]), held_out=1.0)
    imu = Imu(mounting_deg=(180, 0, 0), gyroscope_bias=(1, 2, 3))
    truth = [np.pi, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6]
    assert [row["truth"] for row in imu_rows(calibration, imu)] == pytest.approx(truth)


def test_accelerations_are_held_against_their_bands() -> None:
    rows = pd.DataFrame(joint_acceleration_rows(motions(), made_truth()))
    rmse = rows[rows["quantity"] == "joint_acceleration_rmse"]
    assert rmse["estimate"].tolist() == rmse["zero"].tolist() == [0.5] * 6
    inside = rows[rows["quantity"] == "joint_acceleration_inside_2_std"]
    assert inside["estimate"].tolist() == [1.0] * 6
    assert set(rows["method"]) == {"encoders"}


def test_wrenches_are_compared_and_the_band_where_they_state_one() -> None:
    grid = {"time": 0.008 * np.arange(COUNT), "segment": np.zeros(COUNT, np.int64)}
    truth = made_truth()
    forces = Forces(**grid, wrench={"Fmap": series(8.0)})
    rows = pd.DataFrame(wrench_rows(forces, truth))
    assert {*rows["quantity"]} == {"wrench_rmse", "wrench_mae"}
    band = replace(forces, std={"Fmap": series(1.5)})
    rows = pd.DataFrame(wrench_rows(band, truth)).set_index(["quantity", "index"])
    assert rows.loc[("wrench_rmse", "Fz"), "estimate"] == pytest.approx(2.0)
    assert rows.loc[("wrench_mae", "nz"), "zero"] == pytest.approx(10.0)
    assert rows.loc[("wrench_coverage95", "Fx"), "estimate"] == 1.0


def compared(rows: list[Row]) -> Results:
    table = pd.DataFrame(rows, columns=COLUMNS)
    return Results({}, {"truth": table}, Path())


@pytest.mark.parametrize(
    ("held", "chance", "verdict"),
    [(95, "0.8 %", "wide"), (93, "", ""), (87, "", ""), (80, "< 0.1 %", "narrow")],
)
def test_intervals_that_hold_the_truth_too_often_are_called_too_wide(
    held: int, chance: str, verdict: str
) -> None:
    """0.95 to the power of 95 is 0.77 %."""
    inside = ["yes"] * held + ["no"] * (95 - held)
    told = section("truth", compared([{"quantity": "offset", "within95": one} for one in inside]))
    assert f"{held} of 95 stated 95 % intervals" in told.text
    assert "right ones contain 90" in told.text
    assert re.findall(r"is ([^:]*): the intervals are too (\w+)\.", told.text) == (
        [(chance, verdict)] if chance else []
    )


def test_the_section_counts_and_shows_what_is_in_the_table() -> None:
    rows = [{"recording": "seen"} | r for r in clock_rows({"imu": CLOCK}, TRUTH)]
    rows += [{"recording": "seen"} | r for r in joint_acceleration_rows(motions(), made_truth())]
    results = compared(rows)
    told = section("truth", results)
    assert "1 of 2 stated 95 % intervals contain the truth" in told.text
    assert told.tables["truth-counts"] == [
        {"quantity": "clock offset", "values": "1", "inside": "1"},
        {"quantity": "clock drift", "values": "1", "inside": "0"},
    ]
    offset, drift = section("truth", results, "details").tables["truth-values"]
    assert (offset["truth"], offset["estimate"], offset["inside"]) == ("0.02", "0.03", "yes")
    assert (drift["truth"], drift["estimate"], drift["inside"]) == ("−3000", "−2900", "no")
    assert {offset["recording"], drift["recording"]} == {"R2 seen"}


@pytest.mark.parametrize("page", ["report", "details"])
def test_its_section_is_absent_without_truth(page: str) -> None:
    assert shown("truth", compared([]), page) is None
    assert shown("truth", Results({}, {}, Path()), page) is None


@pytest.mark.thorough
@pytest.mark.slow
def test_what_comes_back_from_the_stand_is_counted() -> None:
    printed = run_benchmark("stand_seeds", PROJECT)
    texts = ["1 seeds", "intervals hold the truth", "wrench_rmse_in_contact"]
    assert all(text in printed for text in texts), printed
