"""The report's section on joint torques: Table 5.6, Figures 5.11 and 5.12."""

from pathlib import Path

import pandas as pd

from ur5lib.report.cells import extremes, number, signed
from ur5lib.report.document import Block, Cell, Paragraph, Picture, Table

INTRODUCTION = (
    "Mean absolute error of each link model against the controller's own torque (target_moment, "
    "itself a model). “Zero” is the error of a torque of zero. ▼ marks the smallest error of the "
    "compared models in a row, ▲ the largest."
)


def torque_blocks(
    torque: pd.DataFrame, rotors: pd.DataFrame, parameters: pd.DataFrame, figures: Path
) -> list[Block]:
    """torque, rotors, parameters: torque_mae, rotor_inertia, parameters; figures: a folder each."""
    blocks: list[Block] = [Paragraph(INTRODUCTION)]
    blocks += [_rotor_table(rotors)] if len(rotors) else []
    blocks += [Paragraph(_identified(parameters))] if len(parameters) else []
    for recording, rows in torque.groupby("recording", sort=False):
        computed = rows[rows["mae"].notna()]
        if rows["printed"].notna().any():
            blocks.append(_printed_table(recording, rows))
            blocks += _pictures(recording, figures / recording)
        blocks.append(_table(recording, computed))
    return blocks


def _printed_table(recording: str, rows: pd.DataFrame) -> Table:
    """Table 5.6: printed, rebuilt, their difference."""
    target = rows[(rows["motion"] == "closed_loop") & rows["mae"].notna() & rows["printed"].notna()]
    others = rows[rows["mae"].isna()]  # printed, but not to be rebuilt
    models, older = target["model"].unique(), others["model"].unique()
    header = ["joint", *(f"{model} printed" for model in older)]
    header += [f"{model} {what}" for model in models for what in ("printed", "rebuilt", "diff.")]
    body = []
    for joint, group in target.groupby("joint"):
        line = [Cell(str(joint))]
        line += [number(value, 4) for value in others.loc[others["joint"] == joint, "printed"]]
        marks = extremes(dict(zip(group["model"], group["mae"], strict=True)))
        for row in group.itertuples():
            line += [
                number(row.printed, 4),
                number(row.mae, 4, marks[row.model]),
                signed(row.mae - row.printed, 4),
            ]
        body.append([*line, number(group["zero_mae"].iloc[0], 4)])
    caption = (
        f"Torque error [Nm] on {recording} beside Table 5.6: printed, rebuilt in closed loop with "
        "the printed gains, and their difference. [21] is an older model whose equations are not "
        "printed."
    )
    return Table(caption, [*header, "zero"], body)


def _table(recording: str, rows: pd.DataFrame) -> Table:
    """Every model, at the target and at the measured motion."""
    rows = rows[rows["motion"] != "closed_loop"]
    motions, models = rows["motion"].unique(), rows["model"].unique()
    errors = rows.set_index(["joint", "motion", "model"])["mae"]
    header = ["joint", *(f"{model}, {motion}" for motion in motions for model in models), "zero"]
    body = []
    for joint, group in rows.groupby("joint"):
        line = [Cell(str(joint))]
        for motion in motions:
            values = {model: errors[joint, motion, model] for model in models}
            marks = extremes(values)
            line += [number(values[model], 4, marks[model]) for model in models]
        body.append([*line, number(group["zero_mae"].iloc[0], 4)])
    caption = f"Torque error [Nm] on {recording}, at the {' and at the '.join(motions)} motion."
    return Table(caption, header, body)


def _rotor_table(rotors: pd.DataFrame) -> Table:
    """The fitted rotor inertias, and the terms that should be zero."""

    def fitted(row: pd.Series, value: str, std: str) -> Cell:
        return Cell(f"{row[value]:.4f} ± {row[std]:.4f}".replace("-", "−"))

    terms = {"offset [Nm]": "offset", "Coulomb [Nm]": "coulomb", "viscous [Nm s/rad]": "viscous"}
    body = [
        [Cell(row["robot"]), Cell(str(row["joint"])), fitted(row, "value", "std_error")]
        + [fitted(row, term, f"{term}_std_error") for term in terms.values()]
        for _, row in rotors.iterrows()
    ]
    caption = (
        "Inertia of the motors' rotors seen through their gears, fitted to what rigid links leave "
        "of the controller's torque (erratum 8), with the terms that should be zero (± standard "
        "error)."
    )
    return Table(caption, ["arm", "joint", "inertia [kg m²]", *terms], body)


def _identified(parameters: pd.DataFrame) -> str:
    determined = (parameters["determined"] == "yes").sum()
    return (
        f"Model “identified” was fitted to the controller's torques of the recordings for fitting: "
        f"{determined} of its {len(parameters)} base parameters are determined by them "
        "(tables/parameters.csv). It lies, with every other model, in parameters/<arm>/arm.yaml "
        "and as URDF beside it."
    )


def _pictures(recording: str, folder: Path) -> list[Block]:
    return [
        Picture(
            f"Torque of the chosen model and of the controller on {recording} (after Figure 5.11).",
            folder / "torques.svg",
            "Six panels, one a joint: the controller's torque and the model's over time.",
        ),
        Picture(
            f"What the chosen model misses of the controller's torque on {recording} (after "
            "Figure 5.12).",
            folder / "torque_errors.svg",
            "Six panels, one a joint: the controller's torque minus the model's over time.",
        ),
    ]
