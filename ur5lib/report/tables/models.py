"""Rows of tables about the link models: torques, rotors, identified parameters, remarks of fits."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ur5lib.report.finding_sentences import in_words
from ur5lib.report.tables.own import Own, Row, by_joint
from ur5lib.timeseries.metrics import mean_absolute_error

COMPARED = ("closed_loop", "target")  # motions to which a published torque error is compared
STOP = "stop sign"  # a step of its own: no forces are stated
FITS = {"identification": "identification", "friction": "friction", "residuals": "contact forces"}


def torque_mae(own: Own) -> Iterator[Row]:
    """Yield the MAE of each motion's and link model's torque against `target_moment`, beside print
    and zero; interpolated frames are left out.
    """
    signals, torques = own["signals"], own["torques"]
    if signals.target_moment is None:
        return
    received = ~signals.interpolated
    moment = signals.target_moment[received]
    zero = {"zero_mae": mean_absolute_error(np.zeros_like(moment), moment)}
    printed = own.published("torque_mae")
    motions = {"target": torques.target, "measured": torques.measured}
    motions |= {"closed_loop": own["closed_loop"].torque}
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


def rotor_inertia(own: Own) -> Iterator[Row]:
    """Yield rotor inertias, and the terms beside them that should be zero."""
    rotors = own["rotors"]
    if rotors["from"]:
        value, std = rotors["value"], rotors["std_error"]
        columns = {"value": value["inertia"], "std_error": std["inertia"]}
        for term in ("offset", "coulomb", "viscous"):
            columns |= {term: value[term], f"{term}_std_error": std[term]}
        yield from by_joint(columns)


def parameters(own: Own) -> Iterator[Row]:
    """Yield the base parameters of the identified model."""
    yield from own["identification"].get("parameters", [])


def excitation(own: Own) -> Iterator[Row]:
    """Yield how well the recordings excite an arm."""
    if found := own["identification"].get("excitation"):
        advice = found["advice"]
        yield {
            "combinations": found["combinations"],
            "undetermined": len(found["undetermined"]),
            **found["condition"],
            "advice": "; ".join(map(in_words, advice)),
            "motion": advice[0]["values"].get("motion") if advice else None,
        }


def remarks(own: Own) -> Iterator[Row]:
    """Yield remarks of the fits by joint, and reasons of fits that failed."""
    for kind, step in FITS.items():
        summary = own[kind]
        for remark in [*summary.get("remarks", []), *filter(None, [summary.get("refused")])]:
            yield _remark(step, remark)
        if "stopped" in summary:
            yield _remark(STOP, summary["stopped"])
        for joint, fit in enumerate(summary.get("fit", {}).get("joints", []), start=1):
            for remark in fit["remarks"]:
                yield _remark(step, remark) | {"joint": joint}


def _remark(step: str, remark: Mapping[str, Any]) -> Row:
    return {"step": step, "code": remark["code"], "remark": in_words(remark)}
