"""A contact that is a weight is named as a load; a push is not."""

import numpy as np
import pytest

from tests.made_up_torques import MODEL, REGULAR, jacobians, torque_of
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.force.external_torque import JointState
from ur5lib.force.grasp import grasped_load
from ur5lib.robots.description import Payload, Robot

PERIOD = 0.016
DEVIATION = MODEL.spread[JointState.MOVING]
LINK_6 = slice(50, 54)
Motion = tuple[np.ndarray, np.ndarray, np.ndarray]


def motion(seconds: float, seed: int, swing: float = 0.4) -> Motion:
    random = np.random.default_rng(seed)
    time = np.arange(0, seconds, PERIOD)[:, None]
    pace, phase = random.uniform(0.4, 1.2, 6), random.uniform(0, 6, 6)
    angle = pace * time + phase
    return (
        REGULAR + swing * np.sin(angle),
        swing * pace * np.cos(angle),
        -swing * pace**2 * np.sin(angle),
    )


def per_load(ur5: Robot, states: Motion) -> np.ndarray:
    return LinkModel(ur5, "C").regressor(*states)[:, :, LINK_6]


def weight(ur5: Robot, states: Motion, payload: Payload) -> np.ndarray:
    """What a load takes of the motors' torque: by inverse dynamics with it and without."""
    bare, loaded = (LinkModel(arm, "C") for arm in (ur5, ur5.carrying(payload)))
    return bare.inverse_dynamics(*states) - loaded.inverse_dynamics(*states)


def noise(count: int, seed: int, scale: float = 0.3) -> np.ndarray:
    """An offset of each joint that lasts, and what changes."""
    random = np.random.default_rng(1000 + seed)
    offset = scale * DEVIATION * random.normal(size=6)
    return offset + 0.2 * DEVIATION * random.normal(size=(count, 6))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("mass", [1.5, 2.0, 5.0])
def test_a_weight_is_named_within_a_tenth(ur5: Robot, mass: float, seed: int) -> None:
    states = motion(8.0, seed)
    payload = Payload(mass=mass, center_of_mass=(0.02, -0.01, 0.08))
    torque = weight(ur5, states, payload) + noise(len(states[0]), seed, scale=0.1)
    load = grasped_load(torque, per_load(ur5, states), DEVIATION, PERIOD)
    assert load is not None
    assert load.mass == pytest.approx(mass, rel=0.1)
    assert abs(load.mass - mass) < 3 * load.std_error
    assert 0 < load.std_error < mass / 3


def test_a_weight_held_still_is_one_too(ur5: Robot) -> None:
    states = motion(4.0, 0, swing=0.0)
    payload = Payload(mass=3.0, center_of_mass=(0.0, 0.0, 0.05))
    torque = weight(ur5, states, payload)
    load = grasped_load(torque, per_load(ur5, states), DEVIATION, PERIOD)
    assert load is not None
    assert load.mass == pytest.approx(3.0, rel=0.1)


SIDEWAYS = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1]]
ASKEW = [[1, 0, -1], [-1, 0, -1], [0, 1, -1], [0, -1, -1]]


@pytest.mark.parametrize(
    ("direction", "swing"),
    [*((own, 0.4) for own in (*SIDEWAYS, *ASKEW)), *((own, 0.0) for own in SIDEWAYS)],
)
def test_a_push_that_is_not_downwards_is_no_load(
    ur5: Robot, direction: list[int], swing: float
) -> None:
    """Sideways, up or askew, as the arm moves; at rest a lever may make a push look like one."""
    states = motion(8.0, 5, swing)
    force = 30.0 * np.tile([*direction, 0, 0, 0], (len(states[0]), 1))
    torque = torque_of(jacobians(ur5, states[0]), force)
    assert grasped_load(torque, per_load(ur5, states), DEVIATION, PERIOD) is None


@pytest.mark.parametrize("seed", range(4))
def test_what_strays_is_no_load(ur5: Robot, seed: int) -> None:
    states = motion(8.0, seed)
    torque = noise(len(states[0]), seed, scale=1.0)
    assert grasped_load(torque, per_load(ur5, states), DEVIATION, PERIOD) is None


@pytest.mark.parametrize(("seconds", "told"), [(1.9, False), (2.0, True), (2.1, True)])
def test_a_contact_of_two_seconds_tells_a_load(ur5: Robot, seconds: float, told: bool) -> None:
    """Sampled at 64 Hz, so that two seconds are exactly that."""
    count = round(64 * seconds)
    states = tuple(state[:count] for state in motion(4.0, 0))
    torque = weight(ur5, states, Payload(mass=3.0, center_of_mass=(0, 0, 0.05)))
    load = grasped_load(torque, per_load(ur5, states), DEVIATION, 1 / 64)
    assert (load is not None) == told


def test_half_a_second_at_both_ends_does_not_count(ur5: Robot) -> None:
    """While a load is taken up or put down."""
    states = motion(4.0, 3)
    torque = weight(ur5, states, Payload(mass=3.0, center_of_mass=(0, 0, 0.05)))
    given = per_load(ur5, states), DEVIATION, PERIOD
    edge = round(0.5 / PERIOD)
    for end, inside in ((slice(edge), edge), (slice(-edge, None), -edge - 1)):
        lifted = torque.copy()
        lifted[end] = 0.0
        assert grasped_load(lifted, *given) == grasped_load(torque, *given)
        lifted[inside] = 0.0
        assert grasped_load(lifted, *given) != grasped_load(torque, *given)


@pytest.mark.parametrize(("share", "told"), [(0.04, True), (0.06, False)])
def test_a_weight_explains_all_but_a_twentieth(ur5: Robot, share: float, told: bool) -> None:
    """Of the squared torque; the rest, of joint 6, turns with every sample as no weight does."""
    states = motion(8.0, 4)
    torque = weight(ur5, states, Payload(mass=3.0, center_of_mass=(0, 0, 0.05)))
    deviation = np.full(6, 0.1)  # Nm: the weight is far above
    edge = round(0.5 / PERIOD)
    power = (torque[edge:-edge] ** 2).sum() / len(torque[edge:-edge])
    torque[:, 5] += np.sqrt(share / (1 - share) * power) * (-1.0) ** np.arange(len(torque))
    load = grasped_load(torque, per_load(ur5, states), deviation, PERIOD)
    assert (load is not None) == told


def test_a_load_is_by_least_squares_with_a_prior_of_its_lever(ur5: Robot) -> None:
    """First moments of 0 ± 0.15 m times the mass, which weigh a hundredth of the samples; the
    error by what an offset of each joint moves it, beside three per cent of the gears."""
    states = motion(8.0, 6)
    torque = weight(ur5, states, Payload(mass=3.0, center_of_mass=(0.3, 0.2, 0.4)))
    torque += noise(len(torque), 6, scale=0.1)
    load = grasped_load(torque, per_load(ur5, states), DEVIATION, PERIOD)
    assert load is not None
    edge = round(0.5 / PERIOD)
    columns = (-per_load(ur5, states) / DEVIATION[:, None])[edge:-edge]
    rows, seen = columns.reshape(-1, 4), (torque / DEVIATION)[edge:-edge]
    alone = np.linalg.lstsq(rows[:, :1], seen.ravel(), rcond=None)[0][0]
    prior = 0.1 * np.sqrt(len(seen)) / (0.15 * alone) * np.eye(4)[1:]

    def solved(values: np.ndarray) -> float:
        both = np.concatenate([values.ravel(), np.zeros(3)])
        return np.linalg.lstsq(np.concatenate([rows, prior]), both, rcond=None)[0][0]

    assert load.mass == pytest.approx(solved(seen))
    moved = [solved(seen + np.eye(6)[joint]) - solved(seen) for joint in range(6)]
    assert load.std_error == pytest.approx(np.hypot(np.linalg.norm(moved), 0.03 * load.mass))


def test_a_load_is_three_times_its_error(ur5: Robot) -> None:
    """However sure the joints are: the faintest of those named is hardly more."""
    states = motion(8.0, 6)
    torque = weight(ur5, states, Payload(mass=1.0, center_of_mass=(0, 0, 0.05)))
    scales = np.geomspace(0.1, 100, 60)
    given = torque, per_load(ur5, states)
    loads = [grasped_load(*given, scale * DEVIATION, PERIOD) for scale in scales]
    ratios = [load.mass / load.std_error for load in loads if load]
    assert 0 < len(ratios) < len(scales)
    assert 3 < min(ratios) < 3.4


def test_missing_samples_are_left_out(ur5: Robot) -> None:
    states = motion(8.0, 1)
    torque = weight(ur5, states, Payload(mass=2.0, center_of_mass=(0, 0, 0.05)))
    given = per_load(ur5, states), DEVIATION, PERIOD
    holes = torque.copy()
    holes[100:150] = np.nan
    load, again = grasped_load(torque, *given), grasped_load(holes, *given)
    assert load is not None
    assert again is not None
    assert again.mass == pytest.approx(load.mass, rel=0.01)
    assert grasped_load(np.full_like(torque, np.nan), *given) is None
