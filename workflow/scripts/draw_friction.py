"""Currents and friction of an arm, after Figures 6.1 and 6.2, and what their fit leaves."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ur5lib.identification.currents import CurrentFit, predict
from ur5lib.identification.samples import Record, smoothed_moving
from ur5lib.pipeline.current_record import current_record, smoother
from ur5lib.report.charts import residual_panels, scatter_panels
from ur5lib.report.house_style import save
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table
from ur5lib.timeseries.arrays import Array

STEP = 0.1  # s between the samples that are drawn


@dataclass(frozen=True)
class Samples:
    """Of all recordings, low-passed, (N, 6) each; NaN where a joint rests."""

    time: Array
    q: Array
    qd: Array
    torque: Array
    current: Array
    predicted: Array


def draw_friction(input: Any, output: Any, params: Any) -> None:
    friction, model = read_json(input.friction), load_robot(input.arm).fullest_model()
    parts, constant = [samples_of_nothing()], np.ones(6)
    if friction["from"]:
        fit = CurrentFit.from_plain(friction["fit"])
        constant = np.array([1 / joint.estimate.coefficients[0] for joint in fit.joints])
        for name, *paths in zip(
            params.recordings, input.signals, input.motion, input.torques, strict=True
        ):
            signals, motion, torques = map(read_table, paths)
            record = current_record(name, signals, motion, torques, model)
            if record is not None:
                parts.append(samples(record, fit, params))
    names = Samples.__dataclass_fields__
    whole = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    draw(Samples(**whole), constant, output)


def samples(record: Record, fit: CurrentFit, params: Any) -> Samples:
    """A recording's low-passed samples where each joint moves."""
    smooth = smoother(params.order, params.cutoff_hz)
    every = max(1, round(STEP / record.period))
    moving = smoothed_moving(record, smooth)[::every]

    def thinned(values: Array) -> Array:
        return np.where(moving, smooth(values, record)[::every], np.nan)

    time = np.arange(len(record.q))[::every, None] * record.period * np.ones(6)
    return Samples(
        time=np.where(moving, time, np.nan),
        q=thinned(record.q),
        qd=thinned(record.qd),
        torque=thinned(record.torque),
        current=thinned(record.current),
        predicted=thinned(predict(fit, record)),
    )


def samples_of_nothing() -> Samples:
    """Where nothing was fitted, panels stay empty."""
    return Samples(*(np.full((1, 6), np.nan) for _ in Samples.__dataclass_fields__))


def draw(samples: Samples, constant: Array, output: Any) -> None:
    """The four figures."""
    friction = constant * samples.predicted - samples.torque
    needed = samples.torque + friction
    ends = np.stack([np.nanmin(needed, axis=0), np.nanmax(needed, axis=0)])
    line = ends, ends / constant
    current = "i_{} [A]"
    save(
        scatter_panels(samples.torque, samples.current, ("rigid τ_{} [Nm]", current), line),
        output.current_torque,
    )
    save(
        scatter_panels(needed, samples.current, ("with friction τ_{} [Nm]", current), line),
        output.current_torque_friction,
    )
    measured = constant * samples.current - samples.torque
    labels = ("velocity of joint {} [rad/s]", "k i_{0} − τ_{0} [Nm]")
    save(scatter_panels(samples.qd, measured, labels, fitted=friction), output.friction)
    against = {
        "position [rad]": samples.q,
        "velocity [rad/s]": samples.qd,
        "rigid torque [Nm]": samples.torque,
        "time [s]": samples.time,
    }
    residual = samples.current - samples.predicted
    save(residual_panels(residual, against, "A"), output.residuals)


if __name__ == "__main__":
    run_step(draw_friction, snakemake)  # type: ignore[name-defined]  # noqa: F821
