"""The names of RTDE's outputs that nothing here uses.

Source: Universal Robots' guide to the Real-Time Data Exchange (RTDE), table of robot controller
outputs.
"""

import re

UNUSED = (
    "actual_robot_braking_energy_dissipated",
    "actual_robot_energy_consumed",
    "analog_io_types",
    "collision_detection_ratio",
    r"encoder[01]_raw",
    r"euromap67_(input_bits|output_bits|24V_voltage|24V_current)",
    r"input_(bit_registers\d+_to_\d+|(bit|int|double)_register_\d+)",
    "io_current",
    "joint_position_deviation_ratio",
    r"output_(bit_registers\d+_to_\d+|(bit|int|double)_register_\d+)",
    "script_control_line",
    r"standard_analog_(in|out)put[01]",
    "time_scale_source",
    r"tool_analog_input(_types|[01])",
    r"tool_(mode|output_mode|digital_output[01]_mode)",
    r"tool_(output_voltage|output_current|temperature)",
)


def is_unused(column: str) -> bool:
    """Return whether a column holds an output of RTDE that nothing here uses."""
    return re.fullmatch("|".join(UNUSED), column) is not None
