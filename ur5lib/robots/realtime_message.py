"""Layout of the messages of the controller's realtime port (30003)."""

from collections.abc import Mapping

import numpy as np

from ur5lib.timeseries.arrays import Array

SOFTWARE_BY_SIZE = {  # the size of its messages [bytes] shows the controller's software
    756: "1.5, 1.6",
    764: "1.7",
    812: "1.8",
    1044: "3.0, 3.1",
    1060: "3.2 to 3.4",
    1108: "3.5 to 3.9, 5.0 to 5.3",
    1116: "3.10 to 3.13, 5.4 to 5.8",
    1140: "3.14, 3.15, 5.9",
    1220: "5.10 and later",
}
# Sizes of the first layouts of software 1.7 and 3.0.
SIZE_OF_1_7 = 764  # bytes
SIZE_OF_3 = 1044  # bytes

# First byte and number of doubles of the fields with an RTDE name. Bits and raw counts are omitted.
COMMON_FIELDS = {
    "target_q": (12, 6),
    "target_qd": (60, 6),
    "target_qdd": (108, 6),
    "target_current": (156, 6),
    "target_moment": (204, 6),
    "actual_q": (252, 6),
    "actual_qd": (300, 6),
    "actual_current": (348, 6),
    "actual_TCP_force": (540, 6),
    "joint_temperatures": (692, 6),
    "robot_mode": (756, 1),
    "joint_mode": (764, 6),
}
FIELDS_BEFORE_3 = {  # before 3.0
    "actual_TCP_pose": (588, 6),
    "actual_TCP_speed": (636, 6),
}
FIELDS_FROM_3 = {
    "joint_control_output": (396, 6),
    "actual_TCP_pose": (444, 6),
    "actual_TCP_speed": (492, 6),
    "target_TCP_pose": (588, 6),
    "target_TCP_speed": (636, 6),
    "safety_mode": (812, 1),
    "actual_tool_accelerometer": (868, 3),
    "speed_scaling": (940, 1),
    "actual_momentum": (948, 1),
    "actual_main_voltage": (972, 1),
    "actual_robot_voltage": (980, 1),
    "actual_robot_current": (988, 1),
    "actual_joint_voltage": (996, 6),
    "elbow_position": (1060, 3),
    "elbow_velocity": (1084, 3),
    "safety_status": (1108, 1),
    "payload": (1140, 1),
    "payload_cog": (1148, 3),
    "payload_inertia": (1172, 6),
}
FIELDS_BEFORE_3_FROM_1_7 = {"actual_tool_accelerometer": (396, 3)}  # raw counts up to 1.6


def fields(size: int) -> dict[str, slice]:
    """Return the place of each field among the doubles after the size word, in the order sent.

    The first double is the controller's timestamp. size: of the messages [bytes], which determines
    their layout.
    """
    further = (
        FIELDS_FROM_3
        if size >= SIZE_OF_3
        else FIELDS_BEFORE_3
        if size < SIZE_OF_1_7
        else FIELDS_BEFORE_3 | FIELDS_BEFORE_3_FROM_1_7
    )
    present = {name: at for name, at in (COMMON_FIELDS | further).items() if at[0] < size}
    ordered = sorted(present.items(), key=lambda field: field[1])
    return {n: slice((byte - 4) // 8, (byte - 4) // 8 + count) for n, (byte, count) in ordered}


def encoded(size: int, timestamps: Array, channels: Mapping[str, Array | float]) -> list[bytes]:
    """Return messages of a size [bytes]: int32 size, then big-endian doubles.

    timestamps: (N,) [s]; channels: (N, n) each, or one value for all messages; missing ones are 0.
    """
    doubles = np.zeros((len(timestamps), (size - 4) // 8), ">f8")
    doubles[:, 0] = timestamps
    for name, place in fields(size).items():
        doubles[:, place] = channels.get(name, 0.0)
    head = size.to_bytes(4, "big")
    return [head + message.tobytes() for message in doubles]
