"""Each joint's friction, torque constant, offset and noise over time, with what changed."""

from typing import Any

from ur5lib.pipeline.records.health import Health
from ur5lib.report.arm_state_figures import health_figure
from ur5lib.report.house_style import save
from ur5lib.tables import read_record


def draw_health(input: Any, output: Any, params: Any) -> None:
    health = read_record(Health, input.health)
    save(health_figure(health.dates, health.changes), output.health)
