"""The torque and current of a motion without measured efforts: of states, motions, recordings."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import ur5lib
from benchmarks.motion_alone import judged, line, mean_nrmse, unloaded
from tests.conftest import PROJECT, shared_folder
from tests.house.test_benchmarks import run_benchmark
from ur5lib.timeseries.metrics import NORMAL95

JOINTS = range(6)
DRAW = np.random.default_rng(5)
STATES = DRAW.uniform(-1.5, 1.5, (3, 40, 6))


def rows(frame: pd.DataFrame, name: str) -> np.ndarray:
    return frame[[f"{name}_{k}" for k in JOINTS]].to_numpy()


def without_efforts(run: ur5lib.Recordings) -> pd.DataFrame:
    table = run.device("robot")
    return table.loc[:, ~table.columns.str.contains("current|moment|force|TCP", regex=True)]


def test_currents_are_those_predicted_whether_or_not_they_were_measured(
    model: ur5lib.Model, free: ur5lib.Recordings, pushed: ur5lib.Recordings
) -> None:
    """By the fit without the path of a recording of the fit, with the band where that is known."""
    for run in (free["free1"], pushed):
        current, std = model.current(run, return_std=True)
        predicted = model.predict(run)
        np.testing.assert_array_equal(current, rows(predicted, "predicted_current"))
        half = rows(predicted, "current_band")
        known = np.isfinite(half)
        np.testing.assert_allclose(NORMAL95 * std[known], half[known], rtol=0.02)
        assert np.isfinite(std).all()
    silent = ur5lib.read({"pushed": without_efforts(pushed)}, "ur5e", "contact")
    with pytest.raises(ur5lib.InputError, match="no actual_current was recorded"):
        _ = silent.current
    np.testing.assert_allclose(model.current(silent), current, atol=1e-9)
    both = model.torque(free)
    assert len(both) == len(free.q)
    np.testing.assert_array_equal(both[: len(free["free1"].q)], model.torque(free["free1"]))


def test_after_one_path_a_rest_is_predicted_alike(
    free: ur5lib.Recordings, pushed: ur5lib.Recordings
) -> None:
    model = ur5lib.fit(free["free1"])
    assert model._friction.usual is not None
    for run in (free["free1"], pushed):
        found = rows(model.predict(run), "predicted_current")
        np.testing.assert_array_equal(model.current(run), found)
    q, still = STATES[0, 0], np.zeros(6)
    alone = model.single().torque(q, still, still)
    np.testing.assert_allclose(alone, model.torque(q, 0, 0), atol=1e-10)


def test_the_benchmark_scores_as_the_model_does(
    model: ur5lib.Model, free: ur5lib.Recordings
) -> None:
    own = judged(model, free["free2"])
    score = model.score(free["free2"]).query("model == 'fitted'")
    assert mean_nrmse(own.slow_measured, own.slow_found) == pytest.approx(score["nrmse"].mean())
    cells = line("study", free["free2"], own)
    assert cells[:2] == ["study", "1"]
    assert float(cells[4]) == 0
    assert float(cells[5]) == pytest.approx(score["coverage95"].mean(), abs=0.005)
    assert unloaded(model, free).names == free.names


@pytest.mark.thorough
@pytest.mark.slow
def test_the_benchmark_prints_its_table(tmp_path: Path) -> None:
    (tmp_path / "raw").mkdir()
    folder = shared_folder("kuka-kr300/benchmark-10hz", "docs/benchmark.md names their source")
    (tmp_path / "raw" / "kuka-kr300").symlink_to(folder)
    (tmp_path / "workflow").symlink_to(PROJECT / "workflow")
    assert "| kuka-kr300 | 1 | 0." in run_benchmark("motion_alone", tmp_path, "kuka-kr300")


def test_a_torque_is_that_of_its_current(model: ur5lib.Model) -> None:
    (torque, wide), (current, std) = (
        ask(*STATES, return_std=True) for ask in (model.torque, model.current)
    )
    constant = model.table("torque_constants")["torque_constant"].to_numpy()
    np.testing.assert_allclose(wide, np.abs(constant) * std)
    np.testing.assert_allclose(np.diff(torque, axis=0), constant * np.diff(current, axis=0))


def test_rows_are_states_in_any_order(model: ur5lib.Model) -> None:
    torque = model.torque(*STATES)
    order = DRAW.permutation(len(torque))
    np.testing.assert_allclose(model.torque(*STATES[:, order]), torque[order], atol=1e-12)
    np.testing.assert_allclose(model.torque(*STATES[:, 3]), torque[3], atol=1e-12)
    frames = [pd.DataFrame(one) for one in STATES]
    np.testing.assert_array_equal(model.torque(*frames), torque)


def steady(period: float) -> tuple[np.ndarray, np.ndarray]:
    """Two seconds of motion at a speed of each joint."""
    speed = np.array([0.3, -0.2, 0.25, -0.4, 0.3, 0.5])
    time = np.arange(0, 2, period)
    return np.array([0.1, -1.4, 1.2, 0.2, 0.3, 0.0]) + time[:, None] * speed, 0 * time[
        :, None
    ] + speed


def test_a_motion_is_of_states_once_its_joints_have_turned(model: ur5lib.Model) -> None:
    """Before, nobody knows the side of friction, unless the motion before tells it."""
    q, qd = steady(0.008)
    alone, timed = model.torque(q, qd, 0), model.torque(q, qd, 0, period=0.008)
    np.testing.assert_allclose(timed[100:], alone[100:], atol=1e-9)
    frame = pd.DataFrame(q, pd.Index(0.008 * np.arange(len(q)), name="time"))
    np.testing.assert_array_equal(model.torque(frame, qd, 0), timed)
    assert np.abs(timed[0] - alone[0]).min() > 0.1
    after = model.torque(q[100:], qd[100:], 0, period=0.008, after=q[:101])
    np.testing.assert_allclose(after, timed[100:], atol=1e-9)
    with pytest.raises(ur5lib.InputError, match="after: that motion ends"):
        model.torque(q, qd, 0, period=0.008, after=q)
    with pytest.raises(ur5lib.InputError, match="after: states in any order"):
        model.torque(q, qd, 0, after=q)


def test_a_start_at_rest_has_the_band_of_an_unknown_side(model: ur5lib.Model) -> None:
    """After a motion that is known, that of standing joints; in motion, that of moving ones."""
    posture = np.tile([0.1, -1.4, 1.2, 0.2, 0.3, 0.0], (200, 1))
    came = posture[:1] - np.linspace(0.3, 0, 100)[:, None]
    fit = model._friction.fit.joints
    expected = [[one.band_unknown for one in fit], [one.band_standing for one in fit]]
    for band, after in zip(expected, (None, came), strict=True):
        _, std = model.current(posture, 0, 0, period=0.008, after=after, return_std=True)
        assert (NORMAL95 * std[100] >= 0.999 * np.array(band)).all()
        np.testing.assert_allclose(NORMAL95 * std[100], band, rtol=0.3)
    _, single = model.current(posture[0], 0, 0, return_std=True)
    np.testing.assert_allclose(NORMAL95 * single, expected[0], rtol=0.3)
    _, moving = model.current(posture[0], 0.3, 0, return_std=True)
    assert (NORMAL95 * moving >= 0.999 * np.array([one.band_moving for one in fit])).all()


def test_a_payload_weighs_in_proportion_to_its_mass(model: ur5lib.Model) -> None:
    q = STATES[0]
    free, one, two = (model.torque(q, 0, 0, payload=p) for p in (None, 1.5, (3.0, (0, 0, 0))))
    np.testing.assert_allclose(two - free, 2 * (one - free), atol=1e-9)
    np.testing.assert_array_equal(model.torque(q, 0, 0, payload=(0, (0.1, 0, 0.2))), free)
    aside = model.torque(q, 0, 0, payload=(1.5, (0.1, 0, 0.2)))
    assert np.abs(aside - one)[:, 1:].max() > 1


def test_friction_by_joint_is_that_of_each_alone(model: ur5lib.Model) -> None:
    velocity, load = STATES[1], np.abs(20 * STATES[2])
    found = model.friction(velocity, load)
    assert [*found][::6] == ["tau_friction_0", "tau_friction_std_0"]
    for row, joint in ((0, 0), (7, 3), (12, 5)):
        alone = model.friction(velocity[row, joint], load[row])
        for name in (f"tau_friction_{joint}", f"tau_friction_std_{joint}"):
            assert alone[name].iloc[0] == pytest.approx(found[name].iloc[row], rel=1e-9)
    np.testing.assert_allclose(model.friction(velocity), model.friction(velocity, 0.0))


WRONG = [
    (
        lambda model: model.torque(np.zeros(7), 0, 0),
        r"q has the shape \(7,\), but the arm 6 joints",
    ),
    (lambda model: model.torque(np.zeros((4, 6)), np.zeros(6), 0), r"qd has the shape \(6,\)"),
    (lambda model: model.torque(np.zeros(6)), "qd is missing"),
    (lambda model: model.torque(np.full(6, np.nan), 0, 0), "q has cells that are no numbers"),
    (lambda model: model.torque([["one"] * 6] * 9, 0, 0), r"q: \[\['one', .* holds no numbers"),
    (lambda model: model.friction(np.array([["a"] * 6])), r"velocity: ndarray \(1, 6\); give"),
    (lambda model: model.torque(np.zeros(6), 0, 0, payload="2 kg"), "payload: '2 kg'; give a mass"),
    (lambda model: model.torque(np.zeros(6), 0, 0, payload=-1), "payload: -1; give a mass"),
    (lambda model: model.torque(np.zeros((3, 6)), 0, 0, period=0), "period: 0; give the seconds"),
    (lambda model: model.friction(np.zeros((3, 5))), r"velocity has the shape \(3, 5\)"),
]


@pytest.mark.parametrize(("call", "message"), WRONG)
def test_wrong_shapes_are_told(call: object, message: str, model: ur5lib.Model) -> None:
    with pytest.raises(ur5lib.InputError, match=message):
        call(model)
