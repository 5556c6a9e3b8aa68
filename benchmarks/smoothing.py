"""Filter and smoother side by side in one run: this library, and plain loops around filterpy.

Joints and IMU, 10,000 samples, the same noise for all. The loops compute the kinematics of one
sample at a time, with this library's functions and with Pinocchio's, the fastest there is.
"""

import statistics
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pinocchio
import torch
from filterpy.kalman import ExtendedKalmanFilter

from benchmarks.harness.options import options_of
from benchmarks.harness.timing import timed
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import jacobian, link_frames
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.smoothing.encoders import encoder_system
from ur5lib.smoothing.imu_fusion import (
    ALL_STATES,
    OUTPUTS_FROM_STATES,
    LinearImu,
    add_imu,
    linearise_imu,
)
from ur5lib.smoothing.noise import EncoderNoise
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import LinearSystem, System, smooth

SAMPLES, PERIOD, ROUNDS = 10_000, 0.008, 3
IMU_NOISE = np.repeat([0.1, 0.01], 3)  # m/s², rad/s

Kinematics = Callable[[Array], tuple[Array, Array]]
"""R6 (N, 3, 3) and J (N, 6, 6) of positions (N, 6)."""


@dataclass(frozen=True)
class Recording:
    """A swinging arm with an IMU: positions, velocities and readings (N, 6)."""

    q: Array
    qd: Array
    readings: Array

    def first(self, count: int) -> "Recording":
        """Return its first samples."""
        return Recording(self.q[:count], self.qd[:count], self.readings[:count])

    @property
    def time(self) -> Array:
        """Return the times of the samples (N,) [s]."""
        return np.arange(float(len(self.q))) * PERIOD

    @property
    def imu_noise(self) -> Array:
        """Return the standard deviations of the readings (N, 6)."""
        return np.tile(IMU_NOISE, (len(self.q), 1))

    def joints(self) -> System:
        """Return the system of motion and encoders."""
        count, ones = len(self.q), np.ones(self.q.shape)
        swing = np.full(6, 2 * np.pi * 17), np.full(6, 0.1)
        noise = EncoderNoise(ones, ones, *swing, 1e-4 * ones, 0.01 * ones, np.full(6, 0.002))
        return encoder_system(self.time, np.zeros(count, np.int64), self.q, self.qd, noise)


def main() -> None:
    """Print the times, their ratios and the differences of the states."""
    quick = options_of(__doc__).parse_args().quick
    torch.set_num_threads(1)
    robot = load_robot(robot_path("ur5"))
    recording = made_up(200 if quick else SAMPLES)
    ours, pin = by_torch(robot), by_pinocchio(robot)
    contenders = {
        "this library": lambda: batched(robot, ours, recording),
        "loop, our kinematics": lambda: looped(robot, ours, recording),
        "loop, Pinocchio": lambda: looped(robot, pin, recording),
    }
    count = 1 if quick else ROUNDS
    print(
        f"{len(recording.q)} samples, {ALL_STATES} states, 18 measurements; "
        f"median of {count} rounds"
    )
    rounds = [{name: timed(run) for name, run in contenders.items()} for _ in range(count)]
    states = rounds[0]["this library"][1]
    for name in contenders:
        seconds = statistics.median(r[name][0] for r in rounds)
        ratio = statistics.median(r[name][0] / r["this library"][0] for r in rounds)
        apart = np.abs(rounds[0][name][1] - states).max()
        print(f"{name:>22}{seconds:>8.2f} s{ratio:>8.1f} x   states apart by {apart:.1e}")
        assert apart < 1e-8


def made_up(samples: int) -> Recording:
    """Return a made-up recording with noise."""
    random = np.random.default_rng(0)
    angle = np.outer(np.arange(samples) * PERIOD, random.uniform(1, 3, 6)) + random.uniform(0, 6, 6)
    q = np.sin(angle) + 1e-4 * random.normal(size=angle.shape)
    qd = np.gradient(np.sin(angle), PERIOD, axis=0) + 0.01 * random.normal(size=angle.shape)
    level = np.array([0, 0, 9.81, 0, 0, 0])
    return Recording(q, qd, level + IMU_NOISE * random.normal(size=angle.shape))


def by_torch(robot: Robot) -> Kinematics:
    """Return this library's kinematics."""
    arm = build_arm(robot, "C")

    def kinematics(q: Array) -> tuple[Array, Array]:
        positions = torch.from_numpy(q)
        return link_frames(arm, positions)[0][:, 6].numpy(), jacobian(arm, positions).numpy()

    return kinematics


def by_pinocchio(robot: Robot) -> Kinematics:
    """Return Pinocchio's kinematics for one sample."""
    model = pinocchio.buildModelFromXML(urdf(robot, rigid_bodies(robot, "C")))
    data = model.createData()
    last = model.njoints - 1
    # Its last joint's frame is not frame 6: the constant transform between, at zero positions.
    R6, J = by_torch(robot)(np.zeros((1, 6)))
    pinocchio.computeJointJacobians(model, data, np.zeros(6))
    turn = data.oMi[last].rotation.T @ R6[0]
    axis = pinocchio.getJointJacobian(model, data, last, pinocchio.LOCAL_WORLD_ALIGNED)
    # J_v of the origin is J_v − [d]× J_w: d by least squares.
    skew = np.vstack([np.cross(np.eye(3), column).T for column in axis[3:].T])
    way = np.linalg.lstsq(skew, (axis[:3] - J[0, :3]).T.ravel(), rcond=None)[0]
    way = data.oMi[last].rotation.T @ way

    def kinematics(q: Array) -> tuple[Array, Array]:
        pinocchio.computeJointJacobians(model, data, q[0])
        J = pinocchio.getJointJacobian(model, data, last, pinocchio.LOCAL_WORLD_ALIGNED)
        rotation = data.oMi[last].rotation
        J[:3] += np.cross(J[3:], (rotation @ way)[:, None], axis=0)
        return (rotation @ turn)[None], J[None]

    return kinematics


def batched(robot: Robot, kinematics: Kinematics, own: Recording) -> Array:
    """Return the states (N, 42) by this library."""

    def model(rows: slice) -> LinearImu:
        return linearised(robot, kinematics, own.q[rows], own.qd[rows])

    system = add_imu(own.joints(), own.time, own.readings, model, own.imu_noise)
    parts = [part.states.mean[:, 0] for part in smooth(system, len(own.q))]
    return np.concatenate(parts[::-1])


def linearised(robot: Robot, kinematics: Kinematics, q: Array, qd: Array) -> LinearImu:
    """Return the IMU's equation at these samples."""
    assert robot.mounting is not None
    point = np.array(robot.mounting.imu)
    return linearise_imu(*kinematics(q), qd, point, np.eye(3), -np.array(robot.gravity))


def looped(robot: Robot, kinematics: Kinematics, own: Recording) -> Array:
    """Return the states (N, 42) by plain loops: sample after sample, then back."""
    start, q, qd = first_two(robot, kinematics, own), own.q, own.qd
    ekf = ExtendedKalmanFilter(ALL_STATES, 18)
    ekf.x = np.zeros(ALL_STATES)
    ekf.P = np.zeros((ALL_STATES, ALL_STATES))
    ekf.R = np.diag(start.R[0])
    steps = []
    for k in range(len(q)):
        model = linearised(robot, kinematics, q[k : k + 1], qd[k : k + 1])
        H = np.vstack([start.H[0, :12], model.H[0] @ OUTPUTS_FROM_STATES])
        ekf.F, ekf.Q = start.F[min(k, 1)], start.Q[min(k, 1)]
        ekf.predict()
        z = np.concatenate([q[k], qd[k], own.readings[k] - model.offset[0]])
        ekf.update(z, lambda _, H=H: H, lambda x, H=H: H @ x)
        steps.append((ekf.x_prior, ekf.P_prior, ekf.x_post, ekf.P_post))
    states = [steps[-1][2]]
    covariance = steps[-1][3]
    for k in range(len(q) - 2, -1, -1):
        x, P = steps[k][2:]
        gain = P @ start.F[1].T @ np.linalg.inv(steps[k + 1][1])
        states.append(x + gain @ (states[-1] - steps[k + 1][0]))
        covariance = P + gain @ (covariance - steps[k + 1][1]) @ gain.T
    return np.array(states[::-1])


def first_two(robot: Robot, kinematics: Kinematics, own: Recording) -> LinearSystem:
    """Return the linear system of the first two samples; the kinematics take one at a time."""
    two, model = own.first(2), linearised(robot, kinematics, own.q[:1], own.qd[:1])
    system = add_imu(two.joints(), two.time, two.readings, lambda _: model, two.imu_noise)
    return LinearSystem(*(values[:, 0] for values in vars(system(slice(None))).values()))


if __name__ == "__main__":
    main()
