"""An arm of seven joints: what counts joints counts those of the arm."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pinocchio
import pytest
import yaml

from tests.current_study import noisy, prior, smooth
from ur5lib.checks.checked import Checked, described_arms
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.dynamics.link_model import LinkModel, load_regressor
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import FITTED_STATE_COUNT, JointState
from ur5lib.force.force_input import ForceInput
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.wrench_estimate import estimate_wrench, used_rows
from ur5lib.identification.base_parameters import (
    base_parameters,
    identified_model,
    identify,
    prior_width,
    stack,
)
from ur5lib.identification.consistency import consistent_parameters, smallest_eigenvalues
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import predict
from ur5lib.identification.payload import estimate_payload
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import Normal
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_yaml
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.statics import flange_kinematics, gravity_torque
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.smoothing.smoothed_motion import motion_record
from ur5lib.steps.draw_models import draw_models
from ur5lib.steps.identify_model import identify_model
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, zero_phase_lowpass

JOINTS, PERIOD = 7, 0.008
ALPHA = (-90, 90, 90, -90, -90, 90, 0)  # degrees; the geometry is a KUKA LBR iiwa 7's
OFFSET = (0.34, 0, 0.4, 0, 0.4, 0, 0.126)  # m


@cache
def arm() -> Robot:
    """Links of 4 kg and less, each with an inertia tensor without symmetry, and rotors."""
    random, masses = np.random.default_rng(0), np.linspace(4.0, 0.5, JOINTS)
    inertias = [m * np.array([0.02, 0.018, 0.012, 0.001, -0.002, 0.0015]) for m in masses]
    return Robot.model_validate(
        {
            "name": "seven",
            "gravity": [0.3, -0.2, -9.8],
            "denavit_hartenberg": [
                {"a": 0.0, "d": d, "alpha": np.deg2rad(alpha)}
                for d, alpha in zip(OFFSET, ALPHA, strict=True)
            ],
            "joints": ["one"] * JOINTS,
            "motors": {"one": {"position_max": 3.0, "velocity_max": 2.0, "torque_max": 100.0}},
            "masses": masses.tolist(),
            "models": {
                "made up": {
                    "description": "",
                    "centers_of_mass": random.uniform(-0.1, 0.1, (JOINTS, 3)).tolist(),
                    "inertias": [own.tolist() for own in inertias],
                    "rotor_inertias": random.uniform(0.05, 0.5, JOINTS).tolist(),
                }
            },
            "chosen_model": "made up",
        }
    )


def sines(seconds: float) -> list[Array]:
    """Motion q, q̇, q̈ (N, 7) of three sines on each joint."""
    random = np.random.default_rng(1)
    w = 2 * np.pi * random.uniform(0.05, 0.5, (JOINTS, 3))
    size, start = random.uniform(0.2, 0.5, w.shape), random.uniform(0, 6, w.shape)
    phase = w * np.arange(0, seconds, PERIOD)[:, None, None] + start
    waves = size * np.sin(phase), size * w * np.cos(phase), -size * w**2 * np.sin(phase)
    return [wave.sum(axis=2) for wave in waves]


def test_dynamics_and_kinematics_are_pinocchio_s() -> None:
    robot, motion = arm(), sines(4)
    model = LinkModel(robot, "made up")
    engine = pinocchio.buildModelFromXML(urdf(robot, rigid_bodies(robot, "made up")))
    engine.gravity.linear = np.array(robot.gravity)
    engine.armature = rigid_bodies(robot, "made up").rotor_inertia
    data, frame = engine.createData(), engine.getFrameId("frame_7")
    torque = np.array([pinocchio.rnea(engine, data, *row) for row in zip(*motion, strict=True)])
    np.testing.assert_allclose(model.inverse_dynamics(*motion), torque, atol=1e-9)
    np.testing.assert_allclose(model.regressor(*motion) @ model.parameters, torque, atol=1e-9)
    at_rest = np.array([pinocchio.computeGeneralizedGravity(engine, data, q) for q in motion[0]])
    np.testing.assert_allclose(gravity_torque(robot, "made up", motion[0]), at_rest, atol=1e-9)
    rotation, origin, jacobian = flange_kinematics(robot, motion[0])
    for k, q in enumerate(motion[0][:50]):
        theirs = pinocchio.computeFrameJacobian(
            engine, data, q, frame, pinocchio.LOCAL_WORLD_ALIGNED
        )
        pinocchio.framesForwardKinematics(engine, data, q)
        np.testing.assert_allclose(jacobian[k], theirs, atol=1e-9)
        np.testing.assert_allclose(origin[k], data.oMf[frame].translation, atol=1e-9)
        np.testing.assert_allclose(rotation[k], data.oMf[frame].rotation, atol=1e-9)


def test_a_payload_weighs_on_all_joints() -> None:
    robot, q = arm(), sines(2)[0]
    loaded = robot.carrying(Payload(mass=2.0, center_of_mass=(0.1, 0.0, 0.2)))
    added = gravity_torque(loaded, "made up", q) - gravity_torque(robot, "made up", q)
    per_load = load_regressor(robot, "made up", q, 0 * q, 0 * q)
    np.testing.assert_allclose(per_load @ [2.0, 0.2, 0.0, 0.4], added, atol=1e-9)


def test_accelerations_are_smoothed() -> None:
    """Less than half the error of differences: encoders of 0.1 mrad, velocities of 2 mrad/s."""
    random, (q, qd, qdd) = np.random.default_rng(2), sines(20)
    time, segment = PERIOD * np.arange(len(q)), np.zeros(len(q), np.int64)
    noisy = q + 1e-4 * random.normal(size=q.shape), qd + 2e-3 * random.normal(size=q.shape)
    smoothed = smooth_encoders(time, segment, *noisy)
    inner = slice(50, -50)
    error = (smoothed.qdd - qdd)[inner]
    assert smoothed.state.shape == (len(q), 3 * JOINTS)
    differences = np.gradient(noisy[1], PERIOD, axis=0) - qdd
    assert (error.std(axis=0) < 0.5 * differences[inner].std(axis=0)).all()
    inside = np.abs(error) < 1.96 * smoothed.std[inner, 2 * JOINTS :]
    assert inside.mean() > 0.9


def test_links_are_identified() -> None:
    """The base parameters, with standard errors that hold the truth, and bodies that may exist."""
    robot, random = arm(), np.random.default_rng(3)
    model, motion = LinkModel(robot, "made up"), sines(60)
    rows, truth = model.regressor(*motion), model.parameters
    torque = rows @ truth + random.normal(0, 0.02, (len(rows), JOINTS))
    prior = truth * random.uniform(0.8, 1.2, truth.shape)
    parts = [slice(start, start + 125) for start in range(0, len(rows), 125)]
    data = stack((rows[part], torque[part]) for part in parts)
    estimate = identify(data, prior, prior_width(len(truth)))
    base = base_parameters(model.regressor(*random.uniform(-3, 3, (3, 300, JOINTS))))
    known = estimate.determined(base.groups)
    error = np.abs(base.groups @ (estimate.parameters - truth))
    inside = error < 1.96 * estimate.standard_errors(base.groups)
    assert known.mean() > 0.9
    assert inside[known].mean() > 0.85
    parameters = consistent_parameters(estimate)
    assert len(smallest_eigenvalues(parameters)) == JOINTS
    assert smallest_eigenvalues(parameters).min() > 0
    identified = robot.with_model("identified", identified_model(robot, parameters, ""))
    off = LinkModel(identified, "identified").inverse_dynamics(*motion) - rows @ truth
    assert np.abs(off).max() < 0.05


def test_what_its_controller_tells_is_fitted() -> None:
    """Torques at the targets show the rotors, and a model that repeats them."""
    robot, states = arm(), sines(40)
    time, segment = PERIOD * np.arange(len(states[0])), np.zeros(len(states[0]), np.int64)
    torque = LinkModel(robot, "made up").inverse_dynamics(*states)
    torque += np.random.default_rng(6).normal(0, 1e-3, torque.shape)
    names = ("target_q", "target_qd", "target_qdd")
    signals = Signals(
        time=time,
        segment=segment,
        interpolated=segment > 0,
        actual_q=states[0],
        target_moment=torque,
        **dict(zip(names, states, strict=True)),
    )
    motion = motion_record(signals, smooth_encoders(time, segment, *states[:2]))
    known = {"sines": signals}, {"sines": motion}, {"sines": None}
    found = identify_model(robot, *known, Butterworth(4, 10.0), Butterworth(4, 2.0))
    assert found.summary.refused is None
    fitted = Robot.model_validate(yaml.safe_load(found.arm))
    off = LinkModel(fitted, "identified").inverse_dynamics(*states) - torque
    assert np.abs(off).mean() < 0.02


def test_a_wrench_is_estimated() -> None:
    """A push of 3 s with 30 N along y, felt by seven joints with an error of 0.3 Nm."""
    robot, random = arm(), np.random.default_rng(4)
    q = sines(20)[0]
    wrench, pushed = np.zeros((len(q), 6)), slice(1000, 1375)
    wrench[pushed, 1] = 30.0
    jacobian = flange_kinematics(robot, q)[2]
    slow = 0.2 * np.cumsum(random.normal(0, np.sqrt(PERIOD / 10), q.shape), axis=0)
    torque = (jacobian.mT @ wrench[..., None])[..., 0] + slow
    torque = zero_phase_lowpass(torque, 1 / PERIOD, 2, 2.0)
    model = ResidualModel(
        spread=np.full((FITTED_STATE_COUNT, JOINTS), 0.3),
        change=np.full((FITTED_STATE_COUNT, JOINTS), 0.1),
        rate=np.full(FITTED_STATE_COUNT, 0.1),
        independent=0.25,
        breakaway=np.ones(JOINTS),
    )
    segment = np.zeros(len(q), np.int64)
    used = jacobian[used_rows(segment, PERIOD, model.cutoff)]
    states = np.full(q.shape, JointState.MOVING, np.int8)
    run = ForceInput(q, 0 * q, torque, states, segment, PERIOD)
    found = estimate_wrench(run, used, model, ContactPrior(15.0))
    inner = slice(pushed.start + 50, pushed.stop - 50)
    error = np.abs(found.wrench - wrench)
    assert found.background.shape == q.shape
    assert (found.log_odds[inner] > 0).all()
    assert (found.log_odds[:800] < 0).all()
    assert error[inner, :3].mean() < 5.0
    assert np.mean(error[inner, :3] < 1.96 * found.std[inner, :3]) > 0.9


def seventh(values: Array) -> Array:
    """With a copy of the first joint."""
    return np.concatenate([values, values[..., :1]], axis=-1)


def test_currents_are_fitted() -> None:
    """A seventh joint with the motion and current of the first has its map."""
    six = noisy(range(2), seconds=10.0)
    names = ("q", "qd", "torque", "current")
    records = [replace(r, **{name: seventh(getattr(r, name)) for name in names}) for r in six]
    known = prior()
    inverse = known.inverse_constant
    precision = np.diag(seventh(np.diag(inverse.precision)))
    wide = Prior(Normal(seventh(inverse.mean), precision), seventh(known.torque_max))
    fit, expected = fit_currents(records, smooth, wide), fit_currents(six, smooth, known)
    assert len(fit.joints) == JOINTS
    for own, other in zip(fit.joints, (*expected.joints, expected.joints[0]), strict=True):
        np.testing.assert_allclose(own.estimate.coefficients, other.estimate.coefficients)
    predicted = predict(fit, records[0])
    np.testing.assert_allclose(predicted, seventh(predict(expected, six[0])))
    # a load on all of them, and the friction that it adds
    per_load = np.stack([np.cos(records[0].q), np.sin(2 * records[0].q)], axis=2)
    heavy = replace(records[0], torque=records[0].torque + per_load @ [2.0, 0.3])
    found = estimate_payload(
        fit, replace(records[0], current=predict(fit, heavy)), per_load, smooth
    )
    np.testing.assert_allclose(found.parameters, [2.0, 0.3], atol=0.01)


def test_its_description_is_read_back(tmp_path: Path) -> None:
    file = tmp_path / "seven.yaml"
    file.write_text(robot_yaml(arm()))
    assert load_robot(file) == arm()


@pytest.mark.parametrize("field", ["masses", "denavit_hartenberg"])
def test_a_joint_that_is_not_described_is_refused(field: str) -> None:
    described = arm().model_dump()
    described[field] = described[field][:-1]
    with pytest.raises(ValueError, match=rf"`{field}` has 6 entries; give 7, one for each"):
        Robot.model_validate(described)


def test_a_description_that_changes_is_read_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    for changed in (arm(), arm().model_copy(update={"gravity": (0.0, 0.0, -9.8)})):
        Path("robots/seven.yaml").write_text(robot_yaml(changed))
        assert described_arms()["seven"] == changed


def test_its_link_models_are_drawn() -> None:
    assert {*draw_models(arm())} == {"models", "frames"}


def test_it_is_no_cause_of_what_six_joints_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ur5: Robot
) -> None:
    """Described beside the arms of six joints, it explains none of their torques."""
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    Path("robots/seven.yaml").write_text(robot_yaml(arm()))
    time = np.arange(0, 60, PERIOD)
    q = np.sin(0.5 * time[:, None] + np.arange(6))
    model = LinkModel(ur5, ur5.fullest_model())
    qd, qdd = (np.gradient(q, PERIOD, axis=0), -0.25 * q)
    torque = model.inverse_dynamics(q, qd, qdd)
    channels = {"actual_q": q, "actual_qd": qd, "target_moment": torque}
    table = pd.DataFrame({"time": time, "segment": 0, "interpolated": False})
    for name, values in channels.items():
        table[[f"{name}_{k}" for k in range(6)]] = values
    assert "seven" in robot_names()
    assert stop_signs(Checked(table, ur5, None, None, False, cutoff=2.0)) == []
