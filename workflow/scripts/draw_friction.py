"""Currents and friction of an arm, after Figures 6.1 and 6.2, and residuals of their fit."""

from typing import Any

import numpy as np

from ur5lib.identification.currents import torque_constants
from ur5lib.pipeline.current_samples import Smoother, current_record
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.figures.friction_figures import MovingSamples, friction_figures, knowledge_bars
from ur5lib.report.figures.house_style import save
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record


def draw_friction(input: Any, output: Any, params: Any) -> None:
    friction = read_record(Friction, input.friction)
    model = load_robot(input.arm).fullest_model()
    parts, constant, known = list[MovingSamples](), np.ones(6), np.ones(6)
    if friction.fit.joints and friction.known_constants is not None:
        fit, smooth = friction.fit, Smoother(params.order, params.cutoff_hz)
        constant, known = torque_constants(fit), friction.known_constants.value
        files = zip(params.recordings, input.signals, input.motion, input.torques, strict=True)
        for name, signals, motion, torques in files:
            tables = Signals.read(signals), Motion.read(motion), Torques.read(torques)
            record = current_record(name, *tables, model)
            if record is not None:
                parts.append(MovingSamples.from_record(record, fit, smooth))
    samples = MovingSamples.joined(parts, len(constant))
    save(knowledge_bars(friction.parameters), output.knowledge)
    figures = friction_figures(samples, constant, known, friction.senses_torque())
    for name, figure in figures.items():
        save(figure, output[name])
