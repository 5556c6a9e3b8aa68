"""The report's section on contact forces: Tables 6.1 and 6.2, Figures 6.4 to 6.9."""

from pathlib import Path

import pandas as pd

from ur5lib.report.cells import extremes, number, signed
from ur5lib.report.document import Block, Cell, Paragraph, Picture, Table

PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}
NEW = {"Fmap": "F^map", "observer": "observer", "repeat": "repeat-aware"}
ESTIMATES = PUBLISHED | NEW
KINDS = {
    "printed": "the raw sensor",
    "corrected": "the sensor less its reading at the start",
    "compensated": "the sensor less bias and tool weight",
}
FIGURES = {"mae": ("Mean absolute error", "6.1"), "max": ("Largest absolute error", "6.2")}
UNITS = {"F": "N", "n": "Nm"}
PICTURES = {  # file: what it shows, after which figures
    "forces": ("Force sensor, F̂ᵘ and F̂", "6.4 and 6.5"),
    "forces_friction": ("Force sensor and F̂*", "6.6 and 6.7"),
    "force_errors": ("Errors of F̂ᵘ, F̂ and F̂*", "6.8 and 6.9"),
}
INTRODUCTION = (
    "Wrenches are what the environment does to the arm, base axes, at the origin of frame 6. "
    "Three published estimates: F̂ᵘ, the controller's own; F̂, from motor currents without "
    "friction (Equation 6.8); F̂*, with friction (6.9), both with the thesis's printed constants. "
    "“As printed” keeps what the published script does: raw sensor, causal filter, its line for "
    "joint 6 and its lag of the Jacobian (errata 5, 6, 7 and 13); “corrected” filters without "
    "delay and uses the printed formula at the measured motion. Three new ones, from the external "
    "torque k (i_predicted − i): F^map, the most probable wrench given how far that torque is "
    "from zero on recordings without contact; the same of the momentum observer's torque; and, "
    "where the study has contact-free runs of the same trajectory, F^map with their residual "
    "taken off. Nothing of them is fitted on recordings with contact. “Zero” is the error of an "
    "estimate that always says “no force”; skill is 1 − MAE / MAE of zero. ▼ marks the smallest "
    "error in a row, ▲ the largest."
)
NO_SENSOR = "No recording of this study has a working force sensor to compare with."


def force_blocks(force: pd.DataFrame, detection: pd.DataFrame, figures: Path) -> list[Block]:
    """force, detection: force_mae and detection; figures: holds a folder for each recording."""
    blocks: list[Block] = [Paragraph(INTRODUCTION)]
    if force.empty:
        blocks.append(Paragraph(NO_SENSOR))
    for recording, rows in force.groupby("recording", sort=False):
        blocks.append(_estimate_picture(recording, figures / recording))
        blocks.append(_bands(recording, rows))
        for figure in FIGURES:
            printed = rows[rows[f"printed_{figure}"].notna()]
            if len(printed):
                blocks.append(_printed_table(recording, printed, figure))
            blocks += [_table(recording, rows, figure, kind) for kind in KINDS]
        if rows["printed_mae"].notna().any():
            blocks += _pictures(recording, figures / recording)
    return blocks + ([_detections(detection)] if len(detection) else [])


def _printed_table(recording: str, rows: pd.DataFrame, figure: str) -> Table:
    """Table 6.1 or 6.2: printed, rebuilt, their difference."""
    known = _known(rows)
    header = ["component"]
    header += [f"{ESTIMATES[x]} {what}" for x in known for what in ("printed", "rebuilt", "diff.")]
    body = []
    for component, group in rows.groupby("component", sort=False):
        part = group.set_index("estimate")
        line = [_component(component)]
        marks = extremes(part[figure].to_dict())
        for name in known:
            printed, value = part.loc[name, [f"printed_{figure}", figure]]
            line += [
                number(printed, 2),
                number(value, 2, marks[name]),
                signed(100 * (value / printed - 1), 1, " %"),
            ]
        body.append([*line, number(group[f"zero_{figure}"].iloc[0], 2)])
    name, table = FIGURES[figure]
    caption = f"{name} on {recording}, as printed, beside Table {table}."
    return Table(caption, [*header, "zero"], body)


def _table(recording: str, rows: pd.DataFrame, figure: str, kind: str) -> Table:
    """Every estimate against one reference."""
    part = rows[rows["kind"] == kind]
    known = _known(part)
    values = part.set_index(["component", "estimate"])[[figure, f"zero_{figure}"]]
    body = []
    for component in part["component"].unique():
        errors = {name: values.loc[(component, name), figure] for name in known}
        marks = extremes(errors)
        line = [_component(component), *(number(errors[x], 2, marks[x]) for x in known)]
        body.append([*line, number(values.loc[(component, known[0]), f"zero_{figure}"], 2)])
    header = ["component", *(ESTIMATES[name] for name in known), "zero"]
    return Table(f"{FIGURES[figure][0]} on {recording} against {KINDS[kind]}.", header, body)


def _bands(recording: str, rows: pd.DataFrame) -> Table:
    """The new estimates: skill, gain, correlation, and what their bands hold."""
    part = rows[(rows["kind"] == "compensated") & rows["coverage95"].notna()]
    body = [
        [
            Cell(ESTIMATES[row.estimate]),
            _component(row.component),
            *(number(getattr(row, name), 2) for name in ("skill", "correlation", "gain")),
            *(number(100 * getattr(row, f"coverage{x}"), 0) for x in (50, 80, 95)),
        ]
        for row in part.itertuples()
    ]
    header = ["estimate", "component", "skill", "correlation", "gain"]
    header += [f"in {x} % band [%]" for x in (50, 80, 95)]
    caption = (
        f"The new estimates on {recording}, against the sensor less bias and tool weight: stated "
        "bands beside what they hold."
    )
    return Table(caption, header, body)


def _detections(detection: pd.DataFrame) -> Table:
    """Contacts of at least 15 N found, false alarms, delay, and the smallest force found."""
    body = [
        [
            Cell(row.recording),
            Cell(ESTIMATES[row.estimate]),
            Cell("–" if pd.isna(row.contacts) else f"{row.found:.0f} of {row.contacts:.0f}"),
            number(row.precision, 2),
            number(row.false_alarms_per_min, 1),
            number(row.alarms_per_min, 1),
            number(row.median_delay_s, 2),
            *(number(getattr(row, f"smallest_force_95_{axis}"), 0) for axis in "xyz"),
        ]
        for row in detection.itertuples()
    ]
    header = ["recording", "estimate", "contacts found", "precision", "false alarms [1/min]"]
    header += ["alarms [1/min]", "median delay [s]", *(f"found at 95 %, {a} [N]" for a in "xyz")]
    caption = (
        "Contacts of 15 N and more by the sensor; without one, alarms alone. The delay counts from "
        "3 N by the sensor; estimates are offline and may be first. “Found at 95 %”: the smallest "
        "push along an axis that is found with that probability on a contact-free motion."
    )
    return Table(caption, header, body)


def _known(rows: pd.DataFrame) -> list[str]:
    """The estimates that were made, in the report's order."""
    return [name for name in ESTIMATES if name in set(rows["estimate"])]


def _component(name: str) -> Cell:
    return Cell(f"{name} [{UNITS[name[0]]}]")


def _estimate_picture(recording: str, folder: Path) -> Picture:
    return Picture(
        f"Force sensor and the new estimates on {recording}, with the 95 % band of the last; grey "
        "where the arm is near a singularity and some force leaves no trace.",
        folder / "forces_estimated.svg",
        "Six panels over time, forces left and moments right: sensor, estimates and band.",
    )


def _pictures(recording: str, folder: Path) -> list[Block]:
    return [
        Picture(
            f"{content} on {recording}, {how} (after Figures {numbers}).",
            folder / f"{name}_{kind}.svg",
            f"Six panels, forces left and moments right, over time: {content}, {how}.",
        )
        for kind, how in (("printed", "as printed"), ("corrected", "corrected"))
        for name, (content, numbers) in PICTURES.items()
    ]
