"""MAE of the modelled torques against `target_moment`, beside print and zero."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import ClosedLoop, Torques
from ur5lib.report.reference import PrintedTable, published
from ur5lib.report.study_results import Row, StudyResults
from ur5lib.timeseries.metrics import mean_absolute_error

COLUMNS = ["recording", "motion", "model", "joint", "mae", "printed", "zero_mae"]
COMPARED = ("closed_loop", "target")  # motions to which a published torque error is compared


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    torques, loops = results.paths_of("torques"), results.paths_of("closed_loop")
    for name, signals in results.paths_of("signals").items():
        modelled = Torques.read(torques[name]), ClosedLoop.read(loops[name])
        yield from torque_errors(name, Signals.read(signals), *modelled, results.printed.torque_mae)


def torque_errors(
    recording: str,
    signals: Signals,
    torques: Torques,
    closed_loop: ClosedLoop,
    printed: PrintedTable | None,
) -> Iterator[Row]:
    """Yield the MAE of each motion and link model; interpolated frames are left out."""
    if signals.target_moment is None:
        return
    received = ~signals.interpolated
    moment = signals.target_moment[received]
    zero = mean_absolute_error(np.zeros_like(moment), moment)
    values = published(printed, recording)
    motions = {
        "target": torques.target,
        "measured": torques.measured,
        "closed_loop": closed_loop.torque,
    }
    computed = [(motion, model) for model in torques.measured for motion in motions]
    for motion, model in computed:
        if model in motions[motion]:
            mae = mean_absolute_error(motions[motion][model][received], moment)
            print_ = values.get(model, [None] * 6) if motion in COMPARED else [None] * 6
            yield from _joints(recording, motion, model, mae, print_, zero)
    for model in values.keys() - torques.measured.keys():
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
