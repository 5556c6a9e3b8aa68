"""What a study may ask of the virtual test stand: the plan of one simulated recording."""

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, ConfigDict, Discriminator, Field, Tag

from ur5lib.robots.description import Payload, PerJoint, Positive, Vector3
from ur5lib.strict import Strict, existing_file

POSTURE = (0.5, -1.6, 1.6, -1.5, 1.5, 0.3)  # rad; elbow up, far from singularities

Share = Annotated[float, Field(ge=0, le=0.5)]
NotNegative = Annotated[float, Field(ge=0)]
Stiffness = Annotated[float, Field(gt=0, le=50_000)]  # steps of 1 ms are short enough for these
Damping = Annotated[float, Field(ge=0, le=500)]


def _direction(vector: Vector3) -> Vector3:
    if not any(vector):
        raise ValueError("a direction: not three zeros")
    return vector


def _list_or_file(value: Any) -> str:
    """As what way-points are given: the JSON type, so that an error is about that alone."""
    return "string" if isinstance(value, str) else "array"


class Planned(Strict):
    """A part of a plan: its numbers are finite."""

    model_config = ConfigDict(allow_inf_nan=False)


class Movej(Planned):
    """From way-point to way-point with trapezoidal speed, all joints in step, as URScript moves.

    After the last way-point comes the first again.
    """

    kind: Literal["movej"]
    way_points: Annotated[
        Annotated[list[PerJoint], Field(min_length=2), Tag("array")]
        | Annotated[str, AfterValidator(existing_file), Tag("string")],
        Discriminator(_list_or_file),
    ] = Field(description="[rad]; or a text file with one movej([six angles]) per line")
    speed_rad_s: float = Field(1.05, gt=0, le=6.3, description="of the joint that leads")
    acceleration_rad_s2: float = Field(1.4, gt=0, le=40, description="of the joint that leads")
    pause_s: float = Field(0.0, ge=0, description="wait at each way-point")


class Fourier(Planned):
    """A sum of random sines about a posture, for excitation, within the joints' limits."""

    kind: Literal["fourier"]
    draw: int = Field(1, ge=0, description="which random coefficients; noise has its own seed")
    posture: PerJoint = Field(POSTURE, description="[rad], where it starts")
    amplitude_rad: float = Field(0.7, gt=0, le=3.1, description="largest way from the posture")
    period_s: float = Field(10.0, gt=0, le=100)
    harmonics: int = Field(5, ge=4, le=20, description="the highest turns so often in a period")
    limit_share: float = Field(0.5, gt=0, le=1, description="of the limits of speed, acceleration")


class Standstill(Planned):
    """The arm holds a posture."""

    kind: Literal["standstill"]
    posture: PerJoint = Field(POSTURE, description="[rad]")


Trajectory = Annotated[Movej | Fourier | Standstill, Field(discriminator="kind")]


class OnArm(Planned):
    """Where something touches the arm."""

    link: int = Field(6, ge=1, le=6, description="6 is what lies beyond the force sensor")
    point: Vector3 = Field((0.0, 0.0, 0.08), description="in the frame of that link [m]")


class Timed(OnArm):
    """A contact that comes and goes."""

    start_s: NotNegative = Field(description="after the start of the recording")
    seconds: Positive = 2.0


class Push(Timed):
    """A force that swells and ebbs like the square of a sine."""

    kind: Literal["push"]
    force: Vector3 = Field(description="its largest value, base axes [N]")


class Hand(Timed):
    """A hand: soft, it follows the arm and leans to one side of it.

    A spring and damper to a place that follows the point with a lag and is displaced from it.
    """

    kind: Literal["hand"]
    displacement: Vector3 = Field(description="how far it leans at most, base axes [m]")
    stiffness_n_m: Stiffness = 400.0
    damping_ns_m: Damping = 20.0
    lag_s: float = Field(0.1, gt=0.001, description="how late the hand follows")


class Spring(Timed):
    """A spring and damper to where the point was when it was hooked on, drawn away from there."""

    kind: Literal["spring"]
    displacement: Vector3 = Field((0.0, 0.0, 0.0), description="of its far end, base axes [m]")
    stiffness_n_m: Stiffness = 500.0
    damping_ns_m: Damping = 10.0


class Wall(OnArm):
    """An elastic wall without friction that the point cannot pass."""

    kind: Literal["wall"]
    through: Vector3 = Field(description="a point of its surface, base frame [m]")
    normal: Annotated[Vector3, AfterValidator(_direction)] = Field(
        description="out of the wall, base axes"
    )
    stiffness_n_m: Stiffness = 5000.0
    damping_ns_m: Damping = 100.0


class Load(Timed):
    """A mass that is grasped, held and put down: its weight and inertia act at the point."""

    kind: Literal["load"]
    mass: float = Field(gt=0, le=20, description="[kg]")


Contact = Annotated[Push | Hand | Spring | Wall | Load, Field(discriminator="kind")]


class Clock(Planned):
    """A device's clock: t_robot = offset + (1 + drift) t_device, from its first sample on."""

    offset_s: float = Field(ge=0, le=1, description="when it took its first sample")
    drift_ppm: float = Field(description="negative: it runs fast")
    jitter_s: NotNegative = Field(description="standard deviation of a stamp")
    stamp_error_s: float = Field(0.0, description="how much later its start stamp says it began")


class ForceSensor(Planned):
    """A force sensor between flange and tool; it reads the force of the hand on the arm."""

    bias: PerJoint = Field(
        (-5.0, 1.8, -1.0, 0.07, 0.43, -0.11), description="force, torque, sensor axes [N, Nm]"
    )
    saturation_n: Positive | None = Field(None, description="the largest force that it can tell")
    clock: Clock = Clock(offset_s=0.006, drift_ppm=20, jitter_s=7e-5)


class Imu(Planned):
    """An accelerometer, gyroscope and magnetometer on the flange."""

    gyroscope_bias: Vector3 = Field((-0.031, 0.024, 0.027), description="IMU axes [rad/s]")
    accelerometer_bias: Vector3 = Field((0.03, -0.02, 0.04), description="IMU axes [m/s²]")
    mounting_deg: Vector3 = Field(
        (-0.5, -0.1, 0.1), description="rotation vector that turns frame 6 into the IMU's"
    )
    clock: Clock = Clock(offset_s=0.02, drift_ppm=-3000, jitter_s=1e-4, stamp_error_s=-0.08)


class Faults(Planned):
    """What goes wrong while recording."""

    late_packets: bool = Field(
        False, description="while the arm moves, every third packet of the stream comes late, the "
        "next in two parts (Figure 4.4)"
    )  # fmt: skip
    lost_frames: Share = Field(0.0, description="share of frames that never come")
    cut_frames: Share = Field(0.0, description="share of the stream's messages that end early")
    stale_stamps: Share = Field(0.0, description="share of frames under the stamp before")
    stale_frames: Share = Field(0.0, description="share of frames with the data before")
    torn_files: bool = Field(False, description="files end where the last full buffer ended")
    stale_imu: bool = Field(False, description="the IMU's file is that of another run")


class SimulatedRecording(Planned):
    """One recording of the virtual test stand."""

    trajectory: Trajectory
    seconds: float = Field(20.0, gt=1, le=600)
    seed: int = Field(0, ge=0, description="of the noise, and of which frames faults hit")
    model: str | None = Field(None, description="the true link model; by default the arm's last")
    payload: Payload | None = Field(
        None,
        description="beyond the force sensor, and known: the controller is told of it where its "
        "format says so (rtde-csv), else the recording's `payload` is this one",
    )
    undeclared_payload: Payload | None = Field(
        None, description="beyond the force sensor, and known to nobody"
    )
    friction: bool = Field(True, description="whether the joints have friction")
    noise: bool = Field(True, description="whether what is measured has noise")
    contacts: list[Contact] = Field(default=[], description="what touches the arm")
    force_sensor: ForceSensor | None = None
    imu: Imu | None = None
    faults: Faults = Faults()
