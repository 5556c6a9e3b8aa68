"""A recording for Foxglove's 3D panel: its arm, the joints' motion, and forces."""

import json
import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, repeat
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ur5lib.finished import StudyFiles
from ur5lib.force.estimators import LEADING
from ur5lib.records.dynamics import Kinematics
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import written_bodies
from ur5lib.tables import columns
from ur5lib.timeseries.arrays import Array

BASE = "frame_0"  # frame of the URDF in which forces are given
METRES_PER_NEWTON = 0.005  # length of an arrow
# Share of the shaft in an arrow's length; diameters of shaft and head [m].
SHAFT_SHARE, SHAFT_DIAMETER, HEAD_DIAMETER = 0.8, 0.015, 0.035
# Topic: table, columns' prefix, colour.
ARROWS: dict[str, tuple[str, str, tuple[float, float, float]]] = {
    f"/arrow_{LEADING}": ("forces", LEADING, (0.0, 0.62, 0.45)),
    "/arrow_sensor": ("sensor", "compensated", (0.1, 0.1, 0.1)),
}
PRIMITIVES = ("cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")


class Stream(NamedTuple):
    """A topic of an MCAP file with its messages: schema_name, schema: name and content of their
    JSON Schema; messages: for each sample, JSON or None for no message.
    """

    topic: str
    schema_name: str
    schema: dict[str, Any]
    messages: Iterator[bytes | None]


def drawn(
    study: StudyFiles, name: str, tables: Mapping[str, pd.DataFrame], stamps: list[int]
) -> Iterator[Stream]:
    """Yield the arm's URDF, states of its joints, and contact forces as arrows at its flange.

    tables: of the recording, by name; stamps: of their samples [ns].
    """
    arm = study.arm(study.recording(name).arm.known_as)
    text = urdf(arm, written_bodies(arm, arm.fullest_model()))
    once = chain([_json({"data": text})], repeat(None))
    yield Stream("/robot_description", "std_msgs/String", _object(data=TEXT), once)
    states = joint_states(tables["signals"], stamps)
    yield Stream("/joint_states", "foxglove.JointStates", JOINT_STATES, states)
    origin = study.record(Kinematics, name).origin
    for topic, (table, prefix, colour) in ARROWS.items():
        names = [f"{prefix}_F{axis}" for axis in "xyz"]
        if table in tables and {*names} <= {*tables[table]}:
            force = tables[table][names].to_numpy()
            scene = arrows(topic[1:], origin, force, colour, stamps)
            yield Stream(topic, "foxglove.SceneUpdate", SCENE_UPDATE, scene)


def joint_states(signals: pd.DataFrame, stamps: list[int]) -> Iterator[bytes]:
    """Yield the measured angles and velocities of the joints as `foxglove.JointStates`.

    Joints have the names of the URDF, and no values where these are unknown.
    """
    known = {"position": "actual_q", "velocity": "actual_qd"}
    joints = len([one for one in signals if one.startswith("actual_q_")])
    given = {
        field: signals[columns(channel, joints)].to_numpy()
        for field, channel in known.items()
        if f"{channel}_0" in signals
    }
    for sample, stamp in enumerate(stamps):
        states = [
            {"name": f"joint_{k + 1}"}
            | {field: x for field, rows in given.items() if math.isfinite(x := rows[sample, k])}
            for k in range(joints)
        ]
        yield _json({"timestamp": _time(stamp), "joints": states})


def arrows(
    name: str, origin: Array, force: Array, colour: tuple[float, float, float], stamps: list[int]
) -> Iterator[bytes]:
    """Yield forces as `foxglove.SceneUpdate`: an arrow from the flange, none where it is unknown.

    origin: (N, 3) [m] and force: (N, 3) [N] in base axes.
    """
    size = np.linalg.norm(force, axis=1)
    turned = from_x_axis(force / np.where(size > 0, size, 1)[:, None])
    for sample, stamp in enumerate(stamps):
        length = METRES_PER_NEWTON * float(size[sample])
        arrow = {
            "pose": {
                "position": dict(zip("xyz", origin[sample].tolist(), strict=True)),
                "orientation": dict(zip("xyzw", turned[sample].tolist(), strict=True)),
            },
            "shaft_length": SHAFT_SHARE * length,
            "shaft_diameter": SHAFT_DIAMETER,
            "head_length": (1 - SHAFT_SHARE) * length,
            "head_diameter": HEAD_DIAMETER,
            "color": dict(zip("rgba", (*colour, 1.0), strict=True)),
        }
        is_known = length > 0 and np.isfinite(origin[sample]).all()
        entity = {
            "timestamp": _time(stamp),
            "frame_id": BASE,
            "id": name,
            "lifetime": _time(0),
            "frame_locked": True,
            "metadata": [],
            "arrows": [arrow] if is_known else [],
            **{primitive: [] for primitive in PRIMITIVES},
        }
        yield _json({"deletions": [], "entities": [entity]})


def from_x_axis(direction: Array) -> Array:
    """Return quaternions x, y, z, w (N, 4) that turn the x-axis into unit vectors (N, 3)."""
    x, y, z = direction.T
    half = np.stack([0 * x, -z, y, 1 + x], axis=1)
    half[np.isclose(x, -1)] = 0, 0, 1, 0  # half a turn about z, as any axis across x
    return np.asarray(half / np.linalg.norm(half, axis=1, keepdims=True))


def _time(stamp: int) -> dict[str, int]:
    return {"sec": stamp // 10**9, "nsec": stamp % 10**9}


def _json(message: Mapping[str, Any]) -> bytes:
    return json.dumps(message).encode()


# The used parts of Foxglove's schemas, as JSON Schema


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list(items: Any) -> dict[str, Any]:
    return {"type": "array", "items": items}


def _numbers(names: Iterable[str]) -> dict[str, Any]:
    return _object(**dict.fromkeys(names, NUMBER))


NUMBER, INTEGER, TEXT = {"type": "number"}, {"type": "integer"}, {"type": "string"}
TIME = _object(sec=INTEGER, nsec=INTEGER)
JOINT_STATES = _object(
    timestamp=TIME,
    joints=_list(_object(name=TEXT, position=NUMBER, velocity=NUMBER)),
)
ARROW = _object(
    pose=_object(position=_numbers("xyz"), orientation=_numbers("xyzw")),
    shaft_length=NUMBER,
    shaft_diameter=NUMBER,
    head_length=NUMBER,
    head_diameter=NUMBER,
    color=_numbers("rgba"),
)
SCENE_UPDATE = _object(
    deletions=_list(_object()),
    entities=_list(
        _object(
            timestamp=TIME,
            frame_id=TEXT,
            id=TEXT,
            lifetime=TIME,
            frame_locked={"type": "boolean"},
            metadata=_list(_object()),
            arrows=_list(ARROW),
            **{primitive: _list(_object()) for primitive in PRIMITIVES},
        )
    ),
)
