"""The plan of one recording of the virtual test stand, as a study requests it."""

from collections.abc import Collection, Iterator
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from ur5lib.channels import MOST_JOINTS
from ur5lib.robots.description import Payload, Positive, Vector3
from ur5lib.stand.layout import SENSOR_COLUMNS
from ur5lib.strict import Strict, existing_file
from ur5lib.timeseries.arrays import Array, Six
from ur5lib.timeseries.profiles import rest_conditions

POSTURE = (0.5, -1.6, 1.6, -1.5, 1.5, 0.3)  # rad; elbow up, far from singularities
REST_TOLERANCE = (
    1e-6  # rad, tolerance of the conditions at the start: rounding of written coefficients
)

Share = Annotated[float, Field(ge=0, le=0.5)]
NotNegative = Annotated[float, Field(ge=0)]
Stiffness = Annotated[float, Field(gt=0, le=50_000)]  # stable at steps of 1 ms
Damping = Annotated[float, Field(ge=0, le=500)]
Joints = tuple[float, ...]  # a number for each joint
Factor = Annotated[float, Field(ge=0.1, le=10)]
Factors = tuple[Factor, ...]


def _direction(vector: Vector3) -> Vector3:
    if not any(vector):
        raise ValueError("a direction, not three zeros")
    return vector


def _list_or_file(value: Any) -> str:
    """Return the JSON type of the way-points, so that errors mention only that type."""
    return "string" if isinstance(value, str) else "array"


class Planned(Strict):
    """A part of a plan, with finite numbers only."""

    model_config = ConfigDict(allow_inf_nan=False)


class Movej(Planned):
    """Moves from way-point to way-point with synchronised trapezoidal speeds, as in URScript.

    The last way-point is followed by the first.
    """

    kind: Literal["movej"]
    way_points: Annotated[
        Annotated[list[Joints], Field(min_length=2), Tag("array")]
        | Annotated[str, AfterValidator(existing_file), Tag("string")],
        Discriminator(_list_or_file),
    ] = Field(
        description="joint angles [rad], or a text file with one movej([six angles]) per line"
    )
    speed_rad_s: float = Field(
        1.05, gt=0, le=6.3, description="speed of the joint with the longest way"
    )
    acceleration_rad_s2: float = Field(
        1.4, gt=0, le=40, description="acceleration of the joint with the longest way"
    )
    pause_s: float = Field(0.0, ge=0, description="pause at each way-point")


class Fourier(Planned):
    """Random Fourier series about a posture, within the joints' limits, for excitation."""

    kind: Literal["fourier"]
    draw: int = Field(
        1, ge=0, description="seed of the random coefficients; noise has its own seed"
    )
    posture: Joints = Field(POSTURE, description="start of the motion, joint angles [rad]")
    amplitude_rad: float = Field(
        0.7, gt=0, le=3.1, description="largest deviation from the posture"
    )
    period_s: float = Field(10.0, gt=0, le=100, description="period of the series")
    harmonics: int = Field(5, ge=4, le=20, description="number of harmonics of 1/period_s")
    limit_share: float = Field(
        0.5, gt=0, le=1, description="share of the speed and acceleration limits that is used"
    )


class Series(Planned):
    """A given Fourier series about a posture, for example one that `ur5 excite` designed.

    It repeats after its period.
    """

    kind: Literal["series"]
    posture: Joints = Field(description="start of the motion, joint angles [rad]")
    period_s: float = Field(gt=0, le=600, description="period of the series")
    coefficients: list[Joints] = Field(
        min_length=8,
        max_length=400,
        description="of each joint [rad]: of the sines of all harmonics of 1/period_s, then of the "
        "cosines; such that the series begins at rest",
    )

    @model_validator(mode="after")
    def _begins_at_rest(self) -> Self:
        if len(self.coefficients) % 2:
            raise ValueError("`coefficients` needs as many lines for cosines as for sines")
        if {*map(len, self.coefficients)} != {len(self.posture)}:
            raise ValueError("in each line of `coefficients` as many numbers as in `posture`")
        conditions = rest_conditions(self.period_s, len(self.coefficients) // 2)
        if np.abs(conditions @ np.array(self.coefficients)).max() > REST_TOLERANCE:
            raise ValueError("`coefficients` of a series that begins at the posture, at rest")
        return self


class Standstill(Planned):
    """The arm stays in a posture."""

    kind: Literal["standstill"]
    posture: Joints = Field(POSTURE, description="joint angles [rad]")


Trajectory = Annotated[Movej | Fourier | Series | Standstill, Field(discriminator="kind")]


class OnArm(Planned):
    """The place where something touches the arm."""

    link: int | None = Field(
        None,
        ge=1,
        le=MOST_JOINTS,
        description="link that is touched; default: the tool, beyond the force sensor, which "
        "belongs to the last link",
    )
    point: Vector3 = Field((0.0, 0.0, 0.08), description="place in the frame of that link [m]")


class Timed(OnArm):
    """A contact with a start and a duration."""

    start_s: NotNegative = Field(description="start, from the start of the recording")
    seconds: Positive = Field(2.0, description="duration")


class Push(Timed):
    """A force that rises and falls like the square of a sine."""

    kind: Literal["push"]
    force: Vector3 = Field(description="largest force, base axes [N]")


class Hand(Timed):
    """A soft hand that follows the arm and pushes to one side.

    A spring and damper to a place that follows the point with a lag, at a displacement from it.
    """

    kind: Literal["hand"]
    displacement: Vector3 = Field(description="largest displacement, base axes [m]")
    stiffness_n_m: Stiffness = 400.0
    damping_ns_m: Damping = 20.0
    lag_s: float = Field(0.1, gt=0.001, description="delay with which the hand follows")


class Spring(Timed):
    """A spring and damper between the point and a far end that moves away."""

    kind: Literal["spring"]
    displacement: Vector3 = Field(
        (0.0, 0.0, 0.0), description="largest displacement of the far end, base axes [m]"
    )
    stiffness_n_m: Stiffness = 500.0
    damping_ns_m: Damping = 10.0


class Wall(OnArm):
    """An elastic wall without friction."""

    kind: Literal["wall"]
    through: Vector3 = Field(description="a point on its surface, base frame [m]")
    normal: Annotated[Vector3, AfterValidator(_direction)] = Field(
        description="direction out of the wall, base axes"
    )
    stiffness_n_m: Stiffness = 5000.0
    damping_ns_m: Damping = 100.0


class Load(Timed):
    """A mass that is grasped, carried and put down; its weight and inertia act at the point."""

    kind: Literal["load"]
    mass: float = Field(gt=0, le=20, description="mass [kg]")


Contact = Annotated[Push | Hand | Spring | Wall | Load, Field(discriminator="kind")]


class Clock(Planned):
    """A device's clock, counted from its first sample: t_robot = offset + (1 + drift) t_device."""

    offset_s: float = Field(ge=0, le=1, description="robot time of the first sample")
    drift_ppm: float = Field(description="drift; negative: the clock runs fast")
    jitter_s: NotNegative = Field(description="standard deviation of a timestamp")
    stamp_error_s: float = Field(0.0, description="error of the start stamp; positive: too late")


class ForceSensor(Planned):
    """A force sensor between flange and tool; reads the force of the environment on the arm."""

    bias: Six = Field(
        (-5.0, 1.8, -1.0, 0.07, 0.43, -0.11),
        description="bias of force and torque, sensor axes [N, Nm]",
    )
    saturation_n: Positive | None = Field(None, description="largest force that it can measure")
    clock: Clock = Clock(offset_s=0.006, drift_ppm=20, jitter_s=7e-5)


class WristSensor(Planned):
    """The force sensor in the wrist of an e-Series arm, which the controller records.

    It reads scale R^T f + bias + drift t, with f the force on the arm in the axes of frame 6.
    """

    bias: Six = Field(
        (3.0, -3.0, 3.0, 0.1, -0.1, 0.1), description="bias of force and torque [N, Nm]"
    )
    drift_per_min: Six = Field(
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), description="drift of the bias [N/min, Nm/min]"
    )
    rotation_deg: Vector3 = Field(
        (0.0, 0.0, 0.0), description="rotation vector from frame 6 to the sensor's axes"
    )
    scale: Positive = Field(1.0, description="factor of all readings")


class Imu(Planned):
    """An accelerometer, gyroscope and magnetometer on the flange."""

    gyroscope_bias: Vector3 = Field((-0.031, 0.024, 0.027), description="bias, IMU axes [rad/s]")
    accelerometer_bias: Vector3 = Field((0.03, -0.02, 0.04), description="bias, IMU axes [m/s²]")
    mounting_deg: Vector3 = Field(
        (-0.5, -0.1, 0.1), description="rotation vector from frame 6 to the IMU's frame"
    )
    clock: Clock = Clock(offset_s=0.02, drift_ppm=-3000, jitter_s=1e-4, stamp_error_s=-0.08)


class Faults(Planned):
    """Faults during the recording."""

    late_packets: bool = Field(
        False, description="while the arm moves, every third packet of the stream is late and the "
        "next one arrives in two parts (Figure 4.4)"
    )  # fmt: skip
    lost_frames: Share = Field(0.0, description="share of frames that are lost")
    cut_frames: Share = Field(0.0, description="share of the stream's messages that are cut short")
    stale_stamps: Share = Field(0.0, description="share of frames with the previous timestamp")
    stale_frames: Share = Field(0.0, description="share of frames with the previous data")
    torn_files: bool = Field(False, description="files lack their last, partly filled buffer")
    stale_imu: bool = Field(False, description="the IMU's file is from another run")


class SimulatedRecording(Planned):
    """One recording of the virtual test stand."""

    trajectory: Trajectory = Field(description="motion of the arm")
    seconds: float = Field(20.0, gt=1, le=600, description="duration")
    seed: int = Field(0, ge=0, description="seed of the noise and of the choice of faulty frames")
    model: str | None = Field(
        None, description="the true link model; default: the last one of the arm"
    )
    payload: Payload | None = Field(
        None,
        description="known payload, beyond the force sensor; declared to the controller where the "
        "format records that (rtde-csv), otherwise the default of the recording's `payload`",
    )
    undeclared_payload: Payload | None = Field(
        None, description="payload beyond the force sensor that is declared nowhere"
    )
    temperature_c: tuple[float, float] = Field(
        (30.0, 30.0), description="of the motors, at the start and at the end [°C]"
    )
    friction: bool = Field(True, description="whether the joints have friction")
    root_friction: bool = Field(
        False,
        description="whether friction also grows with the root of velocity, as on the UR5 of the "
        "thesis",
    )
    varied_friction: bool = Field(
        False,
        description="whether friction varies as on real arms: from recording to recording, from "
        "stop to stop, during a rest, and with the place of loaded gears",
    )
    coulomb_factor: Factors | None = Field(
        None,
        description="each joint's Coulomb friction, relative to the usual one, which the "
        "controller expects; default: 1",
    )
    viscous_factor: Factors | None = Field(
        None,
        description="each joint's viscous friction, relative to the usual one, which the "
        "controller expects; default: 1",
    )
    noise: bool = Field(True, description="whether measurements have noise")
    contacts: list[Contact] = Field(default=[], description="contacts with the arm")
    force_sensor: ForceSensor | None = Field(None, description="force sensor, if any")
    wrist_sensor: WristSensor | None = Field(
        None,
        description="force sensor in the wrist; without it, an arm that has one records zeros",
    )
    imu: Imu | None = Field(None, description="IMU, if any")
    faults: Faults = Field(Faults(), description="faults of the recording")

    def sensors(self) -> list[str]:
        """Return the sensors that write their own files."""
        return [name for name in SENSOR_COLUMNS if getattr(self, name) is not None]

    def temperature(self, time: Array | float) -> Array:
        """Return the motors' temperature [°C] at times [s] since the start."""
        return np.asarray(np.interp(time, [0.0, self.seconds], self.temperature_c))

    def misfits(self, arm: str, joints: int, models: Collection[str]) -> Iterator[str]:
        """Yield sentences on what in the plan does not fit an arm's joints and link models."""
        if self.model is not None and self.model not in models:
            yield f"model` is {self.model!r}; give one of {', '.join(models)}, which {arm} has"
        if joints != 6 and isinstance(getattr(self.trajectory, "way_points", None), str):
            yield f"trajectory.way_points` names a file of six angles a line; {arm} has {joints}"
        for key, numbers in self._numbers_by_joint():
            if len(numbers) != joints:
                yield f"{key}` has {len(numbers)} numbers; {arm} has {joints} joints"
        for k, contact in enumerate(self.contacts):
            if contact.link is not None and contact.link > joints:
                yield f"contacts[{k}].link` is {contact.link}; {arm} has {joints} links"

    def _numbers_by_joint(self) -> Iterator[tuple[str, Joints]]:
        """Yield the keys with a number for each joint, and their numbers."""
        motion = self.trajectory
        if not isinstance(motion, Movej):
            yield "trajectory.posture", motion.posture
        elif not isinstance(motion.way_points, str):
            for k, point in enumerate(motion.way_points):
                yield f"trajectory.way_points[{k}]", point
        for key in ("coulomb_factor", "viscous_factor"):
            if (factors := getattr(self, key)) is not None:
                yield key, factors
