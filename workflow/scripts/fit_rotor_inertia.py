"""Rotor inertia of each joint, from the controller's torque minus that of rigid links."""

from typing import Any

from ur5lib.identification import rotor_inertia
from ur5lib.pipeline.torques import rotor_samples
from ur5lib.records.models import Rotors
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.tables import write_json
from ur5lib.timeseries.lowpass import Butterworth


def fit_rotor_inertia(input: Any, output: Any, params: Any) -> None:
    robot, design = load_robot(input.arm), Butterworth(params.order, params.cutoff_hz)
    recordings = zip(params.recordings, params.gravities, input.signals, input.motion, strict=True)
    samples = {
        name: rotor_samples(
            robot.mounted(gravity), Signals.read(signals), Motion.read(motion), design
        )
        for name, gravity, signals, motion in recordings
    }
    known = {name: sample for name, sample in samples.items() if sample is not None}
    rotors = Rotors()
    if known:
        fit = rotor_inertia.fit_rotor_inertia(*zip(*known.values(), strict=True))
        rotors = Rotors([*known], fit.value, fit.std_error)
    write_json(rotors, output.rotors)
