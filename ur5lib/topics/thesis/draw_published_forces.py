"""The published estimates of contact wrenches, as printed and corrected: Figures 6.5 to 6.9."""

from ur5lib.records.forces import FurtherForces, SensorWrenches
from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.topics.thesis.figure import published_force_figure

WITHOUT_FRICTION, WITH_FRICTION = ("F", "Fu"), ("F*",)


@step(
    "recording",
    "forces_printed.svg forces_friction_printed.svg forces_corrected.svg "
    "forces_friction_corrected.svg",
    published="further",
)
def draw_published_forces(published: FurtherForces, sensor: SensorWrenches) -> dict[str, Drawing]:
    """Return by name the figures of a recording's published estimates and the sensor's forces."""
    known = published, sensor
    return {
        "forces_printed": published_force_figure(*known, "printed", WITHOUT_FRICTION),
        "forces_friction_printed": published_force_figure(*known, "printed", WITH_FRICTION),
        "forces_corrected": published_force_figure(*known, "corrected", WITHOUT_FRICTION),
        "forces_friction_corrected": published_force_figure(*known, "corrected", WITH_FRICTION),
    }
