"""What a controller would state of a UR5 with made-up friction, and the live estimator's file."""

from typing import Any

import numpy as np

from tests.rubbing_arm import CONSTANT, FRICTION, HELD, OFFSET, friction, robot
from ur5lib.force.contact_place import jacobian_at
from ur5lib.records.measured import Measured
from ur5lib.robots import newton_euler
from ur5lib.robots.friction import friction_direction
from ur5lib.timeseries.arrays import Array
from ur5lib.topics.live.live import FORMAT, STATES, Live
from ur5lib.topics.live.live_file import CONSTANTS, numbers

PERIOD = 0.008  # s
SLOW = 0.02  # rad/s, of the dead zone
POSTURE = np.array([0.3, -1.2, 1.4, -0.9, 1.1, 0.2])


def arm_file(noise: float = 0.3, **constants: float) -> dict[str, Any]:
    """Return the arm's file; noise: [Nm] in all states."""
    arm = robot()
    std = {state: [noise] * 6 for state in STATES}
    lost = {state: [0.0] * 6 for state in STATES}
    return numbers(arm, friction(arm), "", None) | {
        "format": FORMAT,
        "speed": [2.0] * 6,
        "noise": {"std": std, "absorbed": lost, "hidden": lost, "shift": 1e-4},
        "threshold": {"log_odds": 3.0, "before_flange": 3.0},
        "constants": CONSTANTS | {"period": PERIOD, "doubt": 1.1, "quiet": [1.0]} | constants,
    }


def exported(input: str = "current", **changed: Any) -> dict[str, Any]:
    """Return the arm's file as it is exported, with the kind of its efforts."""
    arm = arm_file() | changed
    own = {"input": input, "motor_constant": CONSTANT.tolist()}
    if input != "current":
        own["torque_constant"] = [1.0] * 6
        own["current"] = (CONSTANT * arm["current"]).tolist()
    return arm | own


def efforts_of(run: Measured, input: str) -> Array:
    """Return the efforts (N, n) of a run in amperes as a controller of another kind states them."""
    torque = CONSTANT * run.current
    gravity = Live(arm_file()).sweep(run.q, 0 * run.q).gravity
    kinds = {"current": run.current, "torque": torque, "torque_less_gravity": torque - gravity}
    return kinds[input]


def samples(
    seconds: float, moving: bool, wrench: Any = None, noise: float = 0.1, link: int = 6
) -> Measured:
    """Return what the controller states of a motion, or of a rest after a motion of 2 s.

    wrench: a function from time (N,) to the wrench (N, 6) on the arm, at the end of a link, None
    for none; noise: of the motors' torque [Nm].
    """
    time = PERIOD * np.arange(round(seconds / PERIOD))
    # an even rate, or one that goes to zero within half a second
    part = 0.0 * time if moving else np.clip((time - 1.5) / 0.5, 0.0, 1.0)
    rate = 0.35 * (1 + np.cos(np.pi * part))[:, None]
    change = -0.35 * np.pi / 0.5 * np.sin(np.pi * part)[:, None]
    turn = np.cumsum(rate, axis=0) * PERIOD
    speed = np.array([0.5, 0.6, 0.8, 1.1, 1.3, 1.0])
    angle = speed * turn + np.arange(6)
    q = POSTURE + 0.5 * np.sin(angle)
    qd = 0.5 * speed * rate * np.cos(angle)
    qdd = 0.5 * (speed * change * np.cos(angle) - (speed * rate) ** 2 * np.sin(angle))
    arm = robot()
    load = newton_euler.torque(arm, arm.fullest_model(), q, qd, qdd)
    if wrench is not None:
        estimator = Live(arm_file())
        swept = estimator.sweep(q, qd)
        jacobians = jacobian_at(swept.jacobian, swept.frames[:, link])
        jacobians[..., link:] = 0.0
        load = load - (jacobians.mT @ wrench(time)[..., None])[..., 0]
    random, segment = np.random.default_rng(0), np.zeros(len(time), int)
    z = np.stack([friction_direction(one, segment) for one in q.T], axis=1)
    coulomb, viscous, by_load, root = FRICTION
    rubs = coulomb * z + viscous * qd + root * np.sqrt(np.abs(qd)) * np.sign(qd)
    rubs += HELD * z * (1 - np.abs(np.tanh(qd / SLOW))) + by_load * z * np.abs(load)
    motor = load + rubs + OFFSET + noise * random.normal(size=q.shape)
    return Measured(time, PERIOD, q, qd, motor / CONSTANT)


def push(start: float, end: float, *force: float) -> Any:
    """Return a force [N] between two times [s], as a function of time."""

    def wrench(time: Array) -> Array:
        inside = (time >= start) & (time < end)
        return inside[:, None] * np.array([*force, 0.0, 0.0, 0.0])

    return wrench


def hostile(run: Measured, seed: int) -> list[tuple[Any, Any, Any, Any]]:
    """Return a stream with gaps, repeats, jumps of the clock, NaN, flipped signs, and silence."""
    random = np.random.default_rng(seed)
    shift, stream = 0.0, []
    for time, *values in zip(run.time, run.q, run.qd, run.current, strict=True):
        shift += random.choice([0.0, 0.05, 0.5, 30.0, -30.0, -0.01], p=[0.97, *[0.006] * 5])
        q, qd, current = (np.array(one) for one in values)
        fault = random.choice(9, p=[0.8, *[0.025] * 8])
        if fault == 1:
            continue
        if fault == 2:
            stream.append((time + shift, q, qd, current))
        if fault in (3, 4, 5):
            (q, qd, current)[fault - 3][random.integers(6)] = random.choice([np.nan, np.inf, 1e300])
        if fault in (6, 7):
            (q, current)[fault - 6][:] *= -1
        stream.append((np.nan if fault == 8 else time + shift, q, qd, current))
    return stream
