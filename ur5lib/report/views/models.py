"""Link models: rotors, the identified model, and their torques compared with the controller's."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.cells import extremes, number, signed, with_error
from ur5lib.report.document import Cell
from ur5lib.report.results import NOTHING, Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say


def compared(results: Results) -> list[str]:
    """Return recordings with a table of torques: printed errors, and validate recordings."""
    torque = results.tables["torque_mae"]
    recordings = [*torque.loc[torque["mae"].notna(), "recording"].unique()]
    others = [name for name in results.with_role("validate") if name in recordings]
    return results.shown([*results.printed("torque_mae"), *others]) or results.shown(recordings, 1)


def mean_errors(results: Results) -> Body:
    """Return the mean over recordings by joint (row), model and motion."""
    torque = results.tables["torque_mae"]
    torque = torque[torque["mae"].notna() & (torque["motion"] != "closed_loop")]
    if torque.empty:
        return NOTHING
    mean = torque.groupby(["joint", "motion", "model"], sort=False, as_index=False)[
        ["mae", "zero_mae"]
    ].mean()
    return _errors(mean)


def errors(results: Results, recording: str) -> Body:
    """Return every model's error on a recording, at the target and at the measured motion."""
    rows = results.rows("torque_mae", recording=recording)
    return _errors(rows[rows["mae"].notna() & (rows["motion"] != "closed_loop")])


def _errors(rows: pd.DataFrame) -> Body:
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
    return Body(header, body)


def printed_errors(results: Results, recording: str) -> Body:
    """Return Table 5.6: printed, rebuilt, and their difference."""
    rows = results.rows("torque_mae", recording=recording)
    target = rows[(rows["motion"] == "closed_loop") & rows["mae"].notna() & rows["printed"].notna()]
    others = rows[rows["mae"].isna()]  # printed, but cannot be rebuilt
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
    return Body([*header, "zero"], body)


def rotors(results: Results) -> Body:
    """Return the fitted rotor inertias, and the terms that should be zero."""
    columns: dict[str, Column] = {
        "arm": "robot",
        "joint": "joint",
        "inertia [kg m²]": lambda row: with_error(row.value, row.std_error, 4),
        "offset [Nm]": lambda row: with_error(row.offset, row.offset_std_error, 4),
        "Coulomb [Nm]": lambda row: with_error(row.coulomb, row.coulomb_std_error, 4),
        "viscous [Nm s/rad]": lambda row: with_error(row.viscous, row.viscous_std_error, 4),
    }
    return tabulated(results.tables["rotor_inertia"].itertuples(), columns)


def excitation(results: Results) -> Body:
    """Return how well the recordings excite the identified parameters, one row per arm."""
    columns: dict[str, Column] = {
        "arm": "robot",
        "combinations": "combinations",
        "not excited": "undetermined",
        "gravity": lambda row: number(row.gravity, 1),
        "inertia": lambda row: number(row.inertia, 1),
        "rotors": lambda row: number(row.rotors, 1),
        "all": lambda row: number(row.all, 1),
    }
    return tabulated(results.tables["excitation"].itertuples(), columns)


def advice(results: Results) -> Iterator[Sentence]:
    """Return advice on what to record to determine more of an arm."""
    for row in results.tables["excitation"].dropna(subset="advice").itertuples():
        yield say("models.advice", row=row)


def identified(results: Results) -> Iterator[Sentence]:
    """Report how many parameters of an arm the recordings determine."""
    for robot, parameters in results.tables["parameters"].groupby("robot", sort=False):
        determined = (parameters["determined"] == "yes").sum()
        words = {"robot": robot, "determined": int(determined), "count": len(parameters)}
        yield say("models.identified", **words)
        if determined < len(parameters):
            yield say("models.undetermined")
        yield say("models.files", robot=robot)
