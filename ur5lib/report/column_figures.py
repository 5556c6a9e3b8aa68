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
LEGEND: Any = {"loc": "outside upper center", "frameon": False, "fontsize": LETTERS}
ROW = 64  # letters of a legend side by side, with room for its lines
INSIDE = (0, 0, 0.98, 1)  # of a figure: room for the label of the last panel
LONGEST = 16  # letters of an axis's label in one row


def fit_column(figure: Figure) -> None:
    """Set a figure to the width of a column, with legible letters and thin lines.

    All parts stay vector graphics.
    """
    wide, high = figure.get_size_inches()
    figure.set_size_inches(WIDTH, TALLER * high * WIDTH / wide)
    figure.set_layout_engine("constrained", w_pad=0.03, h_pad=0.02, hspace=0.03, rect=INSIDE)
    for artist in figure.findobj():
        artist.set_rasterized(False)
        if isinstance(artist, Text):
            artist.set_fontsize(LETTERS)
        if isinstance(artist, Line2D | Spine):
            artist.set_linewidth(THINNER * artist.get_linewidth())
    for axes in figure.axes:
        axes.tick_params(width=0.5, length=2, pad=1.5)
        label = axes.get_xlabel()
        axes.set_xlabel(label.replace(" [", "\n[") if len(label) > LONGEST else label)
    _narrow_legends(figure)


def _narrow_legends(figure: Figure) -> None:
    """Draw the legends of a figure and its panels anew, above them, in fewer columns."""
    inside = [legend for axes in figure.axes if (legend := axes.get_legend())]
    for legend in [*figure.legends, *inside]:
        labels = [text.get_text() for text in legend.get_texts()]
        handles = [handle for handle in legend.legend_handles if handle]
        columns = max(1, ROW // (max(map(len, labels)) + 8))
        figure.legend(handles, labels, ncols=columns, **LEGEND)
        legend.remove()
