"""Smoothed motion of simulated recordings: do its bands hold, and what does it gain?

Simulated with friction, noise, quantised positions and delayed velocities, in three kinds of
motion. Printed are the shares of q, q̇, q̈ within their 95 % bands, and the RMSE of q̈ relative to
that of the better of two central differences, of q̇ once and of q twice, each with the zero-phase
Butterworth low-pass whose cut-off is best for the truth, which nobody knows of a real recording.

With an IMU on the flange: the RMSE of the flange's acceleration between 5 and 20 Hz relative to
that without, and the largest error of q where the robot's stream pauses for 0.3 s in motion.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import signal
from scipy.spatial.transform import Rotation

from benchmarks.harness.options import asked
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import flange_kinematics
from ur5lib.smoothing.encoders import SmoothedMotion, smooth_encoders
from ur5lib.smoothing.imu_fusion import LinearImu, linearise_imu, smooth_with_imu
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.plan import Imu, SimulatedRecording
from ur5lib.stand.rig import STEP, perform
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.metrics import NORMAL95

SEEDS, PERIOD = 20, 0.008  # s
POSTURE = np.array([0.5, -1.6, 1.6, -1.5, 1.5, 0.3])
KINDS = ("moves", "moves with pauses", "Fourier series")
ORDER, CUTOFFS = 4, np.geomspace(0.5, 50, 60)
BAND = signal.butter(ORDER, [5, 20], "bandpass", fs=1 / PERIOD, output="sos")
PAUSE = 38  # samples: 0.3 s
ROBOT = load_robot(robot_path("ur5"))
IMU_NOISE = np.repeat([0.014, 0.007], 3)  # m/s², rad/s
IMU_BIAS = np.array([0.03, -0.02, 0.04, -0.031, 0.024, 0.027])


class Simulated(NamedTuple):
    """Measured q and q̇ (N, 6), the true q, q̇, q̈ (N, 18), and an IMU's readings (N, 6)."""

    q: Array
    qd: Array
    truth: Array
    imu: Array


def main() -> None:
    """Print coverage and gain of each kind of motion."""
    seeds, quick = asked(__doc__, SEEDS)
    seconds = 6.0 if quick else 20.0
    print("kind; within the 95 % band: q, qd, qdd [%], in motion, at rest; RMSE of qdd by joint")
    for kind in KINDS:
        recordings = [simulated(kind, seed, seconds) for seed in range(seeds)]
        runs = [judged(own) for own in recordings]
        moving, resting, ratios = (np.nanmean(part, axis=0) for part in zip(*runs, strict=True))
        print(f"{kind:>18}  {100 * moving.round(3)}  {100 * resting.round(3)}  {ratios.round(2)}")
        shaken, bridged, alone = np.median([with_imu(own) for own in recordings], axis=0)
        print(f"{'with an IMU':>18}  5 to 20 Hz: {shaken:.2f} of the RMSE without")
        print(f"{'':>18}  0.3 s bridged within {1e3 * bridged:.2f} mrad, without {1e3 * alone:.2f}")


def with_imu(own: Simulated) -> tuple[float, float, float]:
    """Return the RMSE of the acceleration with an IMU relative to that without, from 5 to 20 Hz,
    and the largest errors of q [rad] in a pause of the robot's stream, with and without it.
    """
    both, alone = fused(own)
    _, _, J = flange_kinematics(ROBOT, own.q.copy())
    shaken = [
        signal.sosfiltfilt(BAND, np.matvec(J[:, :3], motion.qdd - own.truth[:, 12:]), axis=0)
        for motion in (both, alone)
    ]
    # the pause begins at the highest speed
    first = int(np.argmax(np.abs(own.truth[PAUSE:-PAUSE, 6:12]).sum(axis=1)))
    pause = slice(first, first + PAUSE)
    q, qd = own.q.copy(), own.qd.copy()
    q[pause] = qd[pause] = np.nan
    motions = fused(own._replace(q=q, qd=qd))
    worst = [float(np.abs((m.q - own.truth[:, :6])[pause]).max()) for m in motions]
    ratio = np.linalg.norm(shaken[0]) / np.linalg.norm(shaken[1])
    return float(ratio), worst[0], worst[1]


def fused(own: Simulated) -> tuple[SmoothedMotion, SmoothedMotion]:
    """Return the motion from encoders and IMU, and from encoders alone.

    The IMU's mounting is known, its biases are not.
    """
    assert ROBOT.mounting is not None
    samples = *clock(len(own.q)), own.q, own.qd
    encoders = smooth_encoders(*samples)
    rotation, _, J = flange_kinematics(ROBOT, encoders.q.copy())
    point, up = np.array(ROBOT.mounting.imu), -np.array(ROBOT.gravity)
    axes = Rotation.from_rotvec(Imu().mounting_deg, degrees=True).as_matrix()

    def model(rows: slice) -> LinearImu:
        return linearise_imu(rotation[rows], J[rows], encoders.qd[rows], point, axes, up)

    return smooth_with_imu(*samples, own.imu, model, encoders.known()), encoders


def judged(own: Simulated) -> tuple[Array, Array, Array]:
    """Return the shares (3,) within bands in motion and at rest, and the RMSE's ratios (6,)."""
    motion = smooth_encoders(*clock(len(own.q)), own.q, own.qd)
    moving = np.abs(own.truth[:, 6:12]) > 1e-3
    return covered(motion, own, moving), covered(motion, own, ~moving), gain(motion, own)


def covered(motion: SmoothedMotion, own: Simulated, where: Mask) -> Array:
    """Return the shares of q, q̇, q̈ (3,) within their bands, of joints and samples chosen (N, 6)."""
    inside = np.abs(motion.state - own.truth) <= NORMAL95 * motion.std
    chosen = np.where(np.tile(where, 3), inside, np.nan).reshape(len(where), 3, 6)
    return np.nanmean(chosen, axis=(0, 2)) if where.any() else np.full(3, np.nan)


def gain(motion: SmoothedMotion, own: Simulated) -> Array:
    """Return the RMSE of q̈ of each joint relative to that of the best differences (6,)."""
    qdd = own.truth[:, 12:]
    rivals = [np.gradient(own.qd, PERIOD, axis=0)]
    rivals += [np.gradient(np.gradient(own.q, PERIOD, axis=0), PERIOD, axis=0)]
    best = np.min([rmse(smooth - qdd) for rival in rivals for smooth in lowpassed(rival)], axis=0)
    return rmse(motion.qdd - qdd) / best


def lowpassed(values: Array) -> Iterator[Array]:
    """Yield the values after low-passes with all cut-offs."""
    for cutoff in CUTOFFS:
        yield signal.sosfiltfilt(
            signal.butter(ORDER, cutoff, fs=1 / PERIOD, output="sos"), values, axis=0
        )


def rmse(errors: Array) -> Array:
    """Return the root mean square of each column."""
    return np.sqrt(np.mean(errors**2, axis=0))


def clock(count: int) -> tuple[Array, Labels]:
    """Return times [s] and labels of a recording without gaps."""
    return np.arange(float(count)) * PERIOD, np.zeros(count, np.int64)


def simulated(kind: str, seed: int, seconds: float) -> Simulated:
    """Return the measurements of a UR5 on the virtual stand, and the truth."""
    random = np.random.default_rng([seed, KINDS.index(kind)])
    plan = SimulatedRecording.model_validate(
        {"seed": seed, "seconds": seconds, "trajectory": trajectory(kind, seed, random)}
    )
    experiment = perform(ROBOT, plan, random)
    sent = frames(experiment, PERIOD, random)
    every = slice(None, None, round(PERIOD / STEP))
    # the engine's velocities are half a step late: true ones are derivatives of positions
    motion = experiment.motion
    true_q = motion["q"]
    true_qd = np.gradient(true_q, STEP, axis=0)
    true_qdd = np.gradient(true_qd, STEP, axis=0)
    truth = np.hstack([true_q, true_qd, true_qdd])[every]
    q, qd = (sent.filter(regex=f"^{name}_\\d$").to_numpy() for name in ("actual_q", "actual_qd"))
    imu = motion["imu"][every] + IMU_BIAS + IMU_NOISE * random.normal(size=q.shape)
    return Simulated(q, qd, truth, imu)


def trajectory(kind: str, seed: int, random: np.random.Generator) -> dict[str, object]:
    """Return the plan of a motion."""
    if kind == "Fourier series":
        return {"kind": "fourier", "draw": seed}
    points = POSTURE + random.uniform(-0.6, 0.6, (8, 6))
    pause = 0.8 if kind == "moves with pauses" else 0.0
    return {"kind": "movej", "way_points": points.tolist(), "pause_s": pause}


if __name__ == "__main__":
    main()
