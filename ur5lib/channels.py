"""The channels of recordings, under RTDE's names: unit, columns, and the largest possible value."""

import math
import re
from collections.abc import Collection, Container
from difflib import get_close_matches
from functools import lru_cache
from typing import NamedTuple, Self

SIX_SUFFIXES = tuple(f"_{index}" for index in range(6))
MOST_JOINTS = 8
AXIS_SUFFIXES = ("x", "y", "z")
UNUSED_CHANNELS = (
    "actual_robot_braking_energy_dissipated",
    "actual_robot_energy_consumed",
    "analog_io_types",
    r"encoder[01]_raw",
    r"euromap67_(input_bits|output_bits|24V_voltage|24V_current)",
    r"input_(bit_registers\d+_to_\d+|(bit|int|double)_register_\d+)",
    "io_current",
    r"output_(bit_registers\d+_to_\d+|(bit|int|double)_register_\d+)",
    "script_control_line",
    r"standard_analog_(in|out)put[01]",
    "time_scale_source",
    r"tool_analog_input(_types|[01])",
    r"tool_(mode|output_mode|digital_output[01]_mode)",
    r"tool_(output_voltage|output_current|temperature)",
)


class ChannelSpec(NamedTuple):
    """A channel in SI units.

    suffixes: of its columns, empty for a single column; bound: a magnitude that no Universal Robots
    arm can exceed; of_joints: whether it has a column for each joint (six, unless the recording or
    its arm has another number), rather than for each component of a pose or wrench.
    """

    unit: str
    suffixes: tuple[str, ...] = ("",)
    bound: float = math.inf
    of_joints: bool = False

    @classmethod
    def by_joint(cls, unit: str, bound: float = math.inf) -> Self:
        """Return a channel with a column for each joint."""
        return cls(unit, SIX_SUFFIXES, bound, of_joints=True)


CHANNELS = {
    "time": ChannelSpec("s"),
    "segment": ChannelSpec("1"),
    "interpolated": ChannelSpec("1"),
    "filled": ChannelSpec("1"),
    "received": ChannelSpec("s"),
    "unknown_unit": ChannelSpec("1"),  # of a table in which the unit of the efforts is unknown
    "actual_q": ChannelSpec.by_joint("rad", 4 * math.pi),
    "target_q": ChannelSpec.by_joint("rad", 4 * math.pi),
    "actual_qd": ChannelSpec.by_joint("rad/s", 20.0),
    "target_qd": ChannelSpec.by_joint("rad/s", 20.0),
    "target_qdd": ChannelSpec.by_joint("rad/s2", 200.0),
    "actual_current": ChannelSpec.by_joint("A", 60.0),
    "actual_current_as_torque": ChannelSpec.by_joint("Nm", 1000.0),
    "actual_torque": ChannelSpec.by_joint("Nm", 1000.0),  # of joints that sense it, not RTDE
    "actual_torque_less_gravity": ChannelSpec.by_joint(
        "Nm", 1000.0
    ),  # as some drivers write, not RTDE
    "target_current": ChannelSpec.by_joint("A", 60.0),
    "target_moment": ChannelSpec.by_joint("Nm", 1000.0),
    "joint_control_output": ChannelSpec.by_joint("A"),
    "joint_temperatures": ChannelSpec.by_joint("degC"),
    "actual_joint_voltage": ChannelSpec.by_joint("V"),
    "actual_current_window": ChannelSpec("A"),
    "joint_mode": ChannelSpec("1"),
    "actual_TCP_force": ChannelSpec("N, Nm", SIX_SUFFIXES, 5000.0),
    "actual_TCP_speed": ChannelSpec("m/s, rad/s", SIX_SUFFIXES, 50.0),
    "actual_TCP_pose": ChannelSpec("m, rad", SIX_SUFFIXES, 20.0),
    "target_TCP_pose": ChannelSpec("m, rad", SIX_SUFFIXES),
    "target_TCP_speed": ChannelSpec("m/s, rad/s", SIX_SUFFIXES),
    "ft_raw_wrench": ChannelSpec("N, Nm", SIX_SUFFIXES),
    "wrench_calc_from_currents": ChannelSpec("N, Nm", SIX_SUFFIXES, 5000.0),
    "tcp_force_scalar": ChannelSpec("N"),
    "tcp_offset": ChannelSpec("m, rad", SIX_SUFFIXES),
    "payload": ChannelSpec("kg"),
    "payload_cog": ChannelSpec("m", SIX_SUFFIXES[:3]),
    "payload_inertia": ChannelSpec("kg m2", SIX_SUFFIXES),
    "target_gravity": ChannelSpec("m/s2", SIX_SUFFIXES[:3], 50.0),
    "target_base_acceleration": ChannelSpec("m/s2, rad/s2", SIX_SUFFIXES),
    "collision_detection_ratio": ChannelSpec("1"),
    "joint_position_deviation_ratio": ChannelSpec("1"),
    "actual_tool_accelerometer": ChannelSpec("m/s2", SIX_SUFFIXES[:3]),
    "elbow_position": ChannelSpec("m", SIX_SUFFIXES[:3]),
    "elbow_velocity": ChannelSpec("m/s", SIX_SUFFIXES[:3]),
    "actual_execution_time": ChannelSpec("s"),
    "actual_main_voltage": ChannelSpec("V"),
    "actual_robot_voltage": ChannelSpec("V"),
    "actual_robot_current": ChannelSpec("A"),
    "actual_momentum": ChannelSpec("kg m/s"),
    "actual_digital_input_bits": ChannelSpec("1"),
    "actual_digital_output_bits": ChannelSpec("1"),
    "robot_mode": ChannelSpec("1"),
    "robot_status_bits": ChannelSpec("1"),
    "runtime_state": ChannelSpec("1"),
    "safety_mode": ChannelSpec("1"),
    "safety_status": ChannelSpec("1"),
    "safety_status_bits": ChannelSpec("1"),
    "speed_scaling": ChannelSpec("1"),
    "target_speed_fraction": ChannelSpec("1"),
    "ft": ChannelSpec("N, Nm", ("_fx", "_fy", "_fz", "_tx", "_ty", "_tz")),
    "ft_f": ChannelSpec("N", AXIS_SUFFIXES, 5000.0),
    "ft_t": ChannelSpec("Nm", AXIS_SUFFIXES, 1000.0),
    "imu_a": ChannelSpec("m/s2", AXIS_SUFFIXES, 500.0),
    "imu_g": ChannelSpec("rad/s", AXIS_SUFFIXES, 50.0),
    "imu_m": ChannelSpec("1", AXIS_SUFFIXES),
}
THESIS_FILES = {  # by the part after log_ in names of the thesis's files: RTDE name
    "q_actual": "actual_q",
    "qd_actual": "actual_qd",
    "i_actual": "actual_current",
    "q_target": "target_q",
    "qd_target": "target_qd",
    "qdd_target": "target_qdd",
    "i_target": "target_current",
    "m_target": "target_moment",
    "tcp_force": "actual_TCP_force",
    "tcp_speed": "actual_TCP_speed",
    "tool_vector": "actual_TCP_pose",
}
SENSED_TORQUE = "actual_torque"
MEASURED_CURRENT, TARGET_CURRENT = CURRENTS = ("actual_current", "target_current")


class Effort(NamedTuple):
    """The measured effort of an arm's joints: the motors' currents, or torques.

    channel: name of the channel with the measured efforts; constant: name of the factor from effort
    to joint torque.
    """

    quantity: str
    channel: str
    unit: str
    constant: str
    constant_unit: str

    @classmethod
    def measured_in(cls, names: Container[str]) -> "Effort":
        """Return the effort of a table with these columns: torques if it has them, or currents."""
        return TORQUE if f"{TORQUE.channel}_0" in names else CURRENT

    def parameter(self, name: str) -> str:
        """Return a fitted parameter's name in tables: "gain" for the torque constant of torques."""
        return self.constant.replace(" ", "_") if name == "torque_constant" else name


CURRENT = Effort("current", MEASURED_CURRENT, "A", "torque constant", "Nm/A")
TORQUE = Effort("torque", SENSED_TORQUE, "Nm", "gain", "Nm/Nm")
EFFORTS = {own.quantity: own for own in (CURRENT, TORQUE)}
EFFORT_CHANNELS = (*CURRENTS, SENSED_TORQUE)
MEASURED_EFFORTS = (MEASURED_CURRENT, SENSED_TORQUE, "actual_current_as_torque")
UNKNOWN_UNIT = "unknown_unit"
INTERNAL_CHANNELS = ("segment", "interpolated", "filled", "received", UNKNOWN_UNIT)  # of frames
RECORDED_CHANNELS = {name: spec for name, spec in CHANNELS.items() if name not in INTERNAL_CHANNELS}
SUFFIXES = {name: spec.suffixes for name, spec in CHANNELS.items() if len(spec.suffixes) > 1}
JOINT_CHANNELS = [name for name, spec in CHANNELS.items() if spec.of_joints]
JOINT_COLUMNS = {f"{name}_{k}" for name in JOINT_CHANNELS for k in range(MOST_JOINTS)}
SIGNED_CHANNELS = [name for name in JOINT_CHANNELS if CHANNELS[name].unit not in ("degC", "V")]


def suffixes(channel: str, joints: int = 6) -> tuple[str, ...]:
    """Return the suffixes of a channel's columns, () for a channel of a single column."""
    if channel in JOINT_CHANNELS:
        return tuple(f"_{index}" for index in range(joints))
    return SUFFIXES.get(channel, ())


def columns(channel: str, joints: int = 6) -> list[str]:
    """Return the names of a channel's columns: actual_q_0 .. actual_q_5, or its own name."""
    return [channel + suffix for suffix in suffixes(channel, joints) or ("",)]


def units_of(*channels: str) -> dict[str, str]:
    """Return the unit of each column of some channels."""
    return {name: CHANNELS[channel].unit for channel in channels for name in columns(channel)}


def joint_count(names: Collection[str]) -> int:
    """Return the number of joints in the widest channel of a recording with these columns."""
    places = range(MOST_JOINTS)
    every = (k + 1 for name in JOINT_CHANNELS for k in places if f"{name}_{k}" in names)
    return max(every, default=0)


@lru_cache(maxsize=1000)  # recordings share most names
def channels_of(column: str) -> tuple[str, ...]:
    """Return the channels to which a column may belong by its name."""
    return tuple(name for name in CHANNELS if re.match(rf"{name}(_|[xyz]?$)", column))


def meant(column: str) -> str | None:
    """Return the channel with the correct spelling of a column's name, None if there is none.

    A longer name, as `actual_qdd`, is another quantity and no misspelling, except for a plural.
    """
    if channels_of(column):
        return None
    name = re.sub(r"_\d$", "", column.lower()).rstrip("s")
    by_lower_case = {channel.lower(): channel for channel in RECORDED_CHANNELS}
    near = get_close_matches(name, by_lower_case, cutoff=0.85)
    return next((by_lower_case[n] for n in near if n == name or not name.startswith(n)), None)


def is_unused(column: str) -> bool:
    """Return whether a column is an output of RTDE that is not used here."""
    return re.fullmatch("|".join(UNUSED_CHANNELS), column) is not None
