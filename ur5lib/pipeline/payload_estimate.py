"""The undeclared payload, estimated from a recording's currents."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ur5lib.identification.payload import Payload, judge, run_to_run
from ur5lib.robots.description import Robot
from ur5lib.robots.urdf import link_tail
from ur5lib.timeseries.arrays import Array

LINK_6 = slice(50, 54)  # of π: mass and first moments; a payload is a part of link 6


def load_regressor(columns: Array, robot: Robot) -> Array:
    """Return the torque (N, 6, 4) per mass [kg] and first moments [kg m] of a load in frame 6.

    columns: Y of τ = Y π, (N, 6, 66), whose moments of link 6 are about its joint: h = m t + R h₆,
    with the constant transform R, t from there to frame 6.
    """
    rotation, tail = link_tail(robot.link_poses()[5])
    mass, moments = np.split(columns[:, :, LINK_6], [1], axis=2)
    return np.concatenate([mass + moments @ tail[:, None], moments @ rotation], axis=2)


def judged_load(
    payload: Payload,
    unloaded: Sequence[Mapping[str, Any]],
    paths: int,
    known: Mapping[str, Any],
    role: str,
) -> dict[str, Any]:
    """Return the undeclared payload, and whether it is included in the prediction.

    unloaded: payload.json of the recordings to fit on, of so many paths; known: torques.json. A
    load that is certain is taken, unless the study declares another, or the recording is one to fit
    on, whose payload is taken as it was given.
    """
    load = judge(payload, run_to_run_spread(unloaded, paths))
    taken = load.certain and known["source"] != "study" and role != "fit"
    center = payload.parameters[1:] / load.mass if load.certain else np.full(3, np.nan)
    configured = known["payload"]["mass"] if known["payload"] else 0.0
    account = {"configured": configured, "carried": configured + load.mass}
    return asdict(load) | account | {"taken": taken, "center_of_mass": center}


def run_to_run_spread(unloaded: Sequence[Mapping[str, Any]], paths: int) -> float:
    """Return the standard deviation of the mass [kg] that recordings to fit on seem to carry."""
    found = [payload for payload in unloaded if payload]
    if not found:
        return 0.0
    values, errors = (
        np.array([own[name] for own in found]) for name in ("parameters", "std_error")
    )
    return float(run_to_run(values, errors, paths)[0])
