"""The report's section on friction and currents: Figures 6.1 and 6.2, constants, prediction."""

from pathlib import Path

import pandas as pd

from ur5lib.report.cells import extremes, number
from ur5lib.report.document import Block, Cell, Paragraph, Picture, Table

INTRODUCTION = (
    "Motor current is predicted from motion: i = (τ + τ_friction − b) / k, fitted over all "
    "recordings for fitting at once, low-passed without delay. Friction terms besides Coulomb and "
    "viscous friction are taken only where they predict recordings left out. The prior share of a "
    "value tells how much of it was known beforehand (the maker, the controller's own ratio at "
    "standstill, joints with the same motor) and how little the data say. Offsets and Coulomb "
    "friction stand for one arm on its days: recordings differ by more than the stated errors "
    "where its temperature does."
)
NO_CURRENTS = "No recording for fitting has motor currents: neither friction nor forces are fitted."
MODELS = {
    "fitted": "fitted",
    "least_squares": "Coulomb + viscous",
    "thesis": "thesis (6.2, 6.6)",
    "thesis_without_friction": "thesis (6.3)",
    "i_target": "target_current",
}
PICTURES = {
    "current_torque": "Current against the torque of rigid links (after Figure 6.1)",
    "current_torque_friction": "Current against torque with friction (after Figure 6.2)",
    "friction": "What is left of k i − τ, against velocity, and the fitted friction",
    "residuals": "What the fit leaves, against position, velocity, torque and time",
}


def current_blocks(
    friction: pd.DataFrame,
    currents: pd.DataFrame,
    cross: pd.DataFrame,
    payload: pd.DataFrame,
    figures: Path,
) -> list[Block]:
    """The tables friction, current_rmse of recordings to validate on, cross_validation, payload."""
    if friction.empty:
        return [Paragraph(NO_CURRENTS)]
    blocks: list[Block] = [Paragraph(INTRODUCTION), _constants(friction)]
    for recording, rows in currents.groupby("recording", sort=False):
        blocks.append(_prediction(recording, rows))
    blocks += [_matrix(cross)] if len(cross) else []
    blocks += [_payloads(payload)] if len(payload) else []
    for robot in friction["robot"].unique():
        blocks += _pictures(robot, figures)
    return blocks


def _constants(friction: pd.DataFrame) -> Table:
    body = [
        [
            Cell(str(row.joint)),
            Cell(row.parameter.replace("_", " ")),
            Cell(f"{row.value:.3f} ± {row.std_error:.3f}".replace("-", "−")),
            Cell(f"{row.low:.2f} to {row.high:.2f}".replace("-", "−")),
            Cell(f"{100 * row.prior_share:.0f} %"),
            Cell(row.determined),
            number(row.thesis, 2),
        ]
        for row in friction.itertuples()
    ]
    caption = (
        "Torque constants [Nm/A], offsets [Nm] and friction [Nm, Nm s/rad] (± standard error, 95 % "
        "interval); determined: less than half of it is prior."
    )
    header = ["joint", "parameter", "value", "95 %", "prior share", "determined", "thesis"]
    return Table(caption, header, body)


def _prediction(recording: str, rows: pd.DataFrame) -> Table:
    """RMSE on a recording that was not fitted on, each model beside the others."""
    errors = rows.set_index(["joint", "model"])["rmse_2hz"]
    models = [model for model in MODELS if model in set(rows["model"])]
    fitted = rows[rows["model"] == "fitted"].set_index("joint")
    body = []
    for joint in range(1, 7):
        values = {model: errors[joint, model] for model in models}
        marks = extremes(values)
        body.append(
            [
                Cell(str(joint)),
                *(number(values[model], 3, marks[model]) for model in models),
                number(fitted.loc[joint, "r2"], 3),
                number(100 * fitted.loc[joint, "coverage95"], 0),
            ]
        )
    caption = f"RMSE of the low-passed current [A] on {recording}, which was not fitted on."
    header = ["joint", *(MODELS[model] for model in models), "R² of fitted", "in 95 % band [%]"]
    return Table(caption, header, body)


def _matrix(cross: pd.DataFrame) -> Table:
    """Fitted on one recording, tested on each: mean over the joints."""
    mean = cross.pivot_table("rmse_2hz", "fitted_on", "tested_on", aggfunc="mean", sort=False)
    names = [*mean.index]
    body = [
        [
            Cell(f"{i + 1} {name}"),
            *(number(mean.loc[name].get(other, float("nan")), 2) for other in names),
        ]
        for i, name in enumerate(names)
    ]
    caption = (
        "RMSE of the current [A] in motion, mean over the joints: fitted on the recording of the "
        "row alone, tested on that of the column."
    )
    return Table(caption, ["fitted on", *(str(i + 1) for i in range(len(names)))], body)


def _payloads(payload: pd.DataFrame) -> Table:
    body = [
        [
            Cell(row.recording),
            Cell(f"{row.mass:.3f} ± {row.std_error:.3f}".replace("-", "−")),
            Cell(f"{row.low:.3f} to {row.high:.3f}".replace("-", "−")),
        ]
        for row in payload.itertuples()
    ]
    caption = (
        "Mass on the flange beyond the arm's model, from currents alone (± standard error, 95 % "
        "interval), on recordings that were not fitted on."
    )
    return Table(caption, ["recording", "mass [kg]", "95 % [kg]"], body)


def _pictures(robot: str, figures: Path) -> list[Block]:
    return [
        Picture(
            f"{content}, {robot}.", figures / f"{robot}_{name}.svg", f"Panels by joint: {content}."
        )
        for name, content in PICTURES.items()
    ]
