"""Figures as wide as a column of a paper."""

from typing import Any

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.spines import Spine
from matplotlib.text import Text

WIDTH = 88 / 25.4  # inches
TALLER = 1.5  # than in the report: text keeps its size while panels become narrow
LETTERS = 6.5  # points
THINNER = 0.6  # of the widths of lines in the report
LEGEND: Any = {"loc": "outside upper center", "ncols": 3, "frameon": False, "fontsize": LETTERS}


def fit_column(figure: Figure) -> None:
    """Give a figure the width of a column, its letters a size that can be read, and thin lines.

    Nothing in it becomes an image.
    """
    wide, high = figure.get_size_inches()
    figure.set_size_inches(WIDTH, TALLER * high * WIDTH / wide)
    figure.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, hspace=0.03)
    for artist in figure.findobj():
        artist.set_rasterized(False)
        if isinstance(artist, Text):
            artist.set_fontsize(LETTERS)
        if isinstance(artist, Line2D | Spine):
            artist.set_linewidth(THINNER * artist.get_linewidth())
    for axes in figure.axes:
        axes.tick_params(width=0.5, length=2, pad=1.5)
    _narrow_legends(figure)


def _narrow_legends(figure: Figure) -> None:
    """Draw the legends of a figure anew, above its panels, in fewer columns."""
    for legend in [*figure.legends]:
        labels = [text.get_text() for text in legend.get_texts()]
        handles = [handle for handle in legend.legend_handles if handle]
        figure.legend(handles, labels, **LEGEND)
        legend.remove()
