"""Currents over torques as in Figures 6.1 and 6.2, an arm's friction with its band, residuals."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, Self

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ur5lib.channels import CURRENT, TORQUE, Effort
from ur5lib.identification.currents import predict, spring_current, torque_constants
from ur5lib.identification.estimation import physical_values
from ur5lib.identification.samples import CurrentSamples, MotionState, Smooth, motion_states
from ur5lib.identification.steady_friction import friction_curve
from ur5lib.records.currents import Currents
from ur5lib.records.friction import Friction, JointFit, Parameter
from ur5lib.report.figures.charts import by_joint, joint_panels, residual_panels, scatter_panels
from ur5lib.report.figures.house_style import (
    BAND_STYLE,
    DOT_STYLE,
    JOINT_COLOURS,
    Drawing,
    house_style,
    nothing_to_draw,
)
from ur5lib.timeseries.arrays import Array

DRAWN_STEP = 0.1  # s; between drawn samples
BAR_HEIGHT = 0.16  # inches; includes the space to the next bar
SYMBOLS = {CURRENT: "i_{0}", TORQUE: "measured τ_{0}"}
CURVE_POINTS = 30  # of a friction curve in one direction of motion
BAND_PARTS = 15  # of the samples in one direction of motion; the band is averaged over each
FRICTION_BAND_STYLE = {**BAND_STYLE, "label": "95 % band"}
REST_STYLE: Any = {"color": "#444444", "capsize": 3, "linewidth": 1, "label": "95 % band at rest"}
FRICTION_COLUMNS = (  # of the figure's numbers
    "velocity, joint {} [rad/s]",
    "measured, joint {} [Nm]",
    "fitted, joint {} [Nm]",
    "half of the 95 % band, joint {} [Nm]",
    "half of the band at rest, joint {} [Nm]",
)
KNOWLEDGE_SOURCES = {  # sources of the information on a parameter, and their colours
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
    "velocity_stribeck_slow": "Stribeck slow",
    "velocity_stribeck_middle": "Stribeck middle",
    "velocity_stribeck_fast": "Stribeck fast",
    "balance_sin": "spring sin",
    "balance_cos": "spring cos",
    "rotor": "rotor",
    "coupled_coulomb": "shaft Coulomb",
    "coupled_viscous": "shaft viscous",
    "coupled_rotor": "shaft rotor",
}  # labels short enough for a narrow axis


@dataclass(frozen=True)
class MovingSamples:
    """Low-passed samples of recordings, (N, 6) each; NaN where a joint rests.

    predicted: current [A] by the fit to all recordings; spring: the part of it that springs take;
    error: measured torque less its prediction by the fit without the recording's path, half:
    half-width of that prediction's 95 % band [Nm], both NaN without a prediction; resting: (R, 6),
    mean half-width at rest [Nm] in each of R recordings.
    """

    time: Array
    q: Array
    qd: Array
    torque: Array
    current: Array
    predicted: Array
    spring: Array
    error: Array
    half: Array
    resting: Array

    @classmethod
    def from_record(
        cls, record: CurrentSamples, friction: Friction, currents: Currents, smooth: Smooth
    ) -> Self:
        """Return a recording's samples in motion; currents: its predicted currents."""
        every = max(1, round(DRAWN_STEP / record.period))
        state = motion_states(record, smooth)[::every]
        moving = state == MotionState.MOVING

        def thinned(values: Array) -> Array:
            return np.where(moving, smooth(values, record)[::every], np.nan)

        constant, unknown = torque_constants(friction.fit_for(record.name)), 0 * record.q + np.nan
        unseen = unknown if currents.predicted is None else currents.predicted
        half = constant * (unknown if currents.band is None else currents.band)[::every]
        time = np.arange(len(record.q))[::every, None] * record.period * np.ones(record.q.shape[1])
        return cls(
            time=np.where(moving, time, np.nan),
            q=thinned(record.q),
            qd=thinned(record.qd),
            torque=thinned(record.torque),
            current=thinned(record.current),
            predicted=thinned(predict(friction.fit, record)),
            spring=thinned(spring_current(friction.fit, record)),
            error=constant * thinned(record.current - unseen),
            half=np.where(moving, half, np.nan),
            resting=_mean(np.where(state == MotionState.STANDING, half, np.nan))[None],
        )

    @classmethod
    def joined(cls, parts: Sequence[Self], joints: int) -> Self:
        """Return the samples of all parts, after a row of NaN so that no panel lacks samples."""
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
        figure.legend(bars, labels, loc="outside upper center", frameon=False, ncols=2)
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


def correlation_figure(joints: Sequence[JointFit]) -> Drawing:
    """Draw how the errors of each joint's parameters correlate over the bootstrap, as matrices."""
    matrices = {joint: correlations(model) for joint, model in enumerate(joints, start=1)}
    known = {joint: own for joint, own in matrices.items() if own.notna().to_numpy().all()}
    if not known:
        return nothing_to_draw()
    rows = -(-len(known) // 3)
    with house_style(2.4 * rows, rows, 3) as (figure, panels):
        for axis in panels.flat[len(known) :]:
            axis.set_visible(False)
        for axis, (joint, own) in zip(panels.flat, known.items(), strict=False):
            shades = axis.imshow(own, cmap="PuOr", vmin=-1, vmax=1)
            symbols = [PARAMETER_SYMBOLS.get(name, name) for name in own]
            axis.set_xticks(range(len(own)), symbols, rotation=90)
            axis.set_yticks(range(len(own)), symbols)
            axis.set_title(f"joint {joint}", fontsize="medium")
            axis.grid(visible=False)
        figure.colorbar(shades, ax=panels, shrink=0.5, label="correlation")
    parts = (own.rename_axis("parameter").reset_index().assign(joint=j) for j, own in known.items())
    return Drawing(figure, pd.concat(parts, ignore_index=True))


def correlations(model: JointFit) -> pd.DataFrame:
    """Return the correlations of a joint's parameters, in SI units, over the bootstrap."""
    values = physical_values(model.estimate.replicates)
    return pd.DataFrame(values, columns=model.names()).corr()


def current_figures(
    samples: MovingSamples, constant: Array, known: Array, effort: Effort = CURRENT
) -> dict[str, Drawing]:
    """Return the figures of currents over torque and of residuals by name.

    constant, known: fitted and prior torque constants (6,) [Nm/A]; effort: the measured quantity.
    """
    symbol, unit = SYMBOLS[effort], effort.unit
    axis = f"{symbol} [{unit}]"
    needed = constant * samples.predicted
    ends = np.stack([np.fmin.reduce(needed), np.fmax.reduce(needed)])
    lines = [(ends, ends / constant), (ends, ends / known)]
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
        "residuals": residual_panels(samples.current - samples.predicted, against, unit),
    }


def friction_figure(
    samples: MovingSamples, models: Sequence[JointFit], load: Array | None
) -> Drawing:
    """Draw friction over velocity, a panel for each joint: the fitted curve at the mean load, the
    95 % band of predictions, and the measured points at curve + prediction error.

    models: of the joints; load: mean one of the fit (n,) [Nm], None without recordings.
    """
    known = np.isfinite(samples.qd + samples.error + samples.half)
    if load is None or not known.any():
        return nothing_to_draw()
    qd = np.where(known, samples.qd, np.nan)
    labels = "velocity of joint {} [rad/s]", "friction of joint {} [Nm]"
    resting, fitted, half = _mean(samples.resting), np.empty_like(qd), np.empty_like(qd)
    with joint_panels(len(models), labels) as (figure, panels):
        for j, (axis, model) in enumerate(zip(panels, models, strict=True)):
            fitted[:, j] = friction_curve(model, qd[:, j], load[j])
            half[:, j] = band_over(qd[:, j], samples.half[:, j], qd[:, j])
            measured: dict[str, Any] = {"color": JOINT_COLOURS[j], "label": "measured"}
            axis.plot(qd[:, j], fitted[:, j] + samples.error[:, j], ".", **measured, **DOT_STYLE)
            for at in _branches(qd[:, j]):
                curve = friction_curve(model, at, load[j])
                around = band_over(qd[:, j], samples.half[:, j], at)
                axis.fill_between(at, curve - around, curve + around, **FRICTION_BAND_STYLE)
                axis.plot(at, curve, color="black", linewidth=1.1, label="fitted")
            if np.isfinite(resting[j]):
                axis.errorbar(0, 0, resting[j], **REST_STYLE)
        _name_marks(figure, panels)
    numbers = (qd, fitted + samples.error, fitted, half)
    at_rest = {FRICTION_COLUMNS[-1]: resting[None]} if np.isfinite(resting).any() else {}
    return Drawing(figure, by_joint(dict(zip(FRICTION_COLUMNS, numbers, strict=False)) | at_rest))


def _branches(qd: Array) -> Iterator[Array]:
    """Yield evenly spaced velocities over the negative and over the positive part of the range of
    qd (N,) [rad/s].
    """
    for own in (qd[qd < 0], qd[qd > 0]):
        if len(own):
            yield np.linspace(own.min(), own.max(), CURVE_POINTS)


def band_over(qd: Array, half: Array, at: Array) -> Array:
    """Return the half-width of the 95 % band at velocities `at` (M,) [rad/s] in motion, [Nm].

    Interpolated between means over BAND_PARTS of the samples sorted by velocity. qd, half: of the
    samples (N,) [rad/s], [Nm]; NaN in qd is left out.
    """
    found = np.full(len(at), np.nan)
    for direction in (-1, 1):
        own, here = np.flatnonzero(direction * qd > 0), direction * at > 0
        if len(own):
            parts = np.array_split(own[np.argsort(qd[own])], min(BAND_PARTS, len(own)))
            centres, means = ([values[part].mean() for part in parts] for values in (qd, half))
            found[here] = np.interp(at[here], centres, means)
    return found


def _name_marks(figure: Figure, panels: Sequence[Axes]) -> None:
    """Draw one legend for all panels."""
    named = (zip(*axis.get_legend_handles_labels(), strict=True) for axis in panels)
    marks: dict[str, Any] = {label: mark for pairs in named for mark, label in pairs}
    marks["measured"] = Line2D([], [], color="#777777", marker=".", linestyle="")  # of any joint
    style: Any = {"loc": "outside upper center", "frameon": False, "ncols": len(marks)}
    figure.legend([*marks.values()], [*marks], **style)


def _mean(values: Array) -> Array:
    """Return the mean (n,) of the finite values of each column (N, n); NaN if there are none."""
    return pd.DataFrame(values).mean().to_numpy(float)
