"""The thesis's force estimates, and the sensor, against a wrench that is known."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.made_records import motion_of, signals_of, stretch, torques_of
from tests.scripts.conftest import script
from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import remark
from ur5lib.recordings.quality import Contradictions, Quality, StartOffset
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.signals import SENSOR_COLUMNS
from ur5lib.records.table import Table
from ur5lib.robots.description import Robot, robot_path
from ur5lib.signals.clock import BY_STAMPS, SettledClock
from ur5lib.tables import read_json, write_json, write_table
from ur5lib.thesis.current_based import friction_torque

PERIOD, COUNT = 0.008, 2500
TIME = np.arange(COUNT) * PERIOD
START = 0.5  # s, by which the sensor starts later by its stamps
BIAS = np.array([-5.0, 2.0, -1.0, 0.1, 0.4, -0.1])
FORCE = np.array([10.0, -5.0, 8.0])
SETTINGS = SimpleNamespace(
    order=5,
    cutoff_hz=1.454,
    bias_window_s=1.0,
    min_singular_value=0.01,
    gravity=None,
    mounting=(None, None),
)


def truth() -> tuple[np.ndarray, ...]:
    """A slow, singularity-free motion; between 3 and 9 s, a force pushes at the
    origin of frame 6."""
    angle = 0.4 * TIME[:, None] + np.arange(6)
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    q, qd, qdd = home + 0.2 * np.sin(angle), 0.08 * np.cos(angle), -0.032 * np.sin(angle)
    pushed = (TIME > 3.0) & (TIME < 9.0)
    wrench = np.where(pushed[:, None], np.append(FORCE, [0, 0, 0]), 0.0)
    return q, qd, qdd, wrench


@dataclass(frozen=True)
class Results:
    """What the steps make of it; withheld: where the fit contradicts the arm."""

    published: PublishedForces
    withheld: PublishedForces
    sensor: SensorWrenches
    summary: dict[str, Any]


@pytest.fixture(scope="module")
def results(ur5: Robot, tmp_path_factory: pytest.TempPathFactory) -> Results:
    q, qd, qdd, wrench = truth()
    torque = LinkModel(ur5, "C").inverse_dynamics(q, qd, qdd)
    rotation, origin, J = flange_kinematics(ur5, q)

    constants = ur5.current_to_torque
    total = torque + friction_torque(qd, ur5.friction) - np.einsum("nij,ni->nj", J, wrench)
    current = (total - constants.offset) / constants.torque_constant
    # The sensor sits 28.6 mm out and reads the hand on the arm.
    lever = rotation @ np.array(ur5.mounting.force_sensor)
    moment = wrench[:, 3:] - np.cross(lever, wrench[:, :3])
    reading = np.concatenate(
        [np.einsum("nji,nj->ni", rotation, half) for half in (wrench[:, :3], moment)], axis=1
    )
    records: dict[str, Table] = {
        "signals": signals_of(
            TIME,
            q,
            actual_current=current,
            target_qd=qd,
            actual_TCP_force=-wrench + 1.0,
            force_sensor=reading + BIAS,
        ),
        "motion": motion_of(TIME, q, qd, qdd),
        "torques": torques_of(TIME, {"C": torque}, {"C": torque}),
        "kinematics": Kinematics.of(TIME, rotation, origin, J),
        "forces": Forces(**stretch(TIME)),
    }
    folder = tmp_path_factory.mktemp("force")
    for name, record in records.items():
        record.write(folder / f"{name}.parquet")
    sensor = dict(zip(SENSOR_COLUMNS["force"], (reading + BIAS).T, strict=True))
    write_table(pd.DataFrame({"time": TIME - START} | sensor), folder / "force.parquet")
    names = (*records, "force", "published")
    inputs = {name: str(folder / f"{name}.parquet") for name in names}
    write_json(Quality(starts={"force": StartOffset(START, 0.001)}), folder / "quality.json")
    clock = SettledClock(START, 0.001, None, None, BY_STAMPS, warning=None, end_std=0.001)
    write_json({"force": clock}, folder / "clocks.json")
    write_json(Contradictions(), folder / "contradictions.json")
    write_json(Friction(), folder / "friction.json")
    inputs |= {"arm": str(robot_path("ur5")), "contradictions": str(folder / "contradictions.json")}
    inputs |= {name: str(folder / f"{name}.json") for name in ("quality", "clocks", "friction")}
    given = SimpleNamespace(**inputs)
    published = SimpleNamespace(forces=folder / "published.parquet", constants=folder / "c.json")
    script("rebuild_forces").rebuild_forces(given, published, SETTINGS)
    withheld = SimpleNamespace(forces=folder / "withheld.parquet", constants=folder / "c.json")
    stopped = Friction(stopped=remark("contradicting constants"))
    write_json(stopped, folder / "friction.json")
    script("rebuild_forces").rebuild_forces(given, withheld, SETTINGS)
    compared = SimpleNamespace(sensor=folder / "sensor.parquet", summary=folder / "forces.json")
    script("compare_forces").compare_forces(given, compared, SETTINGS)
    return Results(
        PublishedForces.read(published.forces),
        PublishedForces.read(withheld.forces),
        SensorWrenches.read(compared.sensor),
        read_json(compared.summary),
    )


def test_the_corrected_estimate_finds_the_force(results: Results) -> None:
    """Away from the push's edge, which the filter rounds."""
    settled = (TIME > 5) & (TIME < 7)
    estimate = results.published.corrected["F*"][settled]
    np.testing.assert_allclose(estimate, truth()[3][settled], atol=0.1)


def test_no_force_is_stated_where_the_fit_contradicts_the_arm(results: Results) -> None:
    assert results.withheld.corrected == results.withheld.printed == {}


def test_without_friction_the_estimate_is_off(results: Results) -> None:
    assert results.summary["errors"]["corrected"]["F"]["all"]["mae"]["Fx"] > 5


def test_the_sensor_is_put_right(results: Results) -> None:
    offset = results.summary["offset"]
    np.testing.assert_allclose(offset["start_bias"], BIAS, atol=1e-6)
    np.testing.assert_allclose(offset["bias"], BIAS, atol=1e-3)
    away = np.abs(np.abs(TIME - 6) - 3) > 0.3  # from the push's edges, at which resampling rings
    corrected = results.sensor.wrench["corrected"]
    np.testing.assert_allclose(corrected[away], truth()[3][away], atol=1e-2)
    np.testing.assert_allclose(results.sensor.wrench["compensated"], truth()[3], atol=1e-2)
    assert results.summary["mounting_doubt"] is None


def test_the_printed_kind_keeps_the_bias_and_the_delay(results: Results) -> None:
    published = results.published
    assert results.summary["errors"]["printed"]["Fu"]["all"]["zero_mae"]["Fx"] > 1
    rising = np.argmax(published.corrected["F*"][:, 2] > 4) * PERIOD
    late = np.argmax(published.printed["F*"][125:, 2] > 4) * PERIOD + 1
    assert late - rising == pytest.approx(0.35, abs=0.1)


def test_an_estimate_of_zero_stands_beside(results: Results) -> None:
    expected = np.abs(truth()[3]).mean(0)[:3]
    figures = results.summary["errors"]["corrected"]["F*"]["all"]["zero_mae"]
    np.testing.assert_allclose([figures[c] for c in ("Fx", "Fy", "Fz")], expected, rtol=2e-3)
    assert results.summary["errors"]["corrected"]["Fu"]["all"]["mae"]["Fx"] == pytest.approx(1.0)
