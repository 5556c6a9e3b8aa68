"""The published estimates of contact wrenches, as printed and corrected: Figures 6.5 to 6.9."""

from typing import Any

from ur5lib.pipeline.records.forces import PublishedForces, SensorWrenches
from ur5lib.report.figures.house_style import save
from ur5lib.report.figures.recording_figures import published_force_figure as draw


def draw_published_forces(input: Any, output: Any, params: Any) -> None:
    published, sensor = PublishedForces.read(input.published), SensorWrenches.read(input.sensor)
    without = "F", "Fu"
    save(draw(published, sensor, "printed", without), output.forces_printed)
    save(draw(published, sensor, "printed", ("F*",)), output.forces_friction_printed)
    save(draw(published, sensor, "corrected", without), output.forces_corrected)
    save(draw(published, sensor, "corrected", ("F*",)), output.forces_friction_corrected)
