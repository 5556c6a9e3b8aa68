"""The smallest push by speed of the flange, and how well friction is predicted by joint speed."""

from typing import Any

from ur5lib.force.trial_contacts import MOST
from ur5lib.identification.validation import WANTED
from ur5lib.report.figures.arm_state_figures import observability_figure
from ur5lib.report.figures.house_style import save
from ur5lib.tables import read_csv


def draw_observability(input: Any, output: Any, params: Any) -> None:
    figure = observability_figure(read_csv(input.observability), WANTED, MOST)
    save(figure, output.observability)
