"""The undeclared payload, estimated from a recording's currents."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ur5lib.identification.payload import Load, PayloadEstimate, judge, run_to_run
from ur5lib.timeseries.arrays import Array


def judged_load(
    payload: PayloadEstimate,
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
    spread = run_to_run_spread(unloaded, paths)
    load = judge(payload, float(spread[0]))
    taken = load.certain and known["source"] != "study" and role != "fit"
    center, center_std = load_center(payload, load, spread)
    configured = known["payload"]["mass"] if known["payload"] else 0.0
    account = {"configured": configured, "carried": configured + load.mass}
    place = {"center_of_mass": center, "center_of_mass_std": center_std}
    return asdict(load) | account | {"taken": taken} | place


def load_center(payload: PayloadEstimate, load: Load, spread: Array) -> tuple[Array, Array]:
    """Return the centre of mass (3,) [m] and its standard error; NaN of a load that is uncertain.

    spread: of mass and first moments from run to run, (4,).
    """
    if not load.certain:
        return np.full(3, np.nan), np.full(3, np.nan)
    center = payload.parameters[1:] / load.mass
    moment_std = np.hypot(payload.std_error[1:], spread[1:])
    return center, np.hypot(moment_std, center * load.std_error) / load.mass


def run_to_run_spread(unloaded: Sequence[Mapping[str, Any]], paths: int) -> Array:
    """Return the standard deviation (4,) [kg, kg m] of the loads of runs that carry none."""
    found = [payload for payload in unloaded if payload]
    if not found:
        return np.zeros(4)
    values, errors = (
        np.array([own[name] for own in found]) for name in ("parameters", "std_error")
    )
    return run_to_run(values, errors, paths)
