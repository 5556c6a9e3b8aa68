"""Currents over torques as in Figures 6.1 and 6.2, friction of an arm, residuals of its fit."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from typing import Self

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.identification.currents import predict, spring_current
from ur5lib.identification.samples import CurrentSamples, Smooth, smoothed_moving
from ur5lib.records.friction import CurrentFit, Parameter
from ur5lib.report.figures.charts import residual_panels, scatter_panels
from ur5lib.report.figures.house_style import Drawing, house_style, nothing_to_draw
from ur5lib.timeseries.arrays import Array

DRAWN_STEP = 0.1  # s between the samples that are drawn
BAR_HEIGHT = 0.16  # inches, with the space to the next
SYMBOLS = {CURRENT: "i_{0}", TORQUE: "measured τ_{0}"}
KNOWLEDGE_SOURCES = {  # the shares of a parameter's knowledge, and their colours, darker in turn
    "prior_share": ("other arms and the maker", "#E0E0E0"),
    "arm_share": ("other days", "#E69F00"),
    "day_share": ("other recordings of the day", "#0072B2"),
    "run_share": ("the one recording that tells most", "#222222"),
}
PARAMETER_SYMBOLS = {
    "torque_constant": "k",
    "offset": "b",
    "coulomb": "Coulomb",
    "velocity_root": "root",
    "velocity_square": "square",
    "balance_sin": "spring sin",
    "balance_cos": "spring cos",
    "rotor": "rotor",
    "coupled_coulomb": "shaft Coulomb",
    "coupled_viscous": "shaft viscous",
    "coupled_rotor": "shaft rotor",
}  # on a narrow axis


@dataclass(frozen=True)
class MovingSamples:
    """Low-passed samples of recordings, (N, 6) each; NaN where a joint rests; spring: the part of
    the predicted current that springs take.
    """

    time: Array
    q: Array
    qd: Array
    torque: Array
    current: Array
    predicted: Array
    spring: Array

    @classmethod
    def from_record(cls, record: CurrentSamples, fit: CurrentFit, smooth: Smooth) -> Self:
        """Return a recording's samples where each joint moves."""
        every = max(1, round(DRAWN_STEP / record.period))
        moving = smoothed_moving(record, smooth)[::every]

        def thinned(values: Array) -> Array:
            return np.where(moving, smooth(values, record)[::every], np.nan)

        time = np.arange(len(record.q))[::every, None] * record.period * np.ones(record.q.shape[1])
        return cls(
            time=np.where(moving, time, np.nan),
            q=thinned(record.q),
            qd=thinned(record.qd),
            torque=thinned(record.torque),
            current=thinned(record.current),
            predicted=thinned(predict(fit, record)),
            spring=thinned(spring_current(fit, record)),
        )

    @classmethod
    def joined(cls, parts: Sequence[Self], joints: int) -> Self:
        """Return the samples of all parts, after a row of NaN: panels may be empty."""
        nothing, names = np.full((1, joints), np.nan), [field.name for field in fields(cls)]
        arrays = ([nothing, *(getattr(part, name) for part in parts)] for name in names)
        return cls(*map(np.concatenate, arrays))


def knowledge_bars(parameters: Sequence[Parameter]) -> Drawing:
    """Draw a bar of shares for each parameter, in a panel for each joint."""
    if not parameters:
        return nothing_to_draw()
    data = pd.DataFrame([asdict(row) for row in parameters])[["joint", "name", *KNOWLEDGE_SOURCES]]
    rows, most = -(-data["joint"].nunique() // 3), data.groupby("joint").size().max()
    height = rows * (BAR_HEIGHT * most + 0.5) + 0.3
    with house_style(height, rows, 3, sharex=True) as (figure, panels):
        axes = panels.flat
        for empty in axes[data["joint"].nunique() :]:
            empty.set_visible(False)
        for axis, (joint, of_joint) in zip(axes, data.groupby("joint"), strict=False):
            _draw_shares(axis, of_joint)
            axis.set_title(f"joint {joint}")
        figure.supxlabel("share of what is known [%]", fontsize="medium")
        bars, labels = axes[0].get_legend_handles_labels()
        figure.legend(bars, labels, loc="outside upper center", frameon=False, ncols=4)
    return Drawing(figure, data)


def _draw_shares(axis: Axes, parameters: pd.DataFrame) -> None:
    """Draw the shares of a joint's parameters."""
    shares = 100 * parameters[[*KNOWLEDGE_SOURCES]].to_numpy()
    ends = shares.cumsum(axis=1)
    for (label, color), width, end in zip(
        KNOWLEDGE_SOURCES.values(), shares.T, ends.T, strict=True
    ):
        axis.barh(range(len(parameters)), width, 0.75, end - width, color=color, label=label)
    axis.set_yticks(
        range(len(parameters)), [PARAMETER_SYMBOLS.get(name, name) for name in parameters["name"]]
    )
    axis.set_xlim(0, 100)
    axis.invert_yaxis()
    axis.grid(visible=False)


def friction_figures(
    samples: MovingSamples, constant: Array, known: Array, effort: Effort = CURRENT
) -> dict[str, Drawing]:
    """Return the four figures by name.

    constant, known: torque constants (6,) [Nm/A] of the fit, and those known before it; effort:
    that is measured.
    """
    symbol, unit = SYMBOLS[effort], effort.unit
    axis = f"{symbol} [{unit}]"
    needed, rigid = constant * samples.predicted, samples.torque + constant * samples.spring
    ends = np.stack([np.fmin.reduce(needed), np.fmax.reduce(needed)])
    lines = [(ends, ends / constant), (ends, ends / known)]
    labels = ("velocity of joint {} [rad/s]", "friction of joint {} [Nm]")
    against = {
        "position [rad]": samples.q,
        "velocity [rad/s]": samples.qd,
        "rigid torque [Nm]": samples.torque,
        "time [s]": samples.time,
    }
    return {
        "current_torque": scatter_panels(
            samples.torque, samples.current, ("τ_{} of rigid links [Nm]", axis), lines
        ),
        "current_torque_friction": scatter_panels(
            needed, samples.current, ("τ_{} with friction [Nm]", axis), lines
        ),
        "friction": scatter_panels(
            samples.qd, constant * samples.current - rigid, labels, fitted=needed - rigid
        ),
        "residuals": residual_panels(samples.current - samples.predicted, against, unit),
    }
