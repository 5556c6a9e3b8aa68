"""Rows of tables about the link models: torques, rotors, identified parameters, remarks of fits."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ur5lib.report.findings import in_words
from ur5lib.report.tables.source import Row, Source, by_joint
from ur5lib.timeseries.metrics import mean_absolute_error

COMPARED = ("closed_loop", "target")  # motions to which a published torque error is compared
STOP = "stop sign"  # in the place of a step: no forces are stated for the arm
FITS = {"identification": "identification", "friction": "friction", "residuals": "contact forces"}


def torque_mae(source: Source) -> Iterator[Row]:
    """Yield the MAE of torques by motion and link model against `target_moment`, the printed MAE
    and that of zero torque; interpolated frames are left out.
    """
    signals, torques = source["signals"], source["torques"]
    if signals.target_moment is None:
        return
    received = ~signals.interpolated
    moment = signals.target_moment[received]
    zero = {"zero_mae": mean_absolute_error(np.zeros_like(moment), moment)}
    printed = source.published("torque_mae")
    motions = {"target": torques.target, "measured": torques.measured}
    motions |= {"closed_loop": source["closed_loop"].torque}
    for model in torques.measured:
        for motion, known in motions.items():
            if model in known:
                columns = zero | {"mae": mean_absolute_error(known[model][received], moment)}
                if motion in COMPARED and model in printed:
                    columns |= {"printed": printed[model]}
                about = {"motion": motion, "model": model}
                yield from (about | row for row in by_joint(columns))
    for model in printed.keys() - torques.measured.keys():
        about = {"motion": "closed_loop", "model": model}
        yield from (about | row for row in by_joint(zero | {"printed": printed[model]}))


def rotor_inertia(source: Source) -> Iterator[Row]:
    """Yield rotor inertias, and further fitted terms that should be zero."""
    rotors = source["rotors"]
    if rotors["from"]:
        value, std = rotors["value"], rotors["std_error"]
        columns = {"value": value["inertia"], "std_error": std["inertia"]}
        for term in ("offset", "coulomb", "viscous"):
            columns |= {term: value[term], f"{term}_std_error": std[term]}
        yield from by_joint(columns)


def parameters(source: Source) -> Iterator[Row]:
    """Yield the base parameters of the identified model."""
    yield from source["identification"].get("parameters", [])


def excitation(source: Source) -> Iterator[Row]:
    """Yield the excitation of an arm's parameters by the recordings, and advice."""
    if found := source["identification"].get("excitation"):
        advice = found["advice"]
        yield {
            "combinations": found["combinations"],
            "undetermined": len(found["undetermined"]),
            **found["condition"],
            "advice": "; ".join(map(in_words, advice)),
            "motion": advice[0]["values"].get("motion") if advice else None,
        }


def remarks(source: Source) -> Iterator[Row]:
    """Yield remarks of the fits by joint, and reasons of fits that failed."""
    for kind, step in FITS.items():
        summary = source[kind]
        for remark in [*summary.get("remarks", []), *filter(None, [summary.get("refused")])]:
            yield _remark(step, remark)
        if "stopped" in summary:
            yield _remark(STOP, summary["stopped"])
        for joint, fit in enumerate(summary.get("fit", {}).get("joints", []), start=1):
            for remark in fit["remarks"]:
                yield _remark(step, remark) | {"joint": joint}


def _remark(step: str, remark: Mapping[str, Any]) -> Row:
    return {"step": step, "code": remark["code"], "remark": in_words(remark)}
