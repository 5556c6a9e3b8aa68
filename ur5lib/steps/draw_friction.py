"""Currents and friction of an arm, after Figures 6.1 and 6.2, with their band, and residuals."""

from collections.abc import Mapping

import numpy as np

from ur5lib.identification.current_samples import ZeroPhaseLowpass, current_record
from ur5lib.identification.currents import torque_constants
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.currents import Currents
from ur5lib.records.friction import Friction
from ur5lib.records.step import step
from ur5lib.report.figures.friction_figures import (
    MovingSamples,
    correlation_figure,
    current_figures,
    friction_figure,
    knowledge_bars,
)
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth


class Inputs(AlignedRecording):
    """What is read of a recording."""

    currents: Currents


@step(
    "arm",
    "friction.svg correlation.svg current_torque.svg current_torque_friction.svg knowledge.svg "
    "residuals.svg",
    recordings="fit",
)
def draw_friction(
    arm: Robot,
    friction: Friction,
    recordings: Mapping[str, Inputs],
    lowpass: Butterworth,
) -> dict[str, Drawing]:
    """Return the figures of a fit; recordings: those that it was fitted to."""
    fit, parts, known = friction.fit, list[MovingSamples](), friction.known_constants
    constant = torque_constants(fit) if fit.joints else np.ones(len(arm.joints))
    if fit.joints and known is not None:
        for recording in recordings.values():
            record = current_record(recording, arm)
            if record is not None:
                made = record, friction, recording.currents, ZeroPhaseLowpass(*lowpass)
                parts.append(MovingSamples.from_record(*made))
    samples = MovingSamples.joined(parts, len(constant))
    before = constant if known is None else known.value
    return {
        "knowledge": knowledge_bars(friction.parameters),
        "correlation": correlation_figure(fit.joints),
        "friction": friction_figure(samples, fit.joints, friction.load),
        **current_figures(samples, constant, before, arm.measured),
    }
