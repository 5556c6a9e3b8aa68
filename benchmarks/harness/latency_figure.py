"""The benchmark's figure: error in contact over latency, of all estimators."""

import pandas as pd
from matplotlib.axes import Axes

from ur5lib.report.figures.house_style import JOINT_COLOURS, Drawing, house_style
from ur5rivals.estimators.ours import OURS

LATER_DATA = -12.0  # ms; position of estimates that use later data
UNKNOWN = 62.0  # ms; position of causal estimates with unknown latency


def error_over_latency(table: pd.DataFrame) -> Drawing:
    """Draw a panel for each recording with a force sensor.

    table: of scores, as in results/leaderboard.csv.
    """
    vector = table[(table["component"] == "norm") & (table["during"] == "contact")]
    places = vector["latency_s"].mul(1000).where(vector["causal"] == "yes", LATER_DATA)
    shown = vector.assign(latency_ms=places.fillna(UNKNOWN))
    recordings = shown["recording"].unique()
    with house_style(3.2, 1, len(recordings), sharey=True) as (figure, panels):
        for recording, axis in zip(recordings, panels.flat, strict=True):
            draw_recording(axis, shown[shown["recording"] == recording])
            axis.set_title(str(recording).removeprefix("Movement_").replace("_", " "), fontsize=7)
        panels[0, 0].set_ylabel("RMSE in contact [N]")
    columns = ["recording", "estimator", "causal", "latency_ms", "rmse"]
    return Drawing(figure, shown[columns].reset_index(drop=True))


def draw_recording(axis: Axes, rows: pd.DataFrame) -> None:
    """Draw a dot for each estimator, ours filled, and a line for no force."""
    for name, no_force in rows.loc[rows["estimator"] == "zero", ["estimator", "rmse"]].to_numpy():
        axis.axhline(no_force, color="#999999", linewidth=0.8, dashes=(4, 2))
        rows = rows[rows["estimator"] != name]
    for (place, causal), group in rows.groupby(["latency_ms", "causal"]):
        colour = JOINT_COLOURS[0] if causal == "yes" else JOINT_COLOURS[2]
        ours = group["estimator"].str.startswith(OURS)
        for own, face in ((group[ours], colour), (group[~ours], "white")):
            x = [place] * len(own)
            axis.plot(x, own["rmse"], "o", color=colour, markerfacecolor=face, markersize=4)
    axis.set_yscale("log")
    axis.set_xticks([LATER_DATA, 0, 25, 50, UNKNOWN], ["later\ndata", "0", "25", "50", "?"])
    axis.set_xlim(LATER_DATA - 8, UNKNOWN + 8)
    axis.set_yticks([5, 10, 20, 50, 100], ["5", "10", "20", "50", "100"])
    axis.minorticks_off()
    axis.set_xlabel("latency [ms]")
