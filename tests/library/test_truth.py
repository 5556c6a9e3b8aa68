"""Estimates beside the truth: what a row says, and what there is no truth of."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from ur5lib.pipeline.fused_motion import no_fused_motion
from ur5lib.pipeline.records.forces import Forces
from ur5lib.pipeline.records.motion import FusedMotion, Motion
from ur5lib.pipeline.records.truth import Truth
from ur5lib.report.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.report.truth_table import (
    COLUMNS,
    clock_rows,
    errors,
    friction_rows,
    imu_rows,
    joint_acceleration_rows,
    rotor_rows,
    values,
    wrench_rows,
)
from ur5lib.report.views.first_screen import beside_truth
from ur5lib.timeseries.arrays import Array

TRUTH: dict[str, Any] = {
    "clocks": {"imu": {"offset_s": 0.02, "drift_ppm": -3000}},
    "drive": {"torque_constant": [10.0] * 6},
    "friction": {
        "coulomb": [8.0] * 6, "viscous": [9.0] * 6, "load": [0.05] * 6,
        "periodic": [0.4] * 6, "phase": [0.0, np.pi / 2, 0.0, 0.0, 0.0, 0.0],
        "coulomb_warming": [-0.003] * 6, "viscous_warming": [-0.009] * 6,
    },
}  # fmt: skip


COUNT = 100


def test_a_joint_that_did_not_move_has_no_rotor_beside_the_truth() -> None:
    rows = [*values("rotor_inertia", [1, 2], "kg m2", [0.5, 0.6], [0.5, None], [0.1, None])]
    assert [row["index"] for row in rows] == [1]


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
    rows = list(values("x", "abc", "m", [0, 0, 0], [1.9, 2.0, 5.0], [1.0, 1.0, np.nan]))
    assert [row["within95"] for row in rows] == ["yes", "no", None]
    assert [row["std_error"] for row in rows] == [1.0, 1.0, None]


def test_few_recordings_make_wide_intervals() -> None:
    """Three recordings leave two degrees of freedom: 4.3 standard errors instead of 1.96."""
    rotors: dict[str, Any] = {"value": {"inertia": [4.0] * 6}, "std_error": {"inertia": [1.0] * 6}}
    for recordings, told in (("abc", "yes"), ("abcdefghijklmnop", "no"), ("a", "no")):
        rows = list(rotor_rows(rotors | {"from": [*recordings]}, [0.5] * 6))
        assert {row["within95"] for row in rows} == {told}


def test_errors_stand_beside_those_of_zero() -> None:
    truth, found = np.array([[3.0, 0.0], [np.nan, 1.0]]), np.array([[5.0, 1.0], [0.0, 0.0]])
    rows = list(errors("x", "ab", ["m", "m"], truth, found))
    assert [(row["estimate"], row["zero"]) for row in rows] == [(2.0, 3.0), (1.0, 0.0)]
    assert {row["quantity"] for row in rows} == {"x_rmse"}


def test_clocks_without_drift_have_no_row_of_it() -> None:
    clock = {"offset": 0.03, "offset_std": 0.01, "method": "start stamps"}
    rows = list(clock_rows({"imu": clock | {"drift": None, "drift_std": None}}, TRUTH))
    assert [(row["quantity"], row["within95"]) for row in rows] == [("clock_offset", "yes")]
    drifting = clock | {"drift": -0.0029, "drift_std": 2e-5}
    drift = list(clock_rows({"imu": drifting}, TRUTH))[1]
    assert drift["estimate"] == pytest.approx(-2900)
    assert drift["within95"] == "no"


def test_friction_that_the_stand_lacks_has_no_truth() -> None:
    row = {"value": 8.1, "std_error": 0.1, "interval": (7.9, 8.3), "joint": 2}
    names = ["coulomb", "stribeck_0.1", "periodic_1_sin", "torque_constant"]
    friction = {"parameters": [row | {"name": name} for name in names]}
    found = {r["quantity"]: r["truth"] for r in friction_rows(friction, TRUTH)}
    assert found == {"coulomb": 8.0, "periodic_1_sin": -0.4, "torque_constant": 10.0}


@pytest.mark.parametrize(("half", "told"), [(0.5, "yes"), (0.3, "no")])
def test_friction_is_held_against_the_interval_that_is_stated(half: float, told: str) -> None:
    row = {"name": "coulomb", "joint": 1, "value": 8.4, "std_error": 0.19}
    friction = {"parameters": [row | {"interval": (8.4 - half, 8.4 + half)}]}
    assert [r["within95"] for r in friction_rows(friction, TRUTH)] == [told]


def test_an_imu_s_mounting_is_told_in_radians() -> None:
    calibration = {
        name: np.zeros(count)
        for part, count in (("mounting", 3), ("tilt", 2), ("gyroscope_bias", 3), ("place", 3))
        for name in (part, f"{part}_std")
    }
    imu = {"mounting_deg": [180, 0, 0], "gyroscope_bias": [1, 2, 3]}
    rows = list(imu_rows(calibration | {"described": np.array([4, 5, 6])}, imu))
    truth = [np.pi, 0, 0, 0, 0, 1, 2, 3, 4, 5, 6]
    assert [row["truth"] for row in rows] == pytest.approx(truth)


def test_accelerations_are_held_against_their_bands() -> None:
    rows = pd.DataFrame(joint_acceleration_rows(motions(), made_truth()))
    rmse = rows[rows["quantity"] == "joint_acceleration_rmse"]
    assert rmse["estimate"].tolist() == rmse["zero"].tolist() == [0.5] * 6
    inside = rows[rows["quantity"] == "joint_acceleration_inside_2_std"]
    assert inside["estimate"].tolist() == [1.0] * 6
    assert set(rows["method"]) == {"encoders"}


def test_wrenches_are_compared_where_they_state_a_band() -> None:
    grid = {"time": 0.008 * np.arange(COUNT), "segment": np.zeros(COUNT, np.int64)}
    truth = made_truth()
    forces = Forces(**grid, wrench={"Fmap": series(8.0)})
    assert list(wrench_rows(forces, truth)) == []
    band = replace(forces, std={"Fmap": series(1.5)})
    rows = pd.DataFrame(wrench_rows(band, truth)).set_index(["quantity", "index"])
    assert rows.loc[("wrench_rmse", "Fz"), "estimate"] == pytest.approx(2.0)
    assert rows.loc[("wrench_mae", "nz"), "zero"] == pytest.approx(10.0)
    assert rows.loc[("wrench_coverage95", "Fx"), "estimate"] == 1.0


@pytest.mark.parametrize(
    ("held", "chance", "verdict"),
    [(95, "0.8", "wide"), (93, None, ""), (87, None, ""), (80, "< 0.1", "narrow")],
)
def test_intervals_that_hold_the_truth_too_often_are_called_too_wide(
    held: int, chance: str | None, verdict: str
) -> None:
    """0.95 to the power of 95 is 0.77 %."""
    _, told = beside_truth(pd.DataFrame({"within95": ["yes"] * held + ["no"] * (95 - held)}))
    assert " 90 of these" in told
    assert re.findall(r"found is (.*) %, .* too (\w+)\.", told) == (
        [(chance, verdict)] if chance else []
    )


def test_the_section_counts_and_shows_what_is_in_the_table() -> None:
    clock = {"offset": 0.03, "offset_std": 0.01, "drift": -0.0029, "drift_std": 2e-5}
    rows = [{"recording": "a"} | r for r in clock_rows({"imu": clock | {"method": "m"}}, TRUTH)]
    rows += [{"recording": "a"} | r for r in joint_acceleration_rows(motions(), made_truth())]
    table = pd.DataFrame(rows, columns=COLUMNS)
    told = " ".join(beside_truth(table))
    assert re.findall(r"\d+", told.replace("95 % interval", "")) == ["2", "1", "2"]
    results = Results({"recordings": []}, {"truth": table}, Path())
    shown = ["summary", "clocks", "joint_accelerations", "joint_acceleration_bands", "torques"]
    lines = [len(shown_table(f"truth.{table}", results).rows) for table in shown]
    assert lines == [2, 2, 2, 1, 0]
