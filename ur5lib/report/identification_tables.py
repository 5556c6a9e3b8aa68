"""Tables of results on what was identified: gains, rotor inertias, inertial parameters."""

from collections.abc import Iterator, Mapping
from typing import Any

import pandas as pd

from ur5lib.report.reference import PrintedTable, published
from ur5lib.tables import channel
from ur5lib.timeseries.metrics import mean_absolute_error

Row = dict[str, object]

QUANTITIES = {"q": "actual_q", "qd": "actual_qd"}


def closed_loop_errors(
    recording: str,
    closed_loop: pd.DataFrame,
    signals: pd.DataFrame,
    printed: Mapping[str, PrintedTable | None],
) -> Iterator[Row]:
    """MAE of q̂ and q̂̇ under each set of gains, and of the targets themselves.

    printed: the published table of each quantity. Frames that were interpolated are left out.
    """
    received = ~signals["interpolated"].to_numpy()
    sets = dict.fromkeys(name[3:-2] for name in closed_loop.filter(regex="^qd_.*_0$"))
    for quantity, measured in QUANTITIES.items():
        if not sets:
            return
        values = published(printed[quantity], recording)
        reference = channel(signals, measured)[received]
        target = channel(signals, f"target_{quantity}")[received]
        simulated = {name: channel(closed_loop, f"{quantity}_{name}")[received] for name in sets}
        for model, states in (simulated | {"target": target}).items():
            mae = mean_absolute_error(states, reference)
            for joint in range(6):
                yield {
                    "recording": recording,
                    "model": model,
                    "joint": joint + 1,
                    "quantity": quantity,
                    "mae": mae[joint],
                    "printed": values[model][joint] if model in values else None,
                }


def gain_rows(recording: str, gains: Mapping[str, Any]) -> Iterator[Row]:
    """The gains that a recording tells, from gains.json: a value only where it is determined.

    low and high: of the range that fits equally well, empty where it reaches a search bound.
    """
    for joint, found in enumerate(gains.get("joints", []), start=1):
        for gain, unit in (("position", "1/s2"), ("velocity", "1/s")):
            known = found[gain]["determined"]
            yield {
                "recording": recording,
                "joint": joint,
                "gain": gain,
                "unit": unit,
                "value": found[gain]["best"] if known else None,
                "std_error": found[gain]["std_error"] if known else None,
                "low": _inside(found[gain], "low"),
                "high": _inside(found[gain], "high"),
                "determined": "yes" if known else "no",
            }


def _inside(gain: Mapping[str, Any], end: str) -> float | None:
    return None if gain[end] in (gain["grid"][0], gain["grid"][-1]) else gain[end]


def published_gain_rows(recording: str, gains: Mapping[str, Any]) -> Iterator[Row]:
    """Whether published gains fit a recording as well as the best ones do, from gains.json."""
    for model, costs in gains.get("published", {}).items():
        for joint, (cost, found) in enumerate(zip(costs, gains["joints"], strict=True), start=1):
            yield {
                "recording": recording,
                "model": model,
                "joint": joint,
                "cost": cost,
                "least_cost": found["cost"],
                "limit": found["limit"],
                "fits": "yes" if cost <= found["limit"] else "no",
            }


def rotor_rows(robot: str, rotors: Mapping[str, Any]) -> Iterator[Row]:
    """Rotor inertias and the terms that should be zero, from rotor_inertia.json."""
    if not rotors["from"]:
        return
    value, std = rotors["value"], rotors["std_error"]
    for joint in range(6):
        terms = {
            name: part[term][joint]
            for term in ("offset", "coulomb", "viscous")
            for name, part in ((term, value), (f"{term}_std_error", std))
        }
        yield {
            "joint": joint + 1,
            "value": value["inertia"][joint],
            "std_error": std["inertia"][joint],
            **terms,
            "robot": robot,
        }


def parameter_rows(robot: str, identification: Mapping[str, Any]) -> Iterator[Row]:
    """Base parameters of the identified model, from identification.json."""
    for row in identification.get("parameters", []):
        told = "yes" if row["determined"] else "no"
        yield {"robot": robot, **row, "determined": told}


def excitation_rows(robot: str, identification: Mapping[str, Any]) -> Iterator[Row]:
    """How well the recordings excite an arm, from identification.json."""
    found = identification.get("excitation")
    if found:
        yield {
            "robot": robot,
            "combinations": found["combinations"],
            "undetermined": len(found["undetermined"]),
            **found["condition"],
            "advice": "; ".join(found["advice"]),
        }
