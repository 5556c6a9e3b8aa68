"""The report's section on contact forces: Tables 6.1 and 6.2, Figures 6.4 to 6.9."""

from pathlib import Path

import pandas as pd

from ur5lib.report.cells import extremes, number, signed
from ur5lib.report.document import Block, Cell, Paragraph, Picture, Table

ESTIMATES = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}
KINDS = {"printed": "as printed", "corrected": "corrected"}
FIGURES = {"mae": ("Mean absolute error", "6.1"), "max": ("Largest absolute error", "6.2")}
UNITS = {"F": "N", "n": "Nm"}
PICTURES = {  # file: what it shows, after which figures
    "forces": ("Force sensor, F̂ᵘ and F̂", "6.4 and 6.5"),
    "forces_friction": ("Force sensor and F̂*", "6.6 and 6.7"),
    "force_errors": ("Errors of F̂ᵘ, F̂ and F̂*", "6.8 and 6.9"),
}
INTRODUCTION = (
    "Three estimates of the contact wrench against the force sensor: F̂ᵘ, the controller's own; F̂, "
    "from motor currents without friction (Equation 6.8); F̂*, with friction (6.9), both with the "
    "thesis's printed constants. “As printed” keeps what the published script does: raw sensor, "
    "causal filter, its line for joint 6 and its lag of the Jacobian (errata 5, 6, 7 and 13). "
    "“Corrected” removes the sensor's bias, filters without delay and uses the printed formula at "
    "the measured motion. “Zero” is the error of an estimate that always says “no force”. ▼ marks "
    "the smallest error of the three estimates in a row, ▲ the largest."
)
NO_SENSOR = "No recording of this study has a working force sensor to compare with."


def force_blocks(force: pd.DataFrame, figures: Path) -> list[Block]:
    """force: the table force_mae; figures: holds a folder for each recording."""
    if force.empty:
        return [Paragraph(NO_SENSOR)]
    blocks: list[Block] = [Paragraph(INTRODUCTION)]
    for recording, rows in force.groupby("recording", sort=False):
        for figure in FIGURES:
            printed = rows[rows[f"printed_{figure}"].notna()]
            if len(printed):
                blocks.append(_printed_table(recording, printed, figure))
            blocks.append(_table(recording, rows, figure))
        blocks += _pictures(recording, figures / recording)
    return blocks


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


def _table(recording: str, rows: pd.DataFrame, figure: str) -> Table:
    """Both kinds side by side."""
    known = _known(rows)
    columns = [*(ESTIMATES[name] for name in known), "zero"]
    header = ["component", *(f"{column} {kind}" for kind in KINDS.values() for column in columns)]
    values = rows.set_index(["kind", "estimate", "component"])[[figure, f"zero_{figure}"]]
    body = []
    for component in rows["component"].unique():
        line = [_component(component)]
        for kind in KINDS:
            errors = {name: values.loc[(kind, name, component), figure] for name in known}
            marks = extremes(errors)
            line += [number(errors[name], 2, marks[name]) for name in known]
            line.append(number(values.loc[(kind, known[0], component), f"zero_{figure}"], 2))
        body.append(line)
    return Table(f"{FIGURES[figure][0]} on {recording}, as printed and corrected.", header, body)


def _known(rows: pd.DataFrame) -> list[str]:
    """The estimates that were made of every kind, in the report's order."""
    made = set.intersection(*(set(part["estimate"]) for _, part in rows.groupby("kind")))
    return [name for name in ESTIMATES if name in made]


def _component(name: str) -> Cell:
    return Cell(f"{name} [{UNITS[name[0]]}]")


def _pictures(recording: str, folder: Path) -> list[Block]:
    return [
        Picture(
            f"{content} on {recording}, {how} (after Figures {numbers}).",
            folder / f"{name}_{kind}.svg",
            f"Six panels, forces left and moments right, over time: {content}, {how}.",
        )
        for kind, how in KINDS.items()
        for name, (content, numbers) in PICTURES.items()
    ]
