"""Currents and friction of an arm, after Figures 6.1 and 6.2, and residuals of their fit."""

from typing import Any

import numpy as np

from ur5lib.identification.currents import CurrentFit, torque_constants
from ur5lib.pipeline.current_samples import current_record, smoother
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.report.friction_figures import MovingSamples, friction_figures
from ur5lib.report.house_style import save
from ur5lib.robots.description import load_robot
from ur5lib.tables import as_record, read_json


def draw_friction(input: Any, output: Any, params: Any) -> None:
    friction, model = read_json(input.friction), load_robot(input.arm).fullest_model()
    parts, constant, known = list[MovingSamples](), np.ones(6), np.ones(6)
    if friction["from"]:
        fit = as_record(CurrentFit, friction["fit"])
        constant, smooth = torque_constants(fit), smoother(params.order, params.cutoff_hz)
        known = np.array(friction["known_constants"]["value"])
        files = zip(params.recordings, input.signals, input.motion, input.torques, strict=True)
        for name, signals, motion, torques in files:
            tables = Signals.read(signals), Motion.read(motion), Torques.read(torques)
            record = current_record(name, *tables, model)
            if record is not None:
                parts.append(MovingSamples.from_record(record, fit, smooth))
    for name, figure in friction_figures(MovingSamples.joined(parts), constant, known).items():
        save(figure, output[name])
