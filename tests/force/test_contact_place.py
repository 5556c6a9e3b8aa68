"""Where contacts are assumed: what says so, and what follows from it for force and moment."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_up_torques import FLANGE, MODEL, PRIOR, Free, free_run, torque_of
from ur5lib.force.contact_place import jacobian_at, std_at_flange, wrench_at_flange
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench, used_rows
from ur5lib.records.contact_place import ContactPlace, contact_place
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

TOOL = [0.0, 0.0, 0.15, 0.0, 0.0, 0.0]
KNOWN = {"lever": 0.03, "lever_weight": 20.0}


def test_the_study_comes_before_its_tool_before_what_was_recorded_before_what_is_mounted() -> None:
    stated, sensor = ([0.1, 0.0, 0.2], 0.05), [0.0, 0.0, 0.03]
    tools = {"tool": TOOL, "tcp_offset": [0.0, 0.0, 0.2, 0, 0, 0]}
    centers = {"sensor": sensor, "payload": [0.0, 0.0, 0.04]}
    found = []
    while True:
        found.append(contact_place(stated, tools, centers))
        if stated is not None:
            stated = None
        elif tools or centers:
            (tools or centers).pop(next(iter(tools or centers)))
        else:
            break
    sources = ["study", "tool", "tcp_offset", "sensor", "payload", "none"]
    assert [one.source for one in found] == sources
    assert [one.point[2] for one in found] == [0.2, 0.15, 0.2, 0.03, 0.04, 0.0]
    assert [one.within for one in found] == [0.05, 0.03, 0.03, 0.1, 0.1, 0.1]
    assert [one.weight for one in found] == [20.0] * 3 + [1.0] * 3


def test_a_tool_centre_point_on_the_flange_was_never_set() -> None:
    assert contact_place(None, {"tcp_offset": [0.0] * 6}, {}) == ContactPlace()
    assert contact_place(None, {"tool": None}, {"payload": None}) == ContactPlace()


def test_a_wrench_at_the_place_is_that_torque_at_the_flange(ur5: Robot) -> None:
    """J_pᵀ w = Jᵀ w', for any wrench w; a force there has the moment p × F."""
    run, random = free_run(ur5, 1, seconds=1.0), np.random.default_rng(0)
    place, wrench = run.rotation @ random.normal(size=3), random.normal(size=(len(run.time), 6))
    moved = wrench_at_flange(wrench, place)
    expected = torque_of(run.jacobian, moved)
    np.testing.assert_allclose(torque_of(jacobian_at(run.jacobian, place), wrench), expected)
    force = np.where(np.arange(6) < 3, wrench, 0.0)
    moment = wrench_at_flange(force, place)[:, 3:]
    np.testing.assert_allclose(moment, np.cross(place, force[:, :3]))


def test_errors_move_with_their_wrench() -> None:
    """As drawn errors do, of all six components alike or not."""
    random, place = np.random.default_rng(1), np.array([[0.1, -0.2, 0.3]])
    std = np.array([[1.0, 2.0, 3.0, 0.1, 0.2, 0.3]])
    drawn = std * random.normal(size=(200_000, 6))
    moved = wrench_at_flange(drawn, np.broadcast_to(place, (len(drawn), 3)))
    np.testing.assert_allclose(std_at_flange(std, place)[0], moved.std(axis=0), rtol=0.01)


def estimated(run: Free, point: Array, known: bool) -> WrenchEstimate:
    """With a place of contacts in frame 6 [m]."""
    own = run.input()
    rows = used_rows(own.segment, own.period, MODEL.cutoff)
    prior = replace(PRIOR, **KNOWN) if known else PRIOR
    place = run.rotation[rows] @ point
    return estimate_wrench(own, run.jacobian[rows], MODEL, prior, place)


def pushed(ur5: Robot, off: Array, seed: int) -> tuple[Free, Array]:
    """A motion with four pushes of 40 N, at a point of frame 6 [m]."""
    run, random = free_run(ur5, seed), np.random.default_rng(seed)
    force = np.zeros((len(run.time), 3))
    for start in (3.0, 8.0, 13.0, 18.0):
        way = random.normal(size=3)
        during = (run.time > start) & (run.time < start + 2.5)
        force[during] = 40 * way / np.linalg.norm(way)
    wrench = run.wrench(force, off)
    return run.pushed(wrench), wrench


@pytest.fixture(scope="module")
def errors(ur5: Robot) -> dict[tuple[float, str], tuple[float, float]]:
    """RMSE [N], and share inside the band, of a tool's length [m] and what is known of it."""
    found = {}
    for length in (0.0, 0.08, 0.15, 0.25):
        tip = np.array([0.0, 0.0, length])
        ways = {"known": (tip, True), "unknown": (FLANGE, False)}
        ways["wrong"] = tip + np.array([0.0, 0.0, 0.05]), True
        for name, (point, known) in ways.items():
            square, inside = [], []
            for seed in range(40, 46):
                run, true = pushed(ur5, tip, seed)
                estimate = estimated(run, point, known)
                error, touched = (estimate.wrench - true)[:, :3], (true != 0).any(axis=1)
                square.append((error[touched] ** 2).sum(axis=1))
                band = 1.96 * estimate.std[touched, :3]
                inside.append(np.abs(error[touched]) <= band)
            rmse = float(np.sqrt(np.concatenate(square).mean()))
            found[length, name] = rmse, float(np.concatenate(inside).mean())
    return found


def test_with_the_place_known_a_long_tool_is_as_good_as_none(
    errors: dict[tuple[float, str], tuple[float, float]],
) -> None:
    known = [rmse for (_, way), (rmse, _) in errors.items() if way == "known"]
    assert max(known) <= 1.2 * min(known), known
    assert min(inside for _, inside in errors.values()) >= 0.9, errors
    for length in (0.15, 0.25):
        assert errors[length, "known"][0] < errors[length, "unknown"][0]
