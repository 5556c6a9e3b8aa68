"""Pictures of the documents from tables: of built studies, and of pages that benchmarks write."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from benchmarks.harness.markdown import read_page, table_in
from ur5lib import load
from ur5lib.identification.estimation import physical_values
from ur5lib.identification.steady_friction import steady_columns
from ur5lib.records.friction import Friction
from ur5lib.report.figures.house_style import BAND_STYLE, JOINT_COLOURS, Drawing, house_style
from ur5lib.robots.description import described
from ur5lib.robots.statics import link_frames
from ur5lib.tables import read_csv, read_record
from ur5lib.timeseries.metrics import NORMAL95

BLUE, ORANGE, GREEN, PINK = JOINT_COLOURS[:4]
COLOURS = BLUE, ORANGE, GREEN
GREY = "#777777"
MOTIONS = {"at rest": ORANGE, "slow": GREEN, "fast": BLUE}  # of pushes
AXES = {"x": BLUE, "y": ORANGE, "z": GREEN}
ROW = 0.19  # inches; of a row of dots or bars
MARGIN = 0.75  # inches; around the rows
TOTALS = {"total_0": 0.0, "total_0.1": 0.1, "total_0.5": 0.5, "total_1": 1.0}  # rad/s
ESTIMATES = {
    "Fmap": "MAP estimate",
    "ungated_least_squares": "plain least squares",
    "Fu": "controller",
}
LEAST_FORCE = 1.0  # N; an axis is pushed if the mean in contact exceeds this
NO_TERMS = 2  # parameters before the friction terms: torque constant and offset


def rows_of(folder: Path, name: str) -> pd.DataFrame:
    """Return a table of a built study."""
    return read_csv(folder / "tables" / f"{name}.csv")


def dots(axis: Axes, rows: pd.DataFrame, at: Any, colour: str, **style: Any) -> None:
    """Draw values with their intervals, low to high, at places of the other axis."""
    sides = (
        (rows["value"] - rows["low"]).clip(lower=0),
        (rows["high"] - rows["value"]).clip(lower=0),
    )
    axis.errorbar(
        rows["value"], at, xerr=sides, fmt="o", color=colour, capsize=2, markersize=4, **style
    )


def named_rows(axis: Axes, names: Sequence[str]) -> None:
    """Name rows from top to bottom."""
    axis.set_yticks(range(len(names)), [*names])
    axis.set_ylim(len(names) - 0.4, -0.6)


def pushes_by_direction(folder: Path) -> Drawing:
    """Draw the smallest push that is found by its direction, at four postures and in two planes."""
    rows = rows_of(folder, "push_directions")
    postures = rows["posture"].unique()
    with house_style(2.6, 1, len(postures), subplot_kw={"projection": "polar"}) as (figure, panels):
        for axis, posture in zip(panels.flat, postures, strict=True):
            own = rows[rows["posture"] == posture]
            for plane, colour in (("horizontal", BLUE), ("vertical", GREEN)):
                part = own[own["plane"] == plane]
                closed = pd.concat([part, part[:1]])
                axis.plot(
                    np.radians(closed["angle_deg"]), closed["value"], color=colour, label=plane
                )
            axis.set_title(f"{posture},\n{own['motion'].iloc[0]} [N]")
            axis.set_rlabel_position(45)
            axis.set_xticks(np.radians([0, 90, 180, 270]), ["x", "y, z", "−x", "−y, −z"])
            axis.yaxis.set_major_locator(MaxNLocator(3))
        lines, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(lines, labels, loc="outside lower center", frameon=False, ncols=2)
    return Drawing(figure, rows)


def share_found(folder: Path) -> Drawing:
    """Draw the share of trial pushes that is found, over their force."""
    rows = rows_of(folder, "push_curve")
    with house_style(2.8) as (figure, ((axis,),)):
        for motion, own in rows.groupby("motion"):
            axis.semilogx(own["force"], own["share"], color=MOTIONS[str(motion)], label=motion)
        axis.axhline(0.95, color=GREY, linewidth=0.8, dashes=(4, 2))
        axis.set(xlabel="force of a push of one second [N]", ylabel="share found", ylim=(0, 1.02))
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def constants(folder: Path) -> Drawing:
    """Draw each joint's torque constant with its interval, beside the known one; hollow where it
    may not be used.
    """
    rows = rows_of(folder, "torque_constants").rename(columns={"torque_constant": "value"})
    with house_style(ROW * 1.4 * len(rows) + MARGIN) as (figure, ((axis,),)):
        half, at = NORMAL95 * rows["known_std"], np.arange(len(rows))
        axis.barh(at, 2 * half, 0.7, rows["known"] - half, color="#E0E0E0", label="known, 95 %")
        for used, face in (("yes", BLUE), ("no", "white")):
            own = rows["use"] == used
            label = "fitted, may be used" if used == "yes" else "may not be used"
            dots(axis, rows[own], at[own], BLUE, markerfacecolor=face, label=label)
        # the value of a refused constant is the documented one; that of the currents is a column
        against = rows.dropna(subset="contradicted")
        axis.plot(
            against["contradicted"], against.index, "x", color=ORANGE, label="by the currents"
        )
        named_rows(
            axis,
            [
                f"{arm}, joint {joint}"
                for arm, joint in zip(rows["robot"], rows["joint"], strict=True)
            ],
        )
        axis.set_xlabel("torque constant at the joint [Nm/A]")
        figure.legend(loc="outside upper center", frameon=False, ncols=4)
    return Drawing(figure, rows)


def friction_to_type_in(folder: Path, joint: int = 3) -> Drawing:
    """Draw a joint's friction over velocity with its 95 % band, and the totals of the table."""
    table = rows_of(folder, "friction").query("joint == @joint")
    totals = table[table["parameter"].isin([*TOTALS])]
    load_of, arm = totals["load"].iloc[0], table["robot"].iloc[0]
    speeds = np.linspace(0, 1.1, 111)
    curve = load(folder).model(arm).friction(speeds, load=load_of).filter(regex=f"_{joint - 1}$")
    value, error = curve.to_numpy().T
    with house_style(3.0) as (figure, ((axis,),)):
        axis.fill_between(speeds, value - NORMAL95 * error, value + NORMAL95 * error, **BAND_STYLE)
        axis.plot(speeds, value, color="black", label="model.friction, 95 %")
        at = totals["parameter"].map(TOTALS)
        sides = totals["value"] - totals["low"], totals["high"] - totals["value"]
        axis.errorbar(
            at, totals["value"], sides, fmt="o", color=BLUE, capsize=3, label="friction.csv"
        )
        for speed, (name, number) in zip(
            at, totals[["parameter", "value"]].to_numpy(), strict=True
        ):
            axis.annotate(
                f"{name}: {number:.1f}",
                (speed, number),
                (6, -14),
                textcoords="offset points",
                color=BLUE,
            )
        axis.set(
            xlabel=f"velocity of joint {joint} [rad/s]", ylabel="friction [Nm]", ylim=(0, None)
        )
        axis.set_title(f"{arm}, gear loaded by {load_of:.0f} Nm")
        axis.legend(frameon=False, loc="lower right")
    return Drawing(figure, totals)


def friction_terms(folder: Path, joint: int = 3) -> Drawing:
    """Draw the friction of a joint over velocity as the sum of its terms, at its mean load."""
    table = rows_of(folder, "friction").query("joint == @joint")
    path = folder / "parameters" / table["robot"].iloc[0] / "friction.json"
    model = read_record(Friction, path).fit.joints[joint - 1]
    qd = np.linspace(-1.5, 1.5, 301)
    size = table["load"].dropna().iloc[0]
    columns = steady_columns(model.terms, qd, np.sign(qd), size)
    parts = columns * physical_values(model.estimate.coefficients)[NO_TERMS:]
    names = [own for own in table["parameter"] if not own.startswith("total_")][NO_TERMS:]
    with house_style(3.0) as (figure, ((axis,),)):
        axis.plot(qd, parts.sum(axis=1), color="black", linewidth=1.6, label="sum")
        for part, name, colour in zip(parts.T, names, JOINT_COLOURS, strict=False):
            axis.plot(qd, part, color=colour, label=name.replace("velocity_", ""))
        axis.set(xlabel=f"velocity of joint {joint} [rad/s]", ylabel="friction [Nm]")
        axis.legend(frameon=False)
    return Drawing(figure, pd.DataFrame({"velocity [rad/s]": qd, "sum [Nm]": parts.sum(axis=1)}))


def touched_links(folder: Path, force: float = 30.0) -> Drawing:
    """Draw the torques of the joints by a force at the flange, the forearm's middle, and the elbow
    of a UR5, along the diagonal of x, −y and −z.
    """
    arm, q = described("ur5"), np.deg2rad([[0.0, -60.0, 80.0, -110.0, -90.0, 0.0]])
    rotation, (origin,) = link_frames(arm, q)
    places = {"flange": (origin[-1], 6), "forearm": ((origin[2] + origin[3]) / 2, 3)}
    places |= {"elbow": (origin[2], 2)}
    rows, pushed = [], force * np.array([1.0, -1.0, -1.0]) / np.sqrt(3)
    for place, link in places.values():
        # τ_j = z_j · (r_j × F), of the joints before the contact
        arms = np.cross(place - origin[:link], pushed)
        torque = np.zeros(6)
        torque[:link] = (rotation[0, :link, :, 2] * arms).sum(axis=1)
        rows.append(torque)
    with house_style(2.4) as (figure, ((axis,),)):
        for k, (name, torque) in enumerate(zip(places, rows, strict=True)):
            axis.bar(np.arange(1, 7) + 0.25 * (k - 1), torque, 0.22, label=name, color=COLOURS[k])
        axis.axhline(0, color="black", linewidth=0.6)
        axis.set(xlabel="joint", ylabel=f"torque by {force:.0f} N [Nm]")
        axis.legend(frameon=False)
    table = pd.DataFrame(np.transpose(rows), columns=[f"{name} [Nm]" for name in places])
    return Drawing(figure, table.rename_axis("joint").reset_index())


def truths(folder: Path) -> Drawing:
    """Draw (estimate - truth) / standard error of a simulated study."""
    rows = rows_of(folder, "truth").dropna(subset=["truth", "std_error"]).query("std_error > 0")
    rows = rows.assign(errors=(rows["estimate"] - rows["truth"]) / rows["std_error"])
    names = [*rows["quantity"].unique()]
    with house_style(ROW * 1.2 * len(names) + MARGIN) as (figure, ((axis,),)):
        axis.axvspan(-NORMAL95, NORMAL95, **BAND_STYLE)
        axis.plot(
            rows["errors"],
            rows["quantity"].map(names.index),
            "o",
            color=BLUE,
            alpha=0.5,
            markersize=4,
        )
        named_rows(axis, [name.replace("_", " ") for name in names])
        axis.set_xlabel("estimate less truth, in standard errors; green: 95 %")
    return Drawing(figure, rows[["quantity", "errors"]])


def what_to_expect(page: Path) -> Drawing:
    """Draw, by arm, errors of force in contact beside the mean force, and the smallest pushes."""
    rows = table_in(read_page(page), "By arm", "arm")
    with house_style(ROW * 2 * len(rows) + MARGIN, 1, 2, sharey=True) as (figure, ((left, right),)):
        for place, (force, push) in enumerate(rows.iloc[:, [4, 7]].to_numpy()):
            for error, mean in re.findall(r"([\d.]+) of (\d+)", force):
                left.plot(float(error), place, "o", color=BLUE)
                left.plot(float(mean), place, "|", color=GREY, markersize=9)
            for along, motion in re.findall(r"([^()]+) \(([a-z ]+)\)", push):
                values = [float(own) for own in re.findall(r"\d+", along)]
                at = place + 0.2 * ([*MOTIONS].index(motion) - 1)
                right.plot(values, [at] * len(values), "o", color=MOTIONS[motion], markersize=4)
            for axis, text in (
                (left, "" if force else "no force sensor"),
                (right, "" if push else "none stated"),
            ):
                axis.text(
                    0.5, place, text, va="center", color=GREY, transform=axis.get_yaxis_transform()
                )
        named_rows(left, rows["arm"].tolist())
        left.set(xlabel="error in contact; grey: mean force [N]", xlim=(0, None))
        right.set(xlabel="smallest push found along x, y, z [N]", xscale="log")
        for motion, colour in MOTIONS.items():
            right.plot([], [], "o", color=colour, markersize=4, label=motion)
        figure.legend(loc="outside upper right", frameon=False, ncols=3)
    return Drawing(figure, rows)


def live_pushes(page: Path) -> Drawing:
    """Draw the smallest push that the live estimate finds, by arm, motion and axis."""
    rows = table_in(read_page(page), "How good it is", "arm, flange")
    with house_style(ROW * 2 * len(rows) + MARGIN) as (figure, ((axis,),)):
        for shift, (name, colour) in zip((-0.2, 0, 0.2), AXES.items(), strict=True):
            dots(
                axis,
                numbers(rows[name]),
                np.arange(len(rows)) + shift,
                colour,
                label=f"along {name}",
            )
        named_rows(axis, rows["arm, flange"].tolist())
        axis.set(xlabel="smallest push of one second that is found with 95 % [N]", xlim=(0, None))
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def worth_of_next(folder: Path) -> Drawing:
    """Draw the bands after one more recording, relative to the present ones."""
    rows = rows_of(folder, "next_recordings")
    kinds = {"force": BLUE, "current": ORANGE, "mass": GREEN}
    now = rows[rows["after"] == "now"].iloc[0]
    with house_style(ROW * 1.6 * len(rows) + MARGIN) as (figure, ((axis,),)):
        for name, colour in kinds.items():
            axis.plot(
                100 * rows[name] / now[name],
                range(len(rows)),
                "o",
                color=colour,
                label=f"band of a {name}",
            )
        named_rows(axis, rows["after"].tolist())
        axis.set_xlabel("left of the band of today [%]")
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def by_axis(folder: Path, estimates: Mapping[str, str]) -> Drawing:
    """Draw errors of forces in contact by axis and estimate, with the error of zero."""
    rows = rows_of(folder, "force_mae").query("during == 'contact' and kind == 'compensated'")
    rows = rows[rows["estimate"].isin([*estimates]) & rows["component"].str.startswith("F")]
    rows = rows[rows["mean_force"] > LEAST_FORCE]
    places = [*dict.fromkeys(zip(rows["recording"], rows["component"], strict=True))]
    with house_style(ROW * 1.3 * len(places) + MARGIN) as (figure, ((axis,),)):
        for (estimate, label), colour in zip(estimates.items(), JOINT_COLOURS, strict=False):
            own = rows[rows["estimate"] == estimate]
            at = [
                places.index(place)
                for place in zip(own["recording"], own["component"], strict=True)
            ]
            axis.plot(own["mae"], at, "o", color=colour, label=label)
            axis.plot(own["zero_mae"], at, "|", color=GREY, markersize=9)
        named_rows(axis, [f"{recording}, {part}" for recording, part in places])
        axis.set_xlabel("mean error in contact; grey: of stating no force [N]")
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def world(page: Path) -> Drawing:
    """Draw the error of each situation over that of plain least squares, and the share in band."""
    rows = table_in(read_page(page), "A world of situations").set_index("situation")
    ratio = pd.to_numeric(rows["ours / plain"], errors="coerce")
    inside = pd.to_numeric(rows["inside"], errors="coerce")
    with house_style(ROW * len(rows) + MARGIN, 1, 2, sharey=True, width_ratios=[3, 1]) as (
        figure,
        ((left, right),),
    ):
        at = np.arange(len(rows))
        left.barh(at, ratio - 1, 0.7, 1, color=np.where(ratio < 1, GREEN, ORANGE))
        left.axvline(1, color="black", linewidth=0.8)
        right.axvspan(0.9, 0.99, **BAND_STYLE)
        right.plot(inside, at, "o", color=BLUE, markersize=4)
        named_rows(left, rows.index.tolist())
        left.set_xlabel("error over that of plain least squares")
        right.set_xlabel("share in the 95 % band")
    return Drawing(figure, rows)


def numbers(cells: pd.Series) -> pd.DataFrame:
    """Return value, low and high of cells such as `3.7 (3.6 to 3.9)` or `5.4 ± 2.9`."""
    found = cells.str.replace("−", "-").str.extract(
        r"^\**(-?[\d.]+)\**(?: \(([-\d.]+) to ([-\d.]+)\)| ± ([\d.]+))?"
    )
    value, low, high, half = (found[column].astype(float) for column in found)
    return pd.DataFrame(
        {"value": value, "low": low.fillna(value - half), "high": high.fillna(value + half)}
    )


def simulated_arms(page: Path) -> Drawing:
    """Draw the error of each estimator on simulated arms, by pushed place."""
    rows = table_in(read_page(page), "Simulated arms")
    places = {"flange": BLUE, "tool": GREEN, "elbow": ORANGE}
    with house_style(ROW * len(rows) + MARGIN) as (figure, ((axis,),)):
        for place, colour in places.items():
            own = numbers(rows[f"RMSE at the {place} [N]"])
            dots(axis, own, np.arange(len(rows)), colour, label=f"pushed at the {place}")
        named_rows(axis, rows["estimator"].tolist())
        axis.set_xlabel("error of the force [N], with 95 %")
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def torque_from_motion(page: Path) -> Drawing:
    """Draw the error of predicted torques of each joint and model, over that of a constant."""
    rows = table_in(read_page(page), "Torque from motion", "model")
    rows = rows[rows["1"].str.match(r"[\d.]+$")]
    with house_style(ROW * 1.3 * len(rows) + MARGIN) as (figure, ((axis,),)):
        at = np.arange(len(rows))
        for joint, colour in zip(map(str, range(1, 7)), JOINT_COLOURS, strict=False):
            axis.plot(
                rows[joint].astype(float),
                at,
                "o",
                color=colour,
                markersize=4,
                label=f"joint {joint}",
            )
        axis.plot(
            numbers(rows["mean"])["value"], at, "|", color="black", markersize=12, label="mean"
        )
        named_rows(axis, rows["model"].tolist())
        axis.set_xlabel("NRMSE on motions that no fit has seen")
        axis.set_xlim(left=0)
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def published_friction(page: Path) -> Drawing:
    """Draw friction of a Stäubli TX40 with its interval, over the published values."""
    rows = table_in(read_page(page), "Friction beside published values")
    rows = rows[rows["value"].str.match("viscous|coulomb")]
    printed = rows["published"].astype(float)
    own = numbers(rows["ours, 95 %"]).div(printed, axis=0)
    with house_style(ROW * len(rows) + MARGIN) as (figure, ((axis,),)):
        axis.axvline(1, color=GREY, linewidth=0.8)
        dots(axis, own, np.arange(len(rows)), BLUE)
        named_rows(
            axis, (rows["of"] + ", " + rows["value"].str.replace(r" \[.*", "", regex=True)).tolist()
        )
        axis.set_xlabel("fitted, over the published value, with 95 %")
    return Drawing(figure, rows)


def parts_of_estimate(page: Path) -> Drawing:
    """Draw error, share in band and contacts found of the MAP estimate without each part."""
    rows = table_in(read_page(page), "Evidence for the methods", "without")
    with house_style(ROW * len(rows) + MARGIN, 1, 3, sharey=True) as (
        figure,
        ((left, middle, right),),
    ):
        at = np.arange(len(rows))
        for axis, column in zip((left, middle, right), (1, 2, 3), strict=True):
            first = rows.iloc[:, column].str.extract(r"^([\d.]+)")[0].astype(float)
            axis.axvline(first.iloc[0], color=GREY, linewidth=0.8)
            axis.plot(first, at, "o", color=BLUE)
        named_rows(left, ("without " + rows["without"]).tolist())
        left.set_xlabel("error of the force [N]")
        middle.set_xlabel("share in the 95 % band")
        right.set_xlabel("contacts found, of 30")
    return Drawing(figure, rows)


def states_a_second(page: Path) -> Drawing:
    """Draw states a second of processor and GPU over the number of states."""
    rows = table_in(read_page(page), "Evidence for the methods", "states")
    count = rows["states"].str.replace(",", "").astype(float)
    kinds = {"processor": GREY, "GPU with transfers": BLUE, "GPU": GREEN, "MJX": ORANGE}
    with house_style(2.8, 1, 2, sharey=True) as (figure, (panels,)):
        for axis, precision in zip(panels, ("float64", "float32"), strict=True):
            own = rows["precision"] == precision
            for kind, colour in kinds.items():
                speed = 1e6 * pd.to_numeric(rows.loc[own, kind], errors="coerce")
                if speed.notna().any():
                    axis.loglog(count[own], speed, "o-", color=colour, label=kind)
            axis.set(title=precision, xlabel="states")
        panels[0].set_ylabel("states a second")
        panels[1].legend(frameon=False)
    return Drawing(figure, rows)
