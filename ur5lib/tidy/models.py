"""Rows of tables about the link models: torques, rotors, identified parameters, remarks of fits."""

from collections.abc import Iterator

import numpy as np

from ur5lib.errors import Remark
from ur5lib.force.residual_model import Residuals
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.quality import STOP
from ur5lib.records.signals import Signals, slowly
from ur5lib.tidy import Column, Row, by_joint
from ur5lib.timeseries.metrics import mean_absolute_error

MIN_TARGET_TRAVEL, MIN_LED_TRAVEL = 0.01, 0.1  # rad, of a target that moves, of a joint that is led


def torque_mae(signals: Signals, torques: Torques) -> Iterator[Row]:
    """Yield the MAE of torques by motion and link model against `target_moment`, below 2 Hz, too,
    and that of zero torque; interpolated frames are left out.
    """
    if signals.target_moment is None or is_led(signals):
        return
    received = ~signals.interpolated
    moment = signals.target_moment[received]
    slow = slowly(signals.target_moment, signals)[received]
    zero: dict[str, Column] = {
        "zero_mae": mean_absolute_error(np.zeros_like(moment), moment),
        "zero_mae_2hz": mean_absolute_error(np.zeros_like(slow), slow),
    }
    motions = {"target": torques.target, "measured": torques.measured}
    for model in torques.measured:
        for motion, known in motions.items():
            if model in known:
                columns = zero | {
                    "mae": mean_absolute_error(known[model][received], moment),
                    "mae_2hz": mean_absolute_error(slowly(known[model], signals)[received], slow),
                }
                yield from by_joint(columns, motion=motion, model=model)


def is_led(signals: Signals) -> bool:
    """Return whether a joint moves while its target rests: a hand leads the arm, and the torque of
    the target is not that of the motion.
    """
    if signals.target_q is None:
        return False
    rests = np.ptp(signals.target_q, axis=0) < MIN_TARGET_TRAVEL
    moves = np.ptp(signals.actual_q, axis=0) > MIN_LED_TRAVEL
    return bool((rests & moves).any())


def rotor_inertia(rotors: Rotors) -> Iterator[Row]:
    """Yield rotor inertias, and further fitted terms that should be zero."""
    if rotors.value is not None and rotors.std_error is not None:
        value, std = vars(rotors.value), vars(rotors.std_error)
        columns = {"value": value["inertia"], "std_error": std["inertia"]}
        for term in ("offset", "coulomb", "viscous"):
            columns |= {term: value[term], f"{term}_std_error": std[term]}
        yield from by_joint(columns)


def parameters(identification: Identification) -> Iterator[Row]:
    """Yield the base parameters of the identified model."""
    yield from map(vars, identification.parameters)


def excitation(identification: Identification) -> Iterator[Row]:
    """Yield the excitation of an arm's parameters by the recordings, and advice."""
    found = identification.excitation
    if found is not None:
        yield {
            "combinations": found.combinations,
            "undetermined": len(found.undetermined),
            **found.condition,
            "advice": "; ".join(one.text for one in found.advice),
            "motion": (found.advice[0].motion or None) if found.advice else None,
        }


def remarks(
    identification: Identification | None,
    friction: Friction | None,
    residuals: Residuals | None,
) -> Iterator[Row]:
    """Yield remarks of the fits to an arm by joint, and reasons of fits that failed."""
    fits = {"identification": identification, "friction": friction, "contact forces": residuals}
    for step, fitted in fits.items():
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
    return {"step": step, "code": remark.code, "remark": remark.sentence()}
