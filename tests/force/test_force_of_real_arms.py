"""The estimates on the thesis's recordings with a force sensor, and on pushes of a UR10e.

Nothing is fitted on what is judged, and what judges comes from fits that saw no such path. The
sensor's clock is its host's, and what the arm carries is declared, as in the workflow. Errors and
contacts found are those of the built study: tests/artefacts/test_thesis.py.
"""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_up_torques import unnoticed
from tests.real_arms import PRIOR, Fitted, RealRecording, RealStudy
from ur5lib.force.thresholds import alarms
from ur5lib.force.wrench_estimate import WrenchEstimate
from ur5lib.timeseries.metrics import correlation

FREE = ["Movement_No8_Singularity_Free_1", "Movement_No9_Singularity_Free_NoDist"]
PUSHED = "Movement_No9_Singularity_Free_ForceSensor"
SENSED = [
    PUSHED,
    "Movement_No10_Standstill_ForceSensor_All",
    "Movement_No10_Standstill_ForceSensor_Fx",
]
UR10E_FITTED = ["ur-20_01_17-p2", "ur-20_02_12-50sec_12harm", "ur-20_02_19_14harm50sec"]
UR10E_PUSHED = "ur-20_01_22-push_pose_1"


@pytest.fixture(scope="module")
def thesis(real_ur5: RealStudy) -> dict[str, RealRecording]:
    return {name: real_ur5.recording(name) for name in (*FREE, *SENSED)}


@pytest.fixture(scope="module")
def known(real_ur5: RealStudy) -> Fitted:
    return real_ur5.fitted(real_ur5.names("fit"))


@pytest.fixture(scope="module")
def estimates(thesis: dict[str, RealRecording], known: Fitted) -> dict[str, WrenchEstimate]:
    return {name: known.estimate(thesis[name]) for name in SENSED}


# The sign


def test_the_sensor_feels_its_tool_pull_downwards(thesis: dict[str, RealRecording]) -> None:
    """As R_6 turns, the free reading follows the weight of a tool of about 0.1 kg, not its lift."""
    offset = thesis[PUSHED].sensor[1]
    assert 0.05 < offset.mass < 0.15
    assert offset.mass > 10 * offset.mass_std
    assert 0.4 < offset.free.mean() < 0.8


def test_motors_work_against_what_the_sensor_reads(
    thesis: dict[str, RealRecording], known: Fitted
) -> None:
    """k (i_modelled - i) = J^T F with F as read, not its opposite; F^u is the opposite."""
    taken = thesis[PUSHED]
    sensor = taken.sensor[0]
    seen = (taken.kinematics.jacobian.mT @ sensor[..., None])[..., 0]
    assert (correlation(known.torque(taken), seen)[:5] > 0.5).all()
    assert (correlation(known.torque(taken), seen)[:4] > 0.8).all()
    controllers = taken.signals.actual_TCP_force
    assert controllers is not None
    assert (correlation(controllers, sensor)[:3] < -0.3).all()


def is_the_arms_own(known: Fitted, taken: RealRecording, usual: WrenchEstimate) -> None:
    """The prior's force times or divided by five moves no force in contact beyond its band."""
    for factor in (0.2, 5.0):
        prior = replace(PRIOR, force=factor * PRIOR.force)
        other = known.estimate(taken, prior=prior)
        moved = np.abs(other.wrench - usual.wrench)[:, :3]
        assert (moved <= 1.96 * usual.std[:, :3])[usual.log_odds > 0].all()


@pytest.mark.parametrize("name", SENSED)
def test_the_answer_is_not_the_priors(
    thesis: dict[str, RealRecording], known: Fitted, estimates: dict[str, WrenchEstimate], name: str
) -> None:
    is_the_arms_own(known, thesis[name], estimates[name])


# A push that is known, put onto a motion that nothing touches


@pytest.mark.parametrize("name", FREE)
def test_a_sustained_push_is_told_at_any_size(
    thesis: dict[str, RealRecording], known: Fitted, name: str
) -> None:
    """From 5 s on for 15 s, along x, y, z; what the gears lose is as the fit says."""
    taken = thesis[name]
    run, model = known.problem(taken)
    gears = run.gears
    assert gears is not None
    time = taken.motion.period * np.arange(len(taken.kinematics.jacobian))
    on = (time >= 5) & (time < 20)
    sizes, told, held = np.array([5.0, 30.0, 80.0]), np.zeros((3, 3)), np.zeros((3, 3, 3))
    for i, size in enumerate(sizes):
        for axis in range(3):
            wrench = np.where(on[:, None], size * np.eye(6)[axis], 0.0)
            felt = gears.felt((taken.kinematics.jacobian.mT @ wrench[..., None])[..., 0])
            estimate = known.estimate(taken, extra=felt)
            told[i, axis] = estimate.wrench[on, axis].mean()
            std = unnoticed(estimate, taken.kinematics.jacobian, run.states, model)
            inside = np.abs(estimate.wrench - wrench) <= 1.96 * std
            held[i, axis] = inside[on, :3].mean(axis=0)
    slope = sizes @ told / (sizes @ sizes)
    assert (np.abs(slope - 1) <= 0.1).all()
    assert held.mean(axis=(1, 2)).min() >= 0.9


# Another arm, without a force sensor


@pytest.fixture(scope="module")
def ur10e_pushed(real_ur10e: RealStudy) -> tuple[Fitted, RealRecording]:
    return real_ur10e.fitted(UR10E_FITTED), real_ur10e.recording(UR10E_PUSHED)


def test_pushes_of_a_ur10e(ur10e_pushed: tuple[Fitted, RealRecording]) -> None:
    known, pushed = ur10e_pushed
    estimate = known.estimate(pushed)
    found = alarms(estimate.log_odds, 0.0)
    assert 3 <= len(found) <= 6
    assert 0.1 < sum(last - first for first, last in found) / len(estimate.log_odds) < 0.5
    assert np.isfinite(estimate.wrench).all()
    assert np.isfinite(estimate.std).all()
    assert np.abs(estimate.wrench[:, :3]).max() < 150
    assert pushed.signals.force_sensor is None
    is_the_arms_own(known, pushed, estimate)
