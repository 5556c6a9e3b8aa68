"""The smallest push by motion of the flange, and how well friction is predicted by joint speed."""

import pandas as pd

from ur5lib.identification.validation import MIN_SHARE_IN_BAND
from ur5lib.report.figures.house_style import Drawing
from ur5lib.topics.observability.figure import observability_figure


def draw_observability(observability: pd.DataFrame, pushes: pd.DataFrame) -> dict[str, Drawing]:
    """Return the figure of what an arm's contact-free recordings let one observe."""
    return {"observability": observability_figure(observability, MIN_SHARE_IN_BAND, pushes)}
