"""Rows of tables about the link models: torques, rotors, identified parameters, remarks of fits."""

from collections.abc import Iterator

import numpy as np

from ur5lib.errors import Remark
from ur5lib.identification.excitation import Excitation
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.models import Rotors
from ur5lib.report.findings import in_words
from ur5lib.report.tables.source import Column, Row, Source, by_joint
from ur5lib.timeseries.metrics import mean_absolute_error

COMPARED = ("closed_loop", "target")  # motions to which a published torque error is compared
STOP = "stop sign"  # in the place of a step: no forces are stated for the arm
FITS = {"identification": "identification", "friction": "friction", "residuals": "contact forces"}


def torque_mae(source: Source) -> Iterator[Row]:
    """Yield the MAE of torques by motion and link model against `target_moment`, the printed MAE
    and that of zero torque; interpolated frames are left out.
    """
    signals, torques, loop = source["signals"], source["torques"], source["closed_loop"]
    if signals.target_moment is None:
        return
    received = ~signals.interpolated
    moment = signals.target_moment[received]
    zero: dict[str, Column] = {"zero_mae": mean_absolute_error(np.zeros_like(moment), moment)}
    printed = source.published("torque_mae")
    motions = {"target": torques.target, "measured": torques.measured}
    motions |= {"closed_loop": loop.torque} if loop else {}
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
    rotors: Rotors = source["rotors"]
    if rotors.value is not None and rotors.std_error is not None:
        value, std = vars(rotors.value), vars(rotors.std_error)
        columns = {"value": value["inertia"], "std_error": std["inertia"]}
        for term in ("offset", "coulomb", "viscous"):
            columns |= {term: value[term], f"{term}_std_error": std[term]}
        yield from by_joint(columns)


def parameters(source: Source) -> Iterator[Row]:
    """Yield the base parameters of the identified model."""
    yield from map(vars, source["identification"].parameters)


def excitation(source: Source) -> Iterator[Row]:
    """Yield the excitation of an arm's parameters by the recordings, and advice."""
    found: Excitation | None = source["identification"].excitation
    if found is not None:
        yield {
            "combinations": found.combinations,
            "undetermined": len(found.undetermined),
            **found.condition,
            "advice": "; ".join(map(in_words, found.advice)),
            "motion": found.advice[0].values.get("motion") if found.advice else None,
        }


def remarks(source: Source) -> Iterator[Row]:
    """Yield remarks of the fits by joint, and reasons of fits that failed."""
    for kind, step in FITS.items():
        fitted = source[kind]
        refused = filter(None, [getattr(fitted, "refused", None)])
        for remark in [*getattr(fitted, "remarks", ()), *refused]:
            yield _remark(step, remark)
        if isinstance(fitted, Friction):
            yield from _remarks_of_joints(fitted)


def _remarks_of_joints(friction: Friction) -> Iterator[Row]:
    if friction.stopped is not None:
        yield _remark(STOP, friction.stopped)
    for joint, fit in enumerate(friction.fit.joints, start=1):
        for remark in fit.remarks:
            yield _remark("friction", remark) | {"joint": joint}


def _remark(step: str, remark: Remark) -> Row:
    return {"step": step, "code": remark.code, "remark": in_words(remark)}
