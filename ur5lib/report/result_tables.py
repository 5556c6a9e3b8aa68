"""The tables of results: tidy, one value a row, SI units, joints 1 to 6."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.report.reference import PrintedTable, published
from ur5lib.tables import channel
from ur5lib.timeseries.metrics import mean_absolute_error

Row = dict[str, object]

REMEDY = "if an IMU's samples were stamped by the same computer, name both under `hosts`"
COMPARED = ("closed_loop", "target")  # motions to which a published torque error is compared


def recording_table(qualities: Mapping[str, Any]) -> pd.DataFrame:
    """How long recordings are and how regular their frames, from their quality.json."""
    rows = [
        {
            "recording": recording,
            "duration_s": quality["duration_s"],
            "rows_read": quality["rows"],
            "frames": quality["frames"],
            "longest_step_s": quality["longest_step_s"],
            "jitter_s": quality["jitter_s"]["99 %"],
            "devices": " ".join(quality["devices"]),
        }
        for recording, quality in qualities.items()
    ]
    return pd.DataFrame(rows)


def file_table(qualities: Mapping[str, Any]) -> pd.DataFrame:
    """The files that each recording was read from, from its quality.json."""
    rows = [
        {"recording": recording, "file": file, "sha256": checksum}
        for recording, quality in qualities.items()
        for file, checksum in quality["read"].items()
    ]
    return pd.DataFrame(rows, columns=["recording", "file", "sha256"])


def quality_table(
    qualities: Mapping[str, Any], clocks: Mapping[str, Any], forces: Mapping[str, Any]
) -> pd.DataFrame:
    """Findings of every recording, from its quality.json, clocks.json and forces.json."""
    columns = ["recording", "device", "finding", "severity", "count", "detail"]
    rows = [
        {"recording": recording, **finding}
        for recording, quality in qualities.items()
        for finding in [
            *quality["findings"],
            *_copies(recording, qualities),
            *_poor_clocks(clocks.get(recording, {})),
            *_doubted_sensor(forces.get(recording, {})),
        ]
    ]
    return pd.DataFrame(rows, columns=columns)


def _poor_clocks(clocks: Mapping[str, Any]) -> Iterator[Row]:
    """Devices that only start stamps place on the robot's clock."""
    for device, clock in clocks.items():
        row = {"device": device, "severity": "warning", "count": 1}
        errors = clock["offset_std"], clock["end_std"]
        good_to = "good to {:.2g} s at the start and {:.2g} s at the end".format(*errors)
        if clock["warning"]:
            detail = f"{clock['warning']}; {good_to}"
            yield row | {"finding": "clock by stamps alone", "detail": detail}
        elif clock["drift"] is None:
            detail = f"only its start stamp places it on the robot's clock: {good_to}; {REMEDY}"
            yield row | {"finding": "unknown drift", "detail": detail}


def _doubted_sensor(forces: Mapping[str, Any]) -> Iterator[Row]:
    """A force sensor that contradicts the motor currents or its tool's weight, or whose bias may be
    a push.
    """
    for doubted in ("mounting", "offset"):
        if forces.get(f"{doubted}_doubt"):
            yield {
                "device": "force",
                "finding": doubted,
                "severity": "warning",
                "count": 1,
                "detail": forces[f"{doubted}_doubt"],
            }


def _copies(recording: str, qualities: Mapping[str, Any]) -> Iterator[Row]:
    """Device files that are byte for byte those of another recording."""
    for device, checksum in qualities[recording]["files"].items():
        others = [
            other
            for other, quality in qualities.items()
            if other != recording and quality["files"].get(device) == checksum
        ]
        if others:
            used = "used" if device in qualities[recording]["devices"] else "not used"
            yield {
                "device": device,
                "finding": "same file",
                "severity": "note",
                "count": len(others),
                "detail": f"byte for byte that of {', '.join(others)}; {used} here",
            }


def group_findings(quality: pd.DataFrame) -> pd.DataFrame:
    """Findings of one kind as one row: counts summed, details that differ in a place said once."""
    kinds = quality.groupby(["recording", "device", "finding", "severity"], sort=False)
    grouped = kinds.agg({"count": "sum", "detail": lambda details: _said_once(list(details))})
    return grouped.reset_index()


def _said_once(details: list[str]) -> str:
    places, rests = zip(*(detail.rpartition(": ")[::2] for detail in details), strict=True)
    return f"{'; '.join(places)}: {rests[0]}" if len(details) > 1 else details[0]


def clock_table(clocks: Mapping[str, Any]) -> pd.DataFrame:
    """How each device's clock runs against the robot's, from clocks.json."""
    columns = ["recording", "device", "offset_s", "offset_std_s"]
    columns += ["drift_ppm", "drift_std_ppm", "method", "end_std_s"]
    rows = [
        {
            "recording": recording,
            "device": device,
            "offset_s": clock["offset"],
            "offset_std_s": clock["offset_std"],
            "drift_ppm": _ppm(clock["drift"]),
            "drift_std_ppm": _ppm(clock["drift_std"]),
            "method": clock["method"],
            "end_std_s": clock["end_std"],
        }
        for recording, devices in clocks.items()
        for device, clock in devices.items()
    ]
    return pd.DataFrame(rows, columns=columns)


def _ppm(drift: float | None) -> float | None:
    return None if drift is None else 1e6 * drift


def torque_errors(
    recording: str, torques: pd.DataFrame, signals: pd.DataFrame, printed: PrintedTable | None
) -> Iterator[Row]:
    """MAE of the modelled torques against `target_moment`, beside print and a torque of zero.

    Frames that were interpolated are left out.
    """
    if "target_moment_0" not in signals:
        return
    received = ~signals["interpolated"].to_numpy()
    moment = channel(signals, "target_moment")[received]
    zero = mean_absolute_error(np.zeros_like(moment), moment)
    values = published(printed, recording)
    computed = dict.fromkeys(
        tuple(name[4:-2].rsplit("_", maxsplit=1)) for name in torques.filter(regex="^tau_.*_0$")
    )
    for motion, model in computed:
        torque = channel(torques, f"tau_{motion}_{model}")[received]
        mae = mean_absolute_error(torque, moment)
        print_ = values.get(model, [None] * 6) if motion in COMPARED else [None] * 6
        yield from _joints(recording, motion, model, mae, print_, zero)
    for model in values.keys() - {model for _, model in computed}:
        yield from _joints(recording, "closed_loop", model, [None] * 6, values[model], zero)


def _joints(
    recording: str, motion: str, model: str, mae: Any, printed: Any, zero: Any
) -> Iterator[Row]:
    for joint in range(6):
        yield {
            "recording": recording,
            "motion": motion,
            "model": model,
            "joint": joint + 1,
            "mae": mae[joint],
            "printed": printed[joint],
            "zero_mae": zero[joint],
        }


def force_errors(
    recording: str,
    summary: Mapping[str, Any],
    printed_mae: PrintedTable | None,
    printed_max: PrintedTable | None,
) -> Iterator[Row]:
    """Errors of the force estimates against the sensor, from forces.json."""
    tables = {"mae": published(printed_mae, recording), "max": published(printed_max, recording)}
    for kind, estimates in summary["errors"].items():
        for estimate, periods in estimates.items():
            known = _determined(periods.get("contact"))
            for during, figures in periods.items():
                printed = tables if (kind, during) == ("printed", "all") else {}
                for i, component in enumerate(figures["mae"]):
                    yield {
                        "recording": recording,
                        "kind": kind,
                        "estimate": estimate,
                        "during": during,
                        "component": component,
                        **{name: values[component] for name, values in figures.items()},
                        "determined": known.get(component),
                        **{
                            f"printed_{figure}": table[estimate][i]
                            for figure, table in printed.items()
                            if estimate in table
                        },
                    }


def _determined(in_contact: Mapping[str, Any] | None) -> dict[str, str]:
    """Which components an estimate tells: its skill in contact is above zero, for certain."""
    if not in_contact:
        return {}
    skills = in_contact.get("skill_low", in_contact["skill"])
    return {name: "yes" if (skill or 0) > 0 else "no" for name, skill in skills.items()}


def contact_error_rows(recording: str, summary: Mapping[str, Any]) -> Iterator[Row]:
    """What each estimate misses of each contact that the sensor saw, from forces.json."""
    for estimate, contacts in summary.get("contacts", {}).items():
        for row in contacts:
            yield {"recording": recording, "estimate": estimate, **row}
