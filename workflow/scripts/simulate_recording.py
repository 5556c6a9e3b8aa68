"""A recording of the virtual test stand: raw files for the workflow, the truth for its end."""

from pathlib import Path
from typing import Any

from ur5lib.lab.stand.layout import file_names
from ur5lib.lab.stand.plan import SimulatedRecording
from ur5lib.lab.stand.simulate import simulate
from ur5lib.robots.description import load_robot


def simulate_recording(input: Any, output: Any, params: Any) -> None:
    plan = SimulatedRecording.model_validate_json(params.plan)
    first = file_names(params.format, plan.sensors())[0]
    folder = Path(output.raw[0].removesuffix(first))
    truth = Path(output.truth).with_suffix("")
    robot = load_robot(input.arm).mounted(params.gravity)
    simulate(robot, plan, params.format, folder, truth)
