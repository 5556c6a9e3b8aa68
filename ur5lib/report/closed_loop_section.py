"""The report's section on the closed loop: Table 5.5, gains, Figures 5.9 and 5.10."""

from pathlib import Path

import pandas as pd

from ur5lib.report.cells import number
from ur5lib.report.document import Block, Cell, Paragraph, Picture, Table

INTRODUCTION = (
    "Each joint is simulated as the double integrator that feedback linearisation leaves "
    "(Equations 2.70 to 2.80), with the target acceleration fed forward, exactly between samples. "
    "The link model cancels, so gains do not depend on it; what Models A, B and C differ in are "
    "their printed gains. “Target” is the error of the targets themselves: a loop that follows "
    "perfectly. A gain stands as a number where the range that fits equally well (95 %) is less "
    "than an order of magnitude wide; else that range is the result."
)
NO_TARGETS = "Targets were not recorded: there is no closed loop to compare with."
QUANTITIES = {"q": ("positions", "rad", 5), "qd": ("velocities", "rad/s", 4)}


def closed_loop_blocks(
    closed_loop: pd.DataFrame, gains: pd.DataFrame, published: pd.DataFrame, figures: Path
) -> list[Block]:
    """closed_loop, gains, published: closed_loop_mae, gains, published_gains."""
    if closed_loop.empty:
        return [Paragraph(NO_TARGETS)]
    blocks: list[Block] = [Paragraph(INTRODUCTION)]
    printed = closed_loop[closed_loop["printed"].notna()]
    for recording in printed["recording"].unique():
        rows = closed_loop[closed_loop["recording"] == recording]
        blocks += [_printed_table(recording, rows, quantity) for quantity in QUANTITIES]
        blocks += _pictures(recording, figures / recording)
    blocks.append(_gain_table(gains))
    if len(published):
        blocks.append(Paragraph(_fits(published)))
    return blocks


def _printed_table(recording: str, rows: pd.DataFrame, quantity: str) -> Table:
    """Table 5.5: printed and rebuilt, the estimated gains and the targets beside them."""
    name, unit, digits = QUANTITIES[quantity]
    part = rows[rows["quantity"] == quantity].set_index(["model", "joint"])
    models = part.index.unique("model")
    printed = [model for model in models if part.loc[model, "printed"].notna().any()]
    header = [f"{model} {what}" for model in printed for what in ("printed", "rebuilt")]
    others = [model for model in models if model not in printed]
    body = []
    for joint in range(1, 7):
        line = [Cell(str(joint))]
        for model in printed:
            row = part.loc[(model, joint)]
            line += [number(row["printed"], 4), number(row["mae"], digits)]
        body.append(line + [number(part.loc[(model, joint), "mae"], digits) for model in others])
    caption = f"Error of {name} in closed loop [{unit}] on {recording}, beside Table 5.5."
    return Table(caption, ["joint", *header, *others], body)


def _gain_table(gains: pd.DataFrame) -> Table:
    body = [
        [Cell(recording), Cell(gain), *(_gain(row) for row in rows.itertuples())]
        for (recording, gain), rows in gains.groupby(["recording", "gain"], sort=False)
    ]
    caption = (
        "Gains K0 (position, 1/s²) and K1 (velocity, 1/s): value ± standard error where "
        "determined, else the range that fits equally well, “any” where it spans all that was "
        "searched. Recordings that contradict one another in them say that the arm's loop is not "
        "this one."
    )
    return Table(caption, ["recording", "gain", *(f"joint {j}" for j in range(1, 7))], body)


def _gain(row: pd.Series) -> Cell:
    if row.determined == "yes":
        return Cell(f"{row.value:.3g} ± {row.std_error:.2g}")
    if pd.isna(row.low) and pd.isna(row.high):
        return Cell("any")
    if pd.isna(row.high):
        return Cell(f"> {row.low:.2g}")
    if pd.isna(row.low):
        return Cell(f"< {row.high:.2g}")
    return Cell(f"{row.low:.2g} to {row.high:.2g}")


def _fits(published: pd.DataFrame) -> str:
    """On how many joints of how many recordings published gains fit as well as the best."""
    parts = [
        f"{model} on {int((rows['fits'] == 'yes').sum())} of {len(rows)}"
        for model, rows in published.groupby("model", sort=False)
    ]
    return (
        "The published gains fit as well as the best ones do, counted over joints and recordings: "
        f"{', '.join(parts)}."
    )


def _pictures(recording: str, folder: Path) -> list[Block]:
    return [
        Picture(
            f"Errors of {name} on {recording} (after Figure {figure}).",
            folder / f"{name}.svg",
            f"Six panels, one a joint, over time: what the targets and the loop miss of {name}.",
        )
        for name, figure in (("positions", "5.9"), ("velocities", "5.10"))
    ]
