"""Residual models of the external torque without contact, as residuals.json."""

from collections.abc import Sequence
from typing import Any

from ur5lib.errors import InputError
from ur5lib.force.force_input import ForceInput
from ur5lib.force.residual_model import Stretch, few_paths, fit_residual_model
from ur5lib.pipeline.force_input import force_input
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.motion import Motion
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken

TORQUES = {"tau_ext": "external_torque", "tau_observer": "observed_torque"}
ONE_PATH = (
    "all fit recordings follow one path: the variation of the torque between paths is unknown, so "
    "bands and gate are 6.5 times as wide as that path alone suggests; record another path"
)


def residual_summary(
    recordings: Sequence[tuple[Currents, Motion]], breakaway: Array, paths: int, cutoff: float
) -> dict[str, Any]:
    """Return the residual model of each external torque, or the reason why there is none.

    recordings: those to fit, without contact, predicted by fits without their own path; paths:
    their number; breakaway: (6,) [Nm]; cutoff: of the torques [Hz].
    """
    summary: dict[str, Any] = {}
    for name, field in TORQUES.items():
        inputs = [
            force_input(motion, torque, currents)
            for currents, motion in recordings
            if (torque := getattr(currents, field)) is not None
        ]
        try:
            summary[name] = _residual_model(inputs, breakaway, paths, cutoff)
        except InputError as error:  # too little without contact: then no force is estimated
            summary["refused"] = str(error)
    if paths == 1 and "refused" not in summary:
        summary["remarks"] = [ONE_PATH]
    return summary


def _residual_model(
    inputs: Sequence[ForceInput], breakaway: Array, paths: int, cutoff: float
) -> dict[str, Any]:
    stretches = [
        Stretch(one.torque[rows], one.states[rows], one.period)
        for one in inputs
        for rows in unbroken(one.segment)
    ]
    model = fit_residual_model(stretches, cutoff, breakaway)
    return model.wider(few_paths(paths)).to_dict()
