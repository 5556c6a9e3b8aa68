"""The house style of all figures, and how they are written: as SVG with their data."""

import re
from base64 import b64decode, b64encode
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple, Self

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D
from matplotlib.ticker import ScalarFormatter
from matplotlib.transforms import ScaledTranslation
from PIL import Image

from ur5lib.tables import write_bytes, write_csv
from ur5lib.timeseries.arrays import Array

# Okabe and Ito's palette, which colour-blind readers can distinguish; dashes help in print.
JOINT_COLOURS = (
    *("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00"),
    *("#8C6D31", "#999999"),  # of arms with seven or eight joints
)


@dataclass(frozen=True)
class Style:
    """How a line is drawn.

    colours: one, or one for each joint; dashes: lengths of dashes and gaps, () for a solid line;
    width: in points.
    """

    colours: tuple[str, ...]
    dashes: tuple[float, ...] = ()
    width: float = 1.0

    def line(
        self, i: int, x: Sequence[float] | Array = (), y: Sequence[float] | Array = ()
    ) -> Line2D:
        """Return the line through points x, y (N,) in the style of panel i, counted from 0."""
        shape: Any = (0, self.dashes) if self.dashes else "-"
        colour = self.colours[i % len(self.colours)]
        return Line2D(x, y, color=colour, linewidth=self.width, linestyle=shape)


LINE_STYLES = {
    "pale": Style(("#C4C4C4",), width=0.7),  # for signals that are not judged
    "measured": Style(("#000000",), width=1.1),
    "leading": Style(("#009E73",), width=1.2),
    "first": Style(("#0072B2",), (5, 1.2)),
    "second": Style(("#D55E00",), (1.2, 1)),
    "third": Style(("#009E73",), (4, 1, 1, 1)),
    "fourth": Style(("#CC79A7",), (3, 1, 1, 1, 1, 1)),
    "fifth": Style(("#56B4E9",), (2, 1, 2, 3)),
    "joint": Style(JOINT_COLOURS),  # each joint in its own colour
}
REPORT_FONT_SIZE = 8.1  # points; 8 in the PDF
HOUSE_STYLE: Any = {
    "axes.formatter.limits": (-3, 4),
    "axes.grid": True,
    "axes.labelsize": REPORT_FONT_SIZE,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": REPORT_FONT_SIZE,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.5,
    "path.simplify_threshold": 0.5,
    "svg.hashsalt": "ur5lib",  # the same figure gives the same file
}
DOT_STYLE: Any = {"markersize": 1.5, "alpha": 0.4, "rasterized": True}
BAND_STYLE: Any = {"color": "#009E73", "alpha": 0.25, "linewidth": 0}
GAP_STYLE: Any = {"facecolor": "none", "edgecolor": "#999999", "hatch": "////", "linewidth": 0}
# Like the lines of a grid; `axes.axisbelow` puts these at 1.5.
TIME_STYLE: Any = {
    "edgecolor": "#b0b0b0",
    "alpha": 0.3,
    "linewidth": 0.5,
    "fill": False,
    "zorder": 1.5,
}
SHADE_STYLE: Any = {"color": "#000000", "alpha": 0.12, "linewidth": 0}
PAGE_WIDTH = 7.2  # inches; A4 between margins
ALONE_HEIGHT = 3.6  # inches; of a panel shown alone
# Inches from a y-axis to its label; leaves room for ticks such as −0.0025.
LABEL_DISTANCE = 0.6
IMAGE_DPI = 130  # of images inside a figure
LETTER_WIDTH = 0.6  # mean width of a letter over its font size
LEGEND_LINE_LETTERS = 8  # a legend's line is as wide as this many letters
SCREEN_DPI = 100  # of a figure in a notebook
PALETTE_SIZE = 64  # colours of an image inside a figure: a fourth of the size with all colours
EMBEDDED_IMAGE = re.compile(rb"(?<=data:image/png;base64,)[A-Za-z0-9+/=\s]+")
MOST_VERTICES = 9000  # lines with more become an image, which is smaller


class Ticks(ScalarFormatter):
    """Tick labels as plain text, ten times faster than formulas; only the power is a formula."""

    def get_offset(self) -> str:
        """Return the factor of the labels, such as ×10⁻³."""
        self.set_useMathText(True)
        power: str = super().get_offset()
        self.set_useMathText(False)
        return power


class NotebookFigure(Figure):
    """A figure that a notebook shows, whatever its backend."""

    def with_panel(self, number: int) -> Self:
        """Return the figure with one of its panels alone, counted from 1, at full width."""
        for place, axes in enumerate([*self.axes], start=1):
            if place != number:
                axes.remove()
            else:
                axes.set_subplotspec(GridSpec(1, 1, self)[0])
                self.set_size_inches(PAGE_WIDTH, ALONE_HEIGHT)
        return self

    def _repr_png_(self) -> bytes:
        buffer = BytesIO()
        with matplotlib.rc_context(HOUSE_STYLE):
            self.savefig(buffer, format="png", dpi=SCREEN_DPI)
        return buffer.getvalue()


class Drawing(NamedTuple):
    """A figure and its numbers; an empty figure has numbers without rows.

    styles: of a figure over time: the style of each line, in the order of the data's columns.
    """

    figure: Figure
    data: pd.DataFrame
    styles: tuple[str, ...] = ()


@contextmanager
def house_style(
    height: float, rows: int = 1, columns: int = 1, **layout: Any
) -> Iterator[tuple[Figure, Any]]:
    """Provide a figure as wide as a page and its panels (rows, columns), to draw in house style.

    height: in inches; layout: further arguments of `Figure.subplots`.
    """
    with matplotlib.rc_context(HOUSE_STYLE):
        figure = NotebookFigure(figsize=(PAGE_WIDTH, height), layout="constrained")
        yield figure, figure.subplots(rows, columns, squeeze=False, **layout)


def nothing_to_draw() -> Drawing:
    """Return the placeholder of a figure without data."""
    figure = NotebookFigure(figsize=(PAGE_WIDTH, 0.5))
    figure.text(0.5, 0.5, "not recorded", ha="center", va="center")
    return Drawing(figure, pd.DataFrame())


def save(drawing: Drawing, path: str | Path) -> None:
    """Write a figure and its numbers, byte for byte the same for the same data.

    SVG: many vertices become an image inside the file, which is smaller; styles of lines become
    keywords; the numbers lie next to it as CSV.
    """
    path = Path(path)
    axes = drawing.figure.axes
    if drawing.styles:
        _place_labels(drawing.figure)
    if sum(np.size(line.get_xdata()) for axis in axes for line in axis.lines) > MOST_VERTICES:
        for artist in (artist for axis in axes for artist in [*axis.lines, *axis.collections]):
            artist.set_rasterized(True)
    keywords = [*drawing.styles] or None
    drawn = _rendered(drawing, {"Date": None, "Keywords": keywords})
    write_bytes(EMBEDDED_IMAGE.sub(_with_palette, drawn), path)
    write_csv(drawing.data, path.with_suffix(".csv"), digits=6)


def _place_labels(figure: Figure) -> None:
    """Align the labels of all y-axes at a fixed distance, beyond the widest tick labels.

    Matplotlib's own search for this distance takes a quarter of the drawing time.
    """
    for axes in figure.axes:
        left = ScaledTranslation(-LABEL_DISTANCE, 0, figure.dpi_scale_trans)
        axes.yaxis.set_label_coords(0, 0.5, transform=axes.transAxes + left)


def _rendered(drawing: Drawing, metadata: dict[str, list[str] | None]) -> bytes:
    """Return a figure as SVG."""
    buffer = BytesIO()
    with matplotlib.rc_context(HOUSE_STYLE):
        for axis in (axis for axes in drawing.figure.axes for axis in (axes.xaxis, axes.yaxis)):
            if type(axis.get_major_formatter()) is ScalarFormatter:
                axis.set_major_formatter(Ticks())
        drawing.figure.savefig(buffer, format="svg", dpi=IMAGE_DPI, metadata=metadata)
    return buffer.getvalue()


def _with_palette(image: re.Match[bytes]) -> bytes:
    """Return an image, PNG as base64, with a palette of PALETTE_SIZE."""
    buffer = BytesIO()
    full = Image.open(BytesIO(b64decode(image[0])))
    full.quantize(PALETTE_SIZE, Image.Quantize.FASTOCTREE).save(buffer, "PNG")
    return b64encode(buffer.getvalue())
