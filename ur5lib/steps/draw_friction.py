"""Currents and friction of an arm, after Figures 6.1 and 6.2, and residuals of their fit."""

from collections.abc import Mapping

import numpy as np

from ur5lib.identification.current_samples import Smoother, current_record
from ur5lib.identification.currents import torque_constants
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.report.figures.friction_figures import MovingSamples, friction_figures, knowledge_bars
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth


def draw_friction(
    arm: Robot,
    friction: Friction,
    signals: Mapping[str, Signals],
    motion: Mapping[str, Motion],
    torques: Mapping[str, Torques],
    lowpass: Butterworth,
) -> dict[str, Drawing]:
    """Return the figures of a fit; signals, motion, torques: of the recordings to fit."""
    parts, constant, known = list[MovingSamples](), np.ones(6), np.ones(6)
    if friction.fit.joints and friction.known_constants is not None:
        fit, smooth = friction.fit, Smoother(*lowpass)
        constant, known = torque_constants(fit), friction.known_constants.value
        for name in signals:
            tables = signals[name], motion[name], torques[name]
            record = current_record(name, *tables, arm)
            if record is not None:
                parts.append(MovingSamples.from_record(record, fit, smooth))
    samples = MovingSamples.joined(parts, len(constant))
    drawn = friction_figures(samples, constant, known, arm.measured)
    return {"knowledge": knowledge_bars(friction.parameters), **drawn}
