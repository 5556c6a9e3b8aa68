"""The thesis's force estimates, and the sensor, against a wrench that is known."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
import torch

from tests.scripts.conftest import script
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import jacobian, link_frames
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.force.current_based import friction_torque
from ur5lib.robots.description import Robot, robot_path
from ur5lib.tables import WRENCH, named, read_json, read_table, write_json, write_table

PERIOD, COUNT = 0.008, 2500
TIME = np.arange(COUNT) * PERIOD
START = 0.5  # s, by which the sensor starts later by its stamps
BIAS = np.array([-5.0, 2.0, -1.0, 0.1, 0.4, -0.1])
FORCE = np.array([10.0, -5.0, 8.0])
SENSOR = [f"{kind}_{c}" for kind in ("printed", "corrected", "compensated") for c in WRENCH]
SETTINGS = SimpleNamespace(
    order=5, cutoff_hz=1.454, bias_window_s=1.0, min_singular_value=0.01, gravity=None
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


@pytest.fixture(scope="module")
def results(ur5: Robot, tmp_path_factory: pytest.TempPathFactory) -> tuple[pd.DataFrame, dict]:
    q, qd, qdd, wrench = truth()
    arm = build_arm(ur5, "C")
    tensors = [torch.tensor(x) for x in (q, qd, qdd)]
    torque = inverse_dynamics(arm, *tensors).numpy()
    J = jacobian(arm, tensors[0]).numpy()
    rotation = link_frames(arm, tensors[0])[0][:, 6].numpy()

    constants = ur5.current_to_torque
    total = torque + friction_torque(qd, ur5.friction) - np.einsum("nij,ni->nj", J, wrench)
    current = (total - constants.offset) / constants.torque_constant
    # The sensor sits 28.6 mm out and reads the hand on the arm.
    lever = rotation @ np.array(ur5.mounting.force_sensor)
    moment = wrench[:, 3:] - np.cross(lever, wrench[:, :3])
    reading = np.concatenate(
        [np.einsum("nji,nj->ni", rotation, half) for half in (wrench[:, :3], moment)], axis=1
    )
    signals = {
        "time": TIME,
        "segment": np.zeros(COUNT, dtype=int),
        **named(current, "actual_current"),
        **named(qd, "target_qd"),
        **named(-wrench + 1.0, "actual_TCP_force"),
    }
    sensor = dict(zip([f"ft_{a}{b}" for a in "ft" for b in "xyz"], (reading + BIAS).T, strict=True))
    tables = {
        "signals": signals | sensor,
        "force": {"time": TIME - START} | sensor,
        "motion": {"time": TIME, **named(qd, "qd")},
        "torques": {
            "time": TIME,
            **named(torque, "tau_target_C"),
            **named(torque, "tau_measured_C"),
        },
        "kinematics": {
            "time": TIME,
            **named(rotation, "R6"),
            **named(J, "J"),
            "sigma_min": np.linalg.svd(J, compute_uv=False)[:, -1],
        },
    }
    folder = tmp_path_factory.mktemp("force")
    for name, table in tables.items():
        write_table(pd.DataFrame(table), folder / f"{name}.parquet")
    write_table(pd.DataFrame({"time": TIME}), folder / "forces.parquet")
    inputs = {name: str(folder / f"{name}.parquet") for name in (*tables, "published", "forces")}
    write_json({"starts": {"force": {"seconds": START, "std": 0.001}}}, folder / "quality.json")
    inputs |= {"arm": str(robot_path("ur5")), "quality": str(folder / "quality.json")}
    given = SimpleNamespace(**inputs)
    published = SimpleNamespace(forces=folder / "published.parquet")
    script("rebuild_forces").rebuild_forces(given, published, SETTINGS)
    compared = SimpleNamespace(sensor=folder / "sensor.parquet", summary=folder / "forces.json")
    script("compare_forces").compare_forces(given, compared, SETTINGS)
    both = read_table(published.forces).join(read_table(compared.sensor)[SENSOR])
    return both, read_json(compared.summary)


def wrench_of(forces: pd.DataFrame, name: str) -> np.ndarray:
    return forces[[f"{name}_{c}" for c in WRENCH]].to_numpy()


def test_the_corrected_estimate_finds_the_force(results: tuple) -> None:
    """Away from the push's edge, which the filter rounds."""
    settled = (TIME > 5) & (TIME < 7)
    estimate = wrench_of(results[0], "corrected_F*")[settled]
    np.testing.assert_allclose(estimate, truth()[3][settled], atol=0.1)


def test_without_friction_the_estimate_is_off(results: tuple) -> None:
    assert results[1]["errors"]["corrected"]["F"]["all"]["mae"]["Fx"] > 5


def test_the_sensor_is_put_right(results: tuple) -> None:
    offset = results[1]["offset"]
    np.testing.assert_allclose(offset["start_bias"], BIAS, atol=1e-6)
    np.testing.assert_allclose(offset["bias"], BIAS, atol=1e-3)
    away = np.abs(np.abs(TIME - 6) - 3) > 0.3  # from the push's edges, at which resampling rings
    corrected = wrench_of(results[0], "corrected")
    np.testing.assert_allclose(corrected[away], truth()[3][away], atol=1e-2)
    np.testing.assert_allclose(wrench_of(results[0], "compensated"), truth()[3], atol=1e-2)
    assert results[1]["mounting_doubt"] is None


def test_the_printed_kind_keeps_the_bias_and_the_delay(results: tuple) -> None:
    forces, summary = results
    assert summary["errors"]["printed"]["Fu"]["all"]["zero_mae"]["Fx"] > 1
    rising = np.argmax(wrench_of(forces, "corrected_F*")[:, 2] > 4) * PERIOD
    late = np.argmax(wrench_of(forces, "printed_F*")[125:, 2] > 4) * PERIOD + 1
    assert late - rising == pytest.approx(0.35, abs=0.1)


def test_an_estimate_of_zero_stands_beside(results: tuple) -> None:
    expected = np.abs(truth()[3]).mean(0)[:3]
    figures = results[1]["errors"]["corrected"]["F*"]["all"]["zero_mae"]
    np.testing.assert_allclose([figures[c] for c in ("Fx", "Fy", "Fz")], expected, rtol=2e-3)
    assert results[1]["errors"]["corrected"]["Fu"]["all"]["mae"]["Fx"] == pytest.approx(1.0)
