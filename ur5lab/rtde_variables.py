"""Packages, variables and modes of the Real-Time Data Exchange (RTDE).

Source: Universal Robots' guide to RTDE, tables of robot controller outputs and inputs.
"""

import struct
from enum import IntEnum
from itertools import chain

PACKAGE_HEADER = struct.Struct(">HB")  # size and kind of a package
# Kinds of packages.
VERSION_PACKAGE = ord("V")
SOFTWARE_PACKAGE = ord("v")
TEXT_PACKAGE = ord("M")
OUTPUTS_PACKAGE = ord("O")
INPUTS_PACKAGE = ord("I")
START_PACKAGE = ord("S")
PAUSE_PACKAGE = ord("P")
DATA_PACKAGE = ord("U")
STRUCT_FORMATS = {  # of the types in the module `struct`
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
}
REGISTER_COUNT = 48  # integers and doubles each, to and from the controller

_OUTPUTS = {
    "DOUBLE": "timestamp actual_execution_time speed_scaling target_speed_fraction actual_momentum "
    "actual_main_voltage actual_robot_voltage actual_robot_current standard_analog_input0 "
    "standard_analog_input1 standard_analog_output0 standard_analog_output1 io_current "
    "tool_analog_input0 tool_analog_input1 tool_output_current tool_temperature tcp_force_scalar "
    "payload collision_detection_ratio joint_position_deviation_ratio",
    "VECTOR6D": "target_q target_qd target_qdd target_current target_moment actual_q actual_qd "
    "actual_current actual_current_window joint_control_output actual_TCP_pose actual_TCP_speed "
    "actual_TCP_force target_TCP_pose target_TCP_speed joint_temperatures actual_joint_voltage "
    "ft_raw_wrench wrench_calc_from_currents payload_inertia actual_current_as_torque "
    "target_base_acceleration",
    "VECTOR3D": "actual_tool_accelerometer elbow_position elbow_velocity payload_cog "
    "target_gravity",
    "VECTOR6INT32": "joint_mode",
    "INT32": "robot_mode safety_mode safety_status tool_output_voltage",
    "UINT32": "runtime_state robot_status_bits safety_status_bits analog_io_types tool_mode "
    "tool_analog_input_types script_control_line output_bit_registers0_to_31 "
    "output_bit_registers32_to_63",
    "UINT64": "actual_digital_input_bits actual_digital_output_bits",
}
_INPUTS = {
    "UINT32": "speed_slider_mask input_bit_registers0_to_31 input_bit_registers32_to_63",
    "DOUBLE": "speed_slider_fraction standard_analog_output_0 standard_analog_output_1",
    "UINT8": "standard_digital_output_mask standard_digital_output "
    "configurable_digital_output_mask configurable_digital_output tool_digital_output_mask "
    "tool_digital_output standard_analog_output_mask standard_analog_output_type",
    "VECTOR6D": "external_force_torque",
}
_REGISTERS = {
    f"{kind}_register_{k}": stored
    for k in range(REGISTER_COUNT)
    for kind, stored in (("int", "INT32"), ("double", "DOUBLE"))
}
# The type of each variable, by its name.
OUTPUT_TYPES = {
    **{name: kind for kind, listed in _OUTPUTS.items() for name in listed.split()},
    **{f"output_{name}": kind for name, kind in _REGISTERS.items()},
}
INPUT_TYPES = {
    **{name: kind for kind, listed in _INPUTS.items() for name in listed.split()},
    **{f"input_{name}": kind for name, kind in _REGISTERS.items()},
}
FIRST_VERSIONS = {  # first minor version of the controller's software 3 and 5 that has an output
    "payload": {3: 11, 5: 6},
    "payload_cog": {3: 11, 5: 6},
    "payload_inertia": {3: 15, 5: 11},
    "ft_raw_wrench": {5: 9},
    "actual_current_as_torque": {5: 23},
    "target_gravity": {5: 26},
    "target_base_acceleration": {5: 26},
    # undocumented; assumed to exist with ft_raw_wrench, on e-Series controllers
    "wrench_calc_from_currents": {5: 9},
    "collision_detection_ratio": {5: 9},
    "joint_position_deviation_ratio": {5: 9},
}


class RobotMode(IntEnum):
    """Values of the RTDE output `robot_mode`."""

    NO_CONTROLLER = -1
    DISCONNECTED = 0
    CONFIRM_SAFETY = 1
    BOOTING = 2
    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    BACKDRIVE = 6
    RUNNING = 7


class SafetyMode(IntEnum):
    """Values of the RTDE output `safety_mode`."""

    NORMAL = 1
    REDUCED = 2
    PROTECTIVE_STOP = 3
    RECOVERY = 4
    SAFEGUARD_STOP = 5
    SYSTEM_EMERGENCY_STOP = 6
    ROBOT_EMERGENCY_STOP = 7
    VIOLATION = 8
    FAULT = 9


class RuntimeState(IntEnum):
    """Values of the RTDE output `runtime_state` that programs of one arm take."""

    STOPPED = 1
    PLAYING = 2
    PAUSED = 4


def exists(output: str, major: int, minor: int) -> bool:
    """Return whether controller software with version `major.minor` has an RTDE output."""
    since = FIRST_VERSIONS.get(output, {major: 0})
    return output in OUTPUT_TYPES and major in since and minor >= since[major]


def size(kind: str) -> int:
    """Return the number of values in an RTDE variable of this type."""
    return int(STRUCT_FORMATS[kind][:-1] or 1)


def columns(name: str) -> list[str]:
    """Return the names of an output's columns in a recording: `actual_q_0` … `actual_q_5`."""
    count = size(OUTPUT_TYPES[name])
    return [name] if count == 1 else [f"{name}_{k}" for k in range(count)]


def all_columns(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the columns of all outputs, in their order."""
    return tuple(chain.from_iterable(map(columns, names)))


def layout(kinds: list[str]) -> struct.Struct:
    """Return the layout of variables of these types in a data package: big-endian, no padding."""
    return struct.Struct(">" + "".join(STRUCT_FORMATS[kind] for kind in kinds))
