"""A recording of the virtual test stand: raw files for the workflow, and the truth about it."""

from pathlib import Path

from ur5lib.robots.description import Robot
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import Format, simulate


def simulate_recording(
    arm: Robot,
    plan: SimulatedRecording,
    format: Format,
    folder: str,
    truth: str,
    gravity: list[float] | None = None,
    way_points: Path | None = None,
) -> None:
    """Write the files of a simulated recording.

    folder: of its device files; truth: path of its truth, without suffix; way_points: file named in
    its plan.
    """
    simulate(arm.mounted(gravity), plan, format, Path(folder), Path(truth))
