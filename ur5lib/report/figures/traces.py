"""Figures over time: a panel for each joint, or six of a wrench; errors under values, gaps and
singular stretches shaded.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise, product
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from ur5lib.report.figures.house_style import (
    BAND_STYLE,
    GAP_STYLE,
    HOUSE_STYLE,
    LEGEND_LINE_LETTERS,
    LETTER_WIDTH,
    LINE_STYLES,
    PAGE_WIDTH,
    REPORT_FONT_SIZE,
    SHADE_STYLE,
    TIME_STYLE,
    Drawing,
    nothing_to_draw,
)
from ur5lib.report.figures.panels import Panel, cartesian_quantity, joint_quantity
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs

StyledLines = Mapping[str, tuple[Array, str]]
MAX_DRAWN_POINTS = 1100  # about the dots across half a printed page
MIN_PANEL_SPAN = 1e-3  # least height of a panel, in its unit
MOST_LEGEND_COLUMNS = 6
LEGEND_ROW = 0.17  # inches
LEGEND_MARGIN = 0.1  # inches; around the rows
UNFILTERED = "unfiltered"  # label of the recorded signal behind the filtered one
ERROR = "error of "  # precedes the label of a line
HIDDEN = "near a singularity"
# Reads line, panel and unit from the name of a column of the numbers.
LINE_COLUMN = re.compile(r"(.*), (.*) \[(.*)\]")
BAND_EDGES = ("95 % band, lower", "95 % band, upper")
TORQUE_PANELS = joint_quantity(r"\tau", "Nm")
CURRENT_PANELS = joint_quantity("i", "A")
WRENCH_PANELS = cartesian_quantity(("F", "F", "N"), ("n", "n", "Nm"))
FORCE_PANELS = [*WRENCH_PANELS[:3], Panel("size", "|F|", "N")]
MOMENT_PANELS = WRENCH_PANELS[3:]
ACCELERATION_PANELS = cartesian_quantity(
    ("a", r"\ddot{p}", "m/s²"), ("α", r"\dot{\omega}", "rad/s²")
)


@dataclass(frozen=True)
class Traces:
    """Lines drawn over time (N,) [s]; NaN in time is a gap.

    series, errors: by label, values (N, k) of k panels and a style; errors are drawn in panels
    below the values; band: lower and upper edge of a 95 % band, (N, 6) each, also drawn about zero
    of the first error; hidden: (N,), where a force is undetermined.
    """

    time: Array
    series: StyledLines
    errors: StyledLines = field(default_factory=dict)
    band: tuple[Array, Array] | None = None
    hidden: Mask | None = None


def draw_traces(traces: Traces, panels: Sequence[Panel]) -> Drawing:
    """Draw columns of panels: joints 1, 3, 5 and 2, 4, 6, or linear and angular quantities."""
    if not traces.series:
        return nothing_to_draw()
    width = next(iter(traces.series.values()))[0].shape[1]
    thin, panels = _decimated(traces), panels[:width]
    spans, around_zero = _shaded(traces), _around_zero(traces)
    with matplotlib.rc_context(HOUSE_STYLE):
        figure, above, below = _grid(thin, panels)
        for i, axis in enumerate(above):
            _draw_panel(axis, thin, thin.series, i, thin.band)
            axis.set_ylabel(f"${panels[i].symbol}$ [{panels[i].unit}]")
            if below:
                _draw_panel(below[i], thin, thin.errors, i, around_zero)
                below[i].set_ylabel(f"$\\Delta$ [{panels[i].unit}]")
        for starts, ends, style, _ in spans:
            for axis, (start, end) in product([*above, *below], zip(starts, ends, strict=True)):
                axis.axvspan(start, end, **style)
        _draw_times(figure)
        _legend(figure, thin, [(style, name) for starts, _, style, name in spans if len(starts)])
    styles = tuple(style for _, style in thin.series.values())
    return Drawing(figure, _data(thin, panels), styles)


def _decimated(traces: Traces) -> Traces:
    """Return the traces with fewer samples and the same envelope."""

    def thin(values: Array) -> Array:  # one array at a time, to save memory
        return decimate(traces.time, values)[1]

    def all_thin(series: StyledLines) -> StyledLines:
        return {label: (thin(values), style) for label, (values, style) in series.items()}

    time, _ = decimate(traces.time, traces.time[:, None])
    series, errors = all_thin(traces.series), all_thin(traces.errors)
    band = (thin(traces.band[0]), thin(traces.band[1])) if traces.band else None
    hidden = None if traces.hidden is None else thin(traces.hidden[:, None].astype(float))[:, 0] > 0
    return replace(traces, time=time, series=series, errors=errors, band=band, hidden=hidden)


def _around_zero(traces: Traces) -> tuple[Array, Array] | None:
    """Return the band of an error: the values' band, moved to zero."""
    if traces.band is None:
        return None
    _, half = decimate(traces.time, (traces.band[1] - traces.band[0]) / 2)
    return -half, half


def _grid(traces: Traces, panels: Sequence[Panel]) -> tuple[Figure, list[Axes], list[Axes]]:
    """Return a figure with axes of the values and of the errors, in the order of the panels."""
    pairs = 2 if traces.errors else 1
    rows = -(-len(panels) // 2)
    height = (4.7 if traces.errors else 3.8) * (rows / 3)
    figure = Figure(figsize=(PAGE_WIDTH, height))
    # Fixed margins: matplotlib's layout engines take a third of the drawing time.
    figure.subplots_adjust(0.105, 0.42 / height, 0.99, 1 - 0.42 / height, wspace=0.27, hspace=0.3)
    ratios = [2, 1] * rows if traces.errors else [1] * rows
    axes = figure.subplots(pairs * rows, 2, sharex=True, squeeze=False, height_ratios=ratios)
    figure.align_ylabels(axes)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    by_rows = panels[0].name.startswith("joint") or rows < 3  # 1 2, 3 4, 5 6; else linear left
    places = [(i // 2, i % 2) if by_rows else (i % 3, i // 3) for i in range(len(panels))]
    above = [axes[pairs * row, column] for row, column in places]
    below = [axes[pairs * row + 1, column] for row, column in places] if traces.errors else []
    for axis in {*axes.flat} - {*above, *below}:
        axis.set_visible(False)
    return figure, above, below


def _draw_panel(
    axis: Axes, traces: Traces, series: StyledLines, i: int, band: tuple[Array, Array] | None = None
) -> None:
    if band:
        axis.fill_between(traces.time, band[0][:, i], band[1][:, i], **BAND_STYLE)
    for values, style in series.values():
        line = axis.add_line(LINE_STYLES[style].line(i, traces.time, values[:, i]))
        line.set_zorder(line.get_zorder() + (style == "leading"))
    axis.autoscale_view()
    low, high = axis.get_ylim()
    missing = MIN_PANEL_SPAN - (high - low)
    if missing > 0:  # values change by less than rounding noise
        axis.set_ylim(low - missing / 2, high + missing / 2)


def _draw_times(figure: Figure) -> None:
    """Draw the grid at round times in the panels without labels of time.

    It is one path, as ticks would take a fifth of the drawing time.
    """
    last = next(axis for axis in figure.axes if axis.get_xlabel())
    low, high = last.get_xlim()
    times = [time for time in last.get_xticks() if low <= time <= high]
    last.set_xticks(times)  # of all panels, which share them
    lines = Path.make_compound_path(*(Path([(time, 0), (time, 1)]) for time in times))
    for axis in (axis for axis in figure.axes if not axis.get_xlabel()):
        axis.xaxis.set_visible(False)
        axis.add_artist(PathPatch(lines, transform=axis.get_xaxis_transform(), **TIME_STYLE))


def _legend(figure: Figure, traces: Traces, spans: list[tuple[Any, str]]) -> None:
    """Draw one legend for all panels; a style with a colour per joint shows them all."""
    handles: Any = {}  # lines, or tuples of lines, which the stubs lack
    for label, (_, style) in [*traces.series.items(), *traces.errors.items()]:
        count = next(iter(traces.series.values()))[0].shape[1]
        lines = tuple(LINE_STYLES[style].line(i) for i in range(count))
        handles.setdefault(label, lines if style.startswith("joint") else lines[0])
    if traces.band:
        handles["95 % band"] = Patch(**BAND_STYLE)
    handles |= {name: Patch(**style) for style, name in spans}
    columns = _legend_columns([*handles])
    rows = -(-len(handles) // columns)
    margin = LEGEND_MARGIN + LEGEND_ROW * max(2, rows)
    figure.subplots_adjust(top=1 - margin / figure.get_figheight())
    figure.legend(
        handles.values(),
        handles.keys(),
        loc="upper center",
        ncols=columns,
        frameon=False,
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0)},
        handlelength=2.5,
    )


def _legend_columns(labels: Sequence[str]) -> int:
    """Return the largest number of columns of a legend that fit side by side."""
    letters = PAGE_WIDTH * 72 / (LETTER_WIDTH * REPORT_FONT_SIZE)
    for columns in range(min(MOST_LEGEND_COLUMNS, len(labels)), 1, -1):
        parts = np.array_split(labels, columns)
        widths = (max(map(len, part)) + LEGEND_LINE_LETTERS for part in parts)
        if sum(widths) <= letters:
            return columns
    return 1


def _data(traces: Traces, panels: Sequence[Panel]) -> pd.DataFrame:
    """Return the drawn numbers, a column for each line."""
    lines = {label: values for label, (values, _) in traces.series.items()}
    lines |= {ERROR + label: values for label, (values, _) in traces.errors.items()}
    if traces.band:
        lines |= zip(BAND_EDGES, traces.band, strict=True)
    columns = {
        column_name(label, panel.name, panel.unit): values[:, i]
        for label, values in lines.items()
        for i, panel in enumerate(panels)
    }
    if traces.hidden is not None and traces.hidden.any():
        columns[HIDDEN] = traces.hidden.astype(float)
    return pd.DataFrame({"time [s]": traces.time, **columns})


def column_name(line: str, panel: str, unit: str) -> str:
    """Return the name of a line's column in the numbers of a figure."""
    return f"{line}, {panel} [{unit}]"


def _shaded(traces: Traces) -> list[tuple[Array, Array, Any, str]]:
    """Return (times at which spans begin, times at which they end, style, name) of each kind of
    shaded spans.
    """
    time = traces.time
    gaps = np.flatnonzero(np.isnan(time[1:-1])) + 1
    shaded = [(time[gaps - 1], time[gaps + 1], GAP_STYLE, "gap")]
    if traces.hidden is not None:
        first, end = runs(np.isfinite(time) & (traces.hidden == 1)).T
        shaded.append((time[first], time[end - 1], SHADE_STYLE, HIDDEN))
    return shaded


def decimate(time: Array, values: Array, points: int = MAX_DRAWN_POINTS) -> tuple[Array, Array]:
    """Return time (N,) and values (N, M) thinned to about `points` rows, with the same envelope.

    Rows are grouped in buckets. Each bucket keeps the lowest and the highest value of every column,
    in their order, at the times of its first and middle row. Rows with time NaN mark gaps; they are
    kept, and no bucket reaches across them.
    """
    size = int(np.ceil(2 * len(time) / points))
    if size <= 2:
        return time, values
    breaks = np.flatnonzero(np.isnan(time))
    edges = np.unique([0, *breaks, *(breaks + 1), len(time)])
    parts = [_envelope(time[start:end], values[start:end], size) for start, end in pairwise(edges)]
    times, envelopes = zip(*parts, strict=True)
    return np.concatenate(times), np.concatenate(envelopes)


def _envelope(time: Array, values: Array, size: int) -> tuple[Array, Array]:
    """Return the time and the values of one unbroken part, decimated as in `decimate`; the last
    bucket is filled with its last row.
    """
    if np.isnan(time[0]):
        return time, values
    missing = -len(time) % size
    time = np.pad(time, (0, missing), mode="edge").reshape(-1, size)
    buckets = np.pad(values, ((0, missing), (0, 0)), mode="edge").reshape(len(time), size, -1)
    low, high = np.fmin.reduce(buckets, axis=1), np.fmax.reduce(buckets, axis=1)
    place = np.arange(size)[None, :, None]
    first_low = np.min(np.where(buckets == low[:, None], place, size), axis=1)
    first_high = np.min(np.where(buckets == high[:, None], place, size), axis=1)
    rising = first_low <= first_high
    extremes: Array = np.stack([np.where(rising, low, high), np.where(rising, high, low)], axis=1)
    return time[:, [0, size // 2]].reshape(-1), extremes.reshape(2 * len(time), -1)
