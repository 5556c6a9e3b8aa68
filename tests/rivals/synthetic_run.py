"""A run for the estimators of the benchmark, whose external torque is known."""

import numpy as np

from ur5lib.force.external_torque import joint_states
from ur5lib.force.force_input import Gears
from ur5lib.timeseries.arrays import Array
from ur5rivals.run import Run

PERIOD, COUNT = 0.008, 2500  # s, samples
STIFFNESS = 5000.0  # Nm/rad, of the position loops
INERTIA = np.array([4.0, 4.0, 2.0, 0.5, 0.5, 0.3])  # kg m²


def jacobian(seed: int) -> Array:
    """Return a well-conditioned Jacobian (6, 6)."""
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(6, 6)))
    return np.asarray(rotation)


def synthetic_run(seed: int = 0, push: Array | float = 0.0, noise: float = 0.0) -> Run:
    """Return an arm of constant inertia on sines; push: external torque (N, 6) or (6,) [Nm].

    noise: standard deviation of the friction's error [Nm], white.
    """
    random = np.random.default_rng(seed)
    time = PERIOD * np.arange(COUNT)[:, None]
    speed, phase = random.uniform(1, 3, 6), random.uniform(0, 6, 6)
    q, qd = np.sin(speed * time + phase), speed * np.cos(speed * time + phase)
    qdd = -(speed**2) * q
    error = noise * random.normal(size=(COUNT, 6))
    torque = np.broadcast_to(push, (COUNT, 6)) + error
    friction = 4.0 * np.tanh(qd / 0.1)
    segment = np.zeros(COUNT, int)
    return Run(
        name=f"run_{seed}",
        path=seed,
        period=PERIOD,
        segment=segment,
        states=joint_states(qd, segment, PERIOD, cutoff=2.0),
        q=q,
        qd=qd,
        qdd=qdd,
        model=INERTIA * qdd,
        friction=friction,
        jacobian=np.broadcast_to(jacobian(0), (COUNT, 6, 6)).copy(),
        torque=torque,
        smoothed=torque,
        momentum=INERTIA * qd,
        rate=INERTIA * qdd - torque,
        breakaway=np.ones(6),
        gears=Gears.without_friction(torque),
        position_error=(friction - torque) / STIFFNESS,
    )
