"""*Replay*: the figures over time and the arm, packed for its scripts."""

import json
import re
import zlib
from base64 import b64encode
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.records.scene import Scene
from ur5lib.report.figures.house_style import LINE_STYLES
from ur5lib.report.figures.traces import BAND_EDGES, LINE_COLUMN, column_name
from ur5lib.tables import read_csv, read_record
from ur5lib.timeseries.arrays import Array

FOLDER = Path(__file__).parent / "templates" / "closer"
VENDORED = FOLDER / "vendored"
SCRIPTS = ("numbers.js", "stretch.js", "plots.js", "scene.js", "arm.js", "look.js")
LEVELS = 256  # values are rounded to this many, about two for each pixel of a panel
MILLI = 1e-3  # s, rad; times and angles are rounded to it
CENTI = 1e-2  # N, Nm; torques and forces are rounded to it
JOINT_DASHES = (4, 1.5)


def styles() -> str:
    """Return the style sheet, with uPlot's."""
    return _text(VENDORED / "uPlot.min.css") + _text(FOLDER / "closer.css")


def scripts() -> list[str]:
    """Return uPlot under its licence, and our scripts, which use it."""
    plots = f"/*\n{_text(VENDORED / 'uPlot.LICENSE')}*/\n{_text(VENDORED / 'uPlot.iife.min.js')}"
    return [plots, "".join(_text(FOLDER / name) for name in SCRIPTS)]


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8").rstrip() + "\n"


def packed_lines(path: str | Path) -> str:
    """Return the lines of a figure over time [s], packed; empty for other figures.

    path: an SVG that `save` wrote, with its numbers as CSV next to it. Content: panels (name and
    unit), lines (label, colours and dashes), whether there is a band, where no contact is found
    (`_shut`), and columns (`_column`): the time, each line panel by panel, the edges of the band.
    """
    figure = Path(path)
    styles = re.findall(r"<rdf:li>(\w+)</rdf:li>", figure.read_text(encoding="utf-8"))
    if not styles:
        return ""
    data = read_csv(figure.with_suffix(".csv"))
    panels, labels = _panels_and_labels(data.columns[1:], len(styles))
    edges = [edge for edge in BAND_EDGES if column_name(edge, *panels[0]) in data]
    columns = [column_name(line, *panel) for line in [*labels, *edges] for panel in panels]
    return _packed(
        {
            "panels": panels,
            "lines": [_line(*line, len(panels)) for line in zip(labels, styles, strict=True)],
            "band": len(edges) > 0,
            "shut": _column(_shut(data[columns[len(labels) * len(panels) :]]), 1.0),
            "time": _column(data.iloc[:, 0].to_numpy(float), MILLI),
            "columns": [_column(data[name].to_numpy(float)) for name in columns],
        }
    )


def _shut(edges: pd.DataFrame) -> Array:
    """Return 1 at samples at which no contact is found, where all bands are centred on zero, and 0
    at others (N,).
    """
    lower, upper = np.split(edges.to_numpy(float), 2, axis=1)
    shut: Array = (np.nan_to_num(lower + upper) == 0).all(axis=1) & np.isfinite(lower).any(axis=1)
    return shut.astype(float)


def _line(label: str, name: str, panels: int) -> dict[str, Any]:
    """Return label, colours and dashes of a line for the page's scripts; lines in the joints'
    colours also differ by dashes.
    """
    style = LINE_STYLES[name]
    dashes = JOINT_DASHES if len(style.colours) > 1 else style.dashes
    return {"label": label, "colours": style.colours[:panels], "dashes": dashes}


def packed_scene(file: Path) -> str:
    """Return the `Scene` in a file, packed for the page's scripts: its fields, arrays over time as
    a column (`_column`) for each component.
    """
    scene = read_record(Scene, file)
    names = "torque", "force", "std", "hidden", "sensed"
    measured = {name: getattr(scene, name) for name in names}
    return _packed(
        {
            "links": [{name: one.tolist() for name, one in vars(k).items()} for k in scene.links],
            "upright": scene.upright.tolist(),
            "time": _column(scene.time, MILLI),
            "segment": _column(scene.segment.astype(float), 1.0),
            "q": _columns(scene.q, MILLI),
            "link": None if scene.link is None else _column(scene.link.astype(float), 1.0),
            "estimate": scene.estimate,
            "contacts": scene.contacts,
            "alarms": scene.alarms,
            "largest": scene.largest,
            "free": scene.free,
            **{name: _columns(own, CENTI) for name, own in measured.items() if own is not None},
        }
    )


def _panels_and_labels(columns: pd.Index, lines: int) -> tuple[list[tuple[str, str]], list[str]]:
    """Return name and unit of each panel, and the labels of the first `lines` lines."""
    parts = [match.groups() for match in map(LINE_COLUMN.fullmatch, columns) if match]
    panels = [*dict.fromkeys((name, unit) for _, name, unit in parts)]
    return panels, [*dict.fromkeys(label for label, *_ in parts)][:lines]


def _columns(values: Array, level: float) -> list[dict[str, Any]]:
    return [_column(component, level) for component in values.T]


def _column(values: Array, level: float | None = None) -> dict[str, Any]:
    """Return values (N,) quantised and delta-coded: low + level * cumulated steps.

    level: quantum of the values; by default (max - min) / (LEVELS - 1). The step of a value that is
    not finite is None.
    """
    known = np.isfinite(values)
    low, high = (values[known].min(), values[known].max()) if known.any() else (0.0, 0.0)
    if level is None:
        level = float(f"{(high - low) / (LEVELS - 1):.6g}")
    else:
        low = level * np.round(low / level)
    steps = np.full(len(values), None, object)
    steps[known] = np.diff(np.round((values[known] - low) / (level or 1.0)), prepend=0).astype(int)
    return {"low": float(f"{low:.6g}"), "level": level, "steps": steps.tolist()}


def _packed(content: dict[str, Any]) -> str:
    """Return JSON, compressed by zlib, as Base64."""
    text = json.dumps(content, separators=(",", ":"), ensure_ascii=False)
    return b64encode(zlib.compress(text.encode(), 6)).decode()
