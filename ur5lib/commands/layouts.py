"""Layouts for exported MCAP files: which panels Foxglove and PlotJuggler open."""

import json
from collections.abc import Collection, Mapping
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ur5lib.commands.foxglove import ARROWS, BASE
from ur5lib.force.estimators import LEADING

Columns = Mapping[str, Collection[str]]  # of each table
# Title: table and beginning of the columns' names, of those that are plotted together.
PLOTS: dict[str, list[tuple[str, str]]] = {
    "force [N]": [("forces", f"{LEADING}_F"), ("sensor", "compensated_F")],
    "moment [Nm]": [("forces", f"{LEADING}_n"), ("sensor", "compensated_n")],
    "log-odds of contact": [("forces", f"log_odds_{LEADING}")],
    "current [A]": [("signals", "actual_current_"), ("currents", "predicted_current_")],
    "torque [Nm]": [("signals", "actual_torque_"), ("currents", "predicted_torque_")],
    "angle [rad]": [("signals", "actual_q_")],
}


def plotted(tables: Columns) -> dict[str, list[tuple[str, str]]]:
    """Return table and column of the lines of each plot; those of `PLOTS` that are there."""
    plots = {
        title: [
            (table, column)
            for table, start in parts
            for column in tables.get(table, ())
            if column.startswith(start)
        ]
        for title, parts in PLOTS.items()
    }
    return {title: lines for title, lines in plots.items() if lines}


def foxglove_layout(tables: Columns) -> str:
    """Return a layout of Foxglove: the arm with the forces' arrows, and plots beside it."""
    panels: dict[str, Any] = {"3D!arm": _scene()}
    for number, (title, lines) in enumerate(plotted(tables).items(), 1):
        paths = [{"value": f"/{table}.{column}", "enabled": True} for table, column in lines]
        panels[f"Plot!{number}"] = {"title": title, "paths": paths, "xAxisVal": "timestamp"}
    first, *plots = panels
    layout = first if not plots else _split("row", first, _stacked(plots), 45)
    content = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": layout,
    }
    return json.dumps(content, indent=1, ensure_ascii=False)


def _scene() -> dict[str, Any]:
    """Return the settings of the 3D panel: the URDF's joints follow the topic of their states."""
    arm = {
        "layerId": "foxglove.Urdf",
        "instanceId": "arm",
        "label": "arm",
        "visible": True,
        "sourceType": "topic",
        "topic": "/robot_description",
        "controlMode": "jointStates",
        "jointStatesTopic": "/joint_states",
        "displayMode": "auto",
    }
    grid = {"layerId": "foxglove.Grid", "instanceId": "grid", "visible": True, "size": 2}
    return {
        "followTf": BASE,
        "followMode": "follow-none",
        "cameraState": {"distance": 2.5, "phi": 65, "thetaOffset": 45, "perspective": True},
        "layers": {"grid": grid, "arm": arm},
        "topics": {topic: {"visible": True} for topic in ARROWS},
    }


def _stacked(panels: list[str]) -> Any:
    """Return panels above each other, equally high."""
    first, *others = panels
    return _split("column", first, _stacked(others), 100 / len(panels)) if others else first


def _split(direction: str, first: str, second: Any, share: float) -> dict[str, Any]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": share}


def plotjuggler_layout(tables: Columns) -> str:
    """Return a layout of PlotJuggler 3: a tab with all plots above each other."""
    root = Element("root")
    window = SubElement(root, "tabbed_widget", {"parent": "main_window", "name": "Main Window"})
    tab = SubElement(window, "Tab", tab_name="recording", containers="1")
    plots = plotted(tables)
    sizes = ";".join([str(1 / len(plots))] * len(plots)) if plots else ""
    container = SubElement(tab, "Container")
    stack = SubElement(
        container, "DockSplitter", orientation="-", count=str(len(plots)), sizes=sizes
    )
    for title, lines in plots.items():
        area = SubElement(stack, "DockArea", name=title)
        plot = SubElement(area, "plot", style="Lines", mode="TimeSeries")
        for table, column in lines:
            SubElement(plot, "curve", name=f"/{table}/{column}")
    SubElement(window, "currentTabIndex", index="0")
    SubElement(root, "use_relative_time_offset", enabled="1")
    indent(root)
    return tostring(root, encoding="unicode")
