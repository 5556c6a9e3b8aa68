"""Inertial parameters: identities, known arms under noise, the model of a real controller."""

import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pinocchio
import pytest
import torch
from scipy.signal import lfilter

from tests.conftest import PROJECT
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import RefusalError
from ur5lib.identification import base_parameters as module
from ur5lib.identification.base_parameters import (
    BaseParameters,
    InertialEstimate,
    base_parameters,
    identified_model,
    identify,
    parameter_names,
    prior_width,
    stack,
    torque_error,
    total_factors,
)
from ur5lib.identification.consistency import (
    DEFINITENESS_MARGIN,
    LINK_LENGTH,
    consistent_parameters,
    pseudo_inertias,
    smallest_eigenvalues,
)
from ur5lib.robots.description import (
    Robot,
    load_robot,
    robot_names,
    robot_path,
    robot_yaml,
)
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.timeseries.arrays import Array

torch.set_num_threads(1)
PERIOD = 0.04  # s


def columns(name: str, *motion: Array) -> Array:
    """Y of an arm, (N, 6, 66)."""
    robot = load_robot(robot_path(name))
    return LinkModel(robot, robot.chosen_model).regressor(*motion)


def parameters(robot: Robot, model: str) -> Array:
    return LinkModel(robot, model).parameters


def random_states(seed: int = 0, count: int = 200) -> Array:
    limits = np.array([np.pi, 3.2, 15])[:, None, None]
    return np.random.default_rng(seed).uniform(-1, 1, (3, count, 6)) * limits


@cache
def ur5_base() -> BaseParameters:
    return base_parameters(columns("ur5", *random_states()))


def sines(seconds: float, still: tuple[int, ...] = (), seed: int = 3) -> list[Array]:
    """Five sines of up to 0.5 Hz on each joint, q, q̇, q̈ (N, 6); `still` joints do not move."""
    random = np.random.default_rng(seed)
    w = 2 * np.pi * random.uniform(0.05, 0.5, (6, 5))
    size = random.uniform(0.2, 0.6, (6, 5))
    size[list(still)] = 0
    phase = w * np.arange(0, seconds, PERIOD)[:, None, None] + random.uniform(0, 6, (6, 5))
    waves = size * np.sin(phase), size * w * np.cos(phase), -size * w**2 * np.sin(phase)
    return [wave.sum(axis=2) for wave in waves]


def blocks(rows: Array, torque: Array, size: int = 50) -> Iterator[tuple[Array, Array]]:
    for start in range(0, len(rows), size):
        yield rows[start : start + size], torque[start : start + size]


def fit(rows: Array, torque: Array, prior: Array, size: int = 50) -> InertialEstimate:
    return identify(stack(blocks(rows, torque, size)), prior, prior_width(rows.shape[2]))


def test_intervals_of_a_noise_free_study_hold_the_truth(ur5: Robot) -> None:
    """Its digits are its errors: on a path that repeats itself, blocks agree on them."""
    model, base = LinkModel(ur5, "C"), ur5_base()
    inside, by_jackknife = [], []
    for seed in range(4):
        motion = [np.tile(values, (3, 1)) for values in sines(20, seed=seed)]
        torque = model.inverse_dynamics(*motion)
        *logged, logged_torque = (np.round(values, 6) for values in (*motion, torque))
        found = fit(model.regressor(*logged), logged_torque, 0.9 * model.parameters)
        known = found.determined(base.groups)
        error = np.abs(base.groups @ (found.parameters - model.parameters))[known]
        inside += [*(error < 1.96 * found.standard_errors(base.groups)[known])]
        scattered = np.linalg.norm(base.groups @ found.scatter.T, axis=1)[known]
        by_jackknife += [*(error < 1.96 * scattered)]
    assert len(inside) > 120
    assert np.mean(inside) > 0.95, np.mean(inside)
    assert np.mean(by_jackknife) < 0.85, np.mean(by_jackknife)


# Base parameters


@pytest.mark.parametrize("name", robot_names())
def test_an_ur_has_forty_base_parameters_that_make_all_torques(name: str) -> None:
    base = base_parameters(columns(name, *random_states(0)))
    rows = columns(name, *random_states(1))
    assert base.groups.shape == (40, 66)
    assert np.linalg.matrix_rank(rows.reshape(-1, 66)) == 40
    np.testing.assert_allclose(rows[..., base.columns] @ base.groups, rows, atol=1e-11)
    np.testing.assert_allclose(base.groups[:, base.columns], np.eye(40), atol=1e-12)


def test_names_are_those_of_another_processor() -> None:
    """It rounds the last digits otherwise."""
    base = ur5_base()
    errors = np.random.default_rng(0).normal(0, 1e-3, base.groups.shape)
    assert replace(base, groups=base.groups * (1 + errors)).names() == base.names()
    assert len({*base.names()}) == len(base.columns)


def test_names_say_what_is_hidden_in_what() -> None:
    names = ur5_base().names()
    assert "m c_y of link 5 with m c_z of link 6" in names  # Khalil and Dombre's regrouping
    assert names[0].startswith("I_zz of link 1 with ")
    assert names[0].endswith(", rotor inertia of joint 1")
    assert names[-1] == "rotor inertia of joint 6"
    assert (parameter_names(66)[0], parameter_names(66)[59], parameter_names(66)[60]) == (
        "m of link 1",
        "I_zz of link 6",
        "rotor inertia of joint 1",
    )


# Accumulation


def test_blocks_add_up_without_growing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_BLOCKS", 7)
    rows, torque = columns("ur5", *sines(20)), np.random.default_rng(0).normal(size=(500, 6))
    torque[123, 4] = np.nan
    data = stack(blocks(rows, torque, 10))
    assert data.factors.shape == (7, 6, 67, 67)
    assert data.samples.sum() == 499
    assert data.samples.max() < 3 * data.samples.min()
    known = np.delete(np.concatenate([rows, torque[..., None]], axis=2), 123, axis=0)
    factor = total_factors(data)
    np.testing.assert_allclose(
        factor.mT @ factor, np.einsum("njp,njq->jpq", known, known), atol=1e-9
    )


def test_what_cannot_be_fitted_is_refused(ur5: Robot) -> None:
    rows, torque = columns("ur5", *sines(4)), np.zeros((100, 6))
    with pytest.raises(RefusalError, match="no known torque"):
        stack(blocks(rows, torque + np.nan))
    with pytest.raises(RefusalError, match="one block"):
        fit(rows, torque, parameters(ur5, "C"), size=100)


def test_noise_is_at_least_the_last_digit_of_a_torque(ur5: Robot) -> None:
    rows = columns("ur5", *sines(20))
    exact = fit(rows, rows @ parameters(ur5, "C"), parameters(ur5, "C"))
    np.testing.assert_array_equal(exact.noise, 1e-6)


@pytest.mark.parametrize("count", [2, 12])
def test_noise_is_by_the_degrees_of_freedom_that_are_left(count: int) -> None:
    """Six joints of one parameter each, in blocks of one sample: n - 1 of n."""
    random = np.random.default_rng(3)
    rows = np.eye(6) * random.normal(size=(count, 6, 1))
    torque = rows @ np.arange(6.0) + random.normal(size=(count, 6))
    found = identify(
        stack(zip(rows[:, None], torque[:, None], strict=True)), np.zeros(6), np.full(6, 1e6)
    )
    for joint in range(6):
        slope = rows[:, joint, joint] @ torque[:, joint] / (rows[:, joint, joint] ** 2).sum()
        residual = torque[:, joint] - slope * rows[:, joint, joint]
        assert found.parameters[joint] == pytest.approx(slope)
        assert found.noise[joint] == pytest.approx(np.sqrt((residual**2).sum() / (count - 1)))
        changes = [
            (drop * rows[:, joint, joint])
            @ torque[:, joint]
            / (drop * rows[:, joint, joint] ** 2).sum()
            - slope
            for drop in 1 - np.eye(count)
        ]
        error = np.sqrt((count - 1) / count * np.sum(np.square(changes)))
        assert found.standard_errors(np.eye(6))[joint] == pytest.approx(error, rel=1e-6)


def test_the_prior_is_as_wide_as_the_methods_say() -> None:
    """By the kind of a parameter: masses, first moments, inertias, rotors."""
    text = " ".join((PROJECT / "docs" / "methods.md").read_text(encoding="utf-8").split())
    stated = re.findall(r"(masses|first moments|inertias about the joint|rotors) ± ([\d.]+)", text)
    kinds = {"m of": "masses", "m c": "first moments", "I_": "inertias about the joint"}
    widths = {kind: float(number) for kind, number in stated}
    expected = [
        widths[next((kinds[start] for start in kinds if name.startswith(start)), "rotors")]
        for name in parameter_names(22)
    ]
    np.testing.assert_array_equal(prior_width(22), expected)


# Known arms


def test_intervals_hold_the_truth(ur5: Robot) -> None:
    """200 runs with joint 6 at rest and a truth that the prior knows nothing better of than its
    widths; noise like a current's: correlated over a fifth of a second.
    """
    random, groups = np.random.default_rng(0), ur5_base().groups
    rows, prior = columns("ur5", *sines(100, still=(5,))), parameters(ur5, "C")
    truth = prior + random.normal(size=66) * prior_width(66)
    size = np.array([0.15, 0.15, 0.15, 0.06, 0.06, 0.06])  # Nm
    exact = fit(rows, rows @ truth, prior)
    lost = np.abs(groups @ (exact.parameters - truth)) > 0.01 * np.abs(groups @ (prior - truth))
    assert [parameter_names(66)[column] for column in ur5_base().columns[lost]] == [
        "rotor inertia of joint 6"
    ]

    called, inside = [], []
    for _ in range(200):
        noise = lfilter([0.6], [1, -0.8], random.normal(size=(len(rows), 6)), axis=0) * size
        found = fit(rows, rows @ truth + noise, prior, size=100)
        called.append(found.determined(groups))
        error = np.abs(groups @ (found.parameters - truth))
        inside.append(error < 1.96 * found.standard_errors(groups))
    share = np.sum(np.array(inside) & called, axis=0) / np.maximum(np.sum(called, axis=0), 1)
    assert not np.any(np.array(called)[:, lost])
    assert np.mean(called, axis=0)[~lost].min() > 0.99
    assert share[~lost].min() >= 0.9
    assert share[~lost].max() <= 0.99


def test_a_standstill_tells_no_parameter_and_keeps_the_rest(ur5: Robot) -> None:
    q = np.repeat([[0.1, -1, 1.2, 0.3, 0.9, 0]], 500, axis=0)
    rows, prior = columns("ur5", q, 0 * q, 0 * q), parameters(ur5, "C")
    torque = rows @ parameters(ur5, "B")
    noise = np.random.default_rng(0).normal(0, 0.01, torque.shape)
    found = fit(rows, torque + noise, prior)
    assert not found.determined(ur5_base().groups).any()
    assert torque_error(blocks(rows, torque), found.parameters).max() < 0.002
    np.testing.assert_array_equal(found.parameters[60:], prior[60:])


def test_a_recording_of_one_joint_tells_what_that_joint_feels(ur5: Robot) -> None:
    q, qd, qdd = sines(30, still=(0, 1, 2, 3, 4))
    rows, truth = columns("ur5", q + 0.7, qd, qdd), parameters(ur5, "C+rotors")
    noise = np.random.default_rng(0).normal(0, 0.001, q.shape)
    found = fit(rows, rows @ truth + noise, parameters(ur5, "C"))
    told = np.array(parameter_names(66))[ur5_base().columns[found.determined(ur5_base().groups)]]
    assert {"m c_x of link 6", "m c_y of link 6"} <= set(told)
    assert not [name for name in told if "link 2" in name or "link 3" in name]


# Links that are bodies; the real controller's are in tests/artefacts/test_thesis.py


def test_the_pseudo_inertia_of_points_is_their_second_moment() -> None:
    """Σ m [r 1] [r 1]ᵀ, with inertia Σ m (r·r 1 - r rᵀ) and first moment Σ m r (Wensing 2018)."""
    random = np.random.default_rng(0)
    mass, r = random.uniform(0.1, 1, 20), random.normal(0, 0.1, (20, 3))
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(mass, r, strict=True))
    link = [mass.sum(), *(mass @ r), *inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    points = np.column_stack([r / LINK_LENGTH, np.ones(20)])
    expected = (points * mass[:, None]).T @ points
    found = pseudo_inertias(np.append(np.tile(link, 6), np.zeros(6)))  # no rotors
    np.testing.assert_allclose(found, np.tile(expected, (6, 1, 1)), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("name", robot_names())
def test_published_models_are_bodies_up_to_their_digits(name: str) -> None:
    """The UR10e's link 6 is a plate to four decimals: (0.1, 0.4, 0.3) g m²."""
    robot = load_robot(robot_path(name))
    for model in robot.models:
        assert smallest_eigenvalues(parameters(robot, model)).min() > -1e-9, model


def test_what_is_a_body_stays_as_it_is(ur5: Robot) -> None:
    rows = columns("ur5", *sines(20))
    noise = np.random.default_rng(0).normal(0, 1e-4, rows.shape[:2])
    found = fit(rows, rows @ parameters(ur5, "C+rotors") + noise, parameters(ur5, "C+rotors"))
    assert smallest_eigenvalues(found.parameters).min() > DEFINITENESS_MARGIN
    np.testing.assert_allclose(consistent_parameters(found), found.parameters, atol=1e-7)


def test_what_is_none_becomes_the_nearest(ur5: Robot) -> None:
    """A wrist of negative inertia and a rotor that helps: the fit believes them, a body cannot."""
    rows, truth = columns("ur5", *sines(20)), parameters(ur5, "C+rotors")
    truth[[59, 65]] = -0.05, -0.2
    torque = rows @ truth + np.random.default_rng(0).normal(0, 0.01, rows.shape[:2])
    found = fit(rows, torque, parameters(ur5, "C"))
    nearest = consistent_parameters(found)
    assert smallest_eigenvalues(found.parameters).min() < 0
    assert smallest_eigenvalues(nearest).min() > 0.5 * DEFINITENESS_MARGIN
    before, after = (torque_error([(rows, torque)], p) for p in (found.parameters, nearest))
    assert after[5] > before[5] + 0.1  # what being a body costs here
    assert identified_model(ur5, nearest, "as near as it gets").rotor_inertias[5] > 0

    def distance(p: np.ndarray) -> float:
        return float(np.linalg.norm(np.linalg.solve(found.spread, p - found.parameters)))

    inside = parameters(ur5, "C")
    for step in (1e-3, 1e-2, 0.1, 1):
        assert distance(nearest) < distance(nearest + step * (inside - nearest))


def test_torques_of_no_bodies_are_refused() -> None:
    """As of a log whose torques belong to another arm, or to none."""
    estimate = InertialEstimate(
        parameters=np.full(66, -5.0),
        scatter=np.zeros((1, 66)),
        spread=1e-6 * np.eye(66),
        rounding=1e-9 * np.eye(66),
        width=np.ones(66),
        noise=np.ones(6),
    )
    with pytest.raises(RefusalError, match="no bodies"):
        consistent_parameters(estimate)


# One model more


@pytest.fixture(scope="module")
def noisy(ur5: Robot) -> InertialEstimate:
    rows, truth = columns("ur5", *sines(100)), parameters(ur5, "C+rotors")
    noise = np.random.default_rng(0).normal(0, 0.05, (len(rows), 6))  # Nm
    return fit(rows, rows @ truth + noise, parameters(ur5, "C"))


def test_parameters_and_models_are_the_same_thing(ur5: Robot) -> None:
    for model in ur5.models:
        given = parameters(ur5, model)
        again = identified_model(ur5, given, "as it was")
        robot = ur5.model_copy(update={"models": {"again": again}})
        np.testing.assert_allclose(parameters(robot, "again"), given, atol=1e-15)


def test_an_identified_model_survives_yaml_and_urdf(
    ur5: Robot, noisy: InertialEstimate, tmp_path: Path
) -> None:
    found = consistent_parameters(noisy)
    model = identified_model(ur5, found, "from target_moment")
    text = robot_yaml(ur5.with_model("identified", model))
    (tmp_path / "ur5.yaml").write_text(text)
    robot = load_robot(tmp_path / "ur5.yaml")
    assert robot.models.keys() == {*ur5.models, "identified"}
    assert robot.models["C+rotors"] == ur5.models["C+rotors"]
    bodies, motion = rigid_bodies(robot, "identified"), random_states(count=100)
    engine = pinocchio.buildModelFromXML(urdf(robot, bodies))
    engine.armature = bodies.rotor_inertia
    data = engine.createData()
    theirs = [pinocchio.rnea(engine, data, *state) for state in zip(*motion, strict=True)]
    np.testing.assert_allclose(theirs, columns("ur5", *motion) @ found, atol=1e-9)


def test_no_model_has_a_negative_mass(ur5: Robot) -> None:
    broken = parameters(ur5, "C")
    broken[50] = -0.1
    with pytest.raises(ValueError, match="greater than 0"):
        identified_model(ur5, broken, "link 6 weighs less than nothing")
