"""The current that motion without contact needs, and the torque that is left for a contact."""

from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.external_torque import without_edges
from ur5lib.force.observer import momentum_rate, observe
from ur5lib.identification.currents import (
    CurrentFit,
    band,
    fit_for,
    predict,
    torque_constants,
)
from ur5lib.identification.payload import LEFT, Payload, joint_gains, judge, run_to_run
from ur5lib.identification.samples import Record, Smooth, blocks, smoothed_moving
from ur5lib.identification.validation import baseline_current, coefficients_of_constants, score
from ur5lib.pipeline.current_record import current_record, smoother
from ur5lib.pipeline.left_over import edge, left_over
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, read_json, read_table, write_json, write_table
from ur5lib.timeseries.arrays import Array


def predict_currents(input: Any, output: Any, params: Any) -> None:
    robot, friction = load_robot(input.arm), read_json(input.friction)
    signals, motion, torques = map(read_table, (input.signals, input.motion, input.torques))
    record = current_record(params.recording, signals, motion, torques, robot.fullest_model())
    columns: dict[str, Array] = {}
    summary: dict[str, Any] = {"fitted": params.recording in friction["from"], "scores": {}}
    if record is not None and friction["from"]:
        smooth = smoother(params.order, params.cutoff_hz)
        fit = fit_for(params.recording, friction)
        load, load_torque = carried_load(input, params, friction)
        if load_torque.any():
            load_torque = load_torque * as_felt(record, load_torque, fit, smooth, params.cutoff_hz)
        record = replace(record, torque=record.torque + load_torque)
        half = band(fit, smoothed_moving(record, smooth))
        currents = {"fitted": predict(fit, record)}
        currents |= baselines(record, robot, np.array(friction["least_squares"]))
        if "target_current_0" in signals:
            currents["i_target"] = channel(signals, "target_current")
        summary |= {"load": load, "scores": scores(record, currents, smooth, half)}
        constant = torque_constants(fit)
        columns = named(currents["fitted"], "predicted_current") | named(half, "current_band")
        columns |= named(
            left_over(record, currents["fitted"], constant, smooth, params.cutoff_hz), "tau_ext"
        )
        columns |= named(LEFT * np.abs(smooth(load_torque, record)), "load_doubt")
        observed = observer_torque(
            record, torques, currents["fitted"], load_torque, constant, params
        )
        columns |= named(observed, "tau_observer")
    write_table(signals[["time", "segment"]].join(pd.DataFrame(columns)), output.currents)
    write_json(summary, output.summary)


def carried_load(input: Any, params: Any, friction: Any) -> tuple[dict[str, Any] | None, Array]:
    """What the arm carries beyond what is known, and the torque (N, 6) that is taken for it.

    A load that is certain is taken into the prediction, unless the study declares another, or the
    recording is one to fit on, whose payload is taken as it is told.
    """
    regressor, found = read_table(input.regressor), read_json(input.payload)
    nothing = np.zeros((len(regressor), 6))
    if not found:
        return None, nothing
    payload = Payload(**{name: np.array(value) for name, value in found.items()})
    load = judge(payload, run_to_run_spread(input.unloaded, friction))
    known = read_json(input.load)
    declared = known["source"] == "study"
    taken = load.certain and not declared and params.role != "fit"
    if taken:
        columns = channel(regressor, "load_regressor", 24).reshape(-1, 6, 4)
        nothing = columns @ payload.parameters
    center = payload.parameters[1:] / load.mass if load.certain else np.full(3, np.nan)
    configured = known["payload"]["mass"] if known["payload"] else 0.0
    account = {"configured": configured, "carried": configured + load.mass}
    return asdict(load) | account | {"taken": taken, "center_of_mass": center}, nothing


def as_felt(
    record: Record, load_torque: Array, fit: CurrentFit, smooth: Smooth, cutoff: float
) -> Array:
    """By which factor (6,) each joint's motor feels a load, by the same recording."""
    loaded = replace(record, torque=record.torque + load_torque)
    left = left_over(loaded, predict(fit, loaded), torque_constants(fit), smooth, cutoff)
    return 1 - joint_gains(left, smooth(load_torque, record), int(blocks(record)[-1]) + 1)


def run_to_run_spread(unloaded: list[str], friction: Any) -> float:
    """Standard deviation of the mass [kg] that recordings to fit on seem to carry."""
    found = [payload for payload in map(read_json, unloaded) if payload]
    if not found:
        return 0.0
    names = ("parameters", "std_error")
    values, errors = (np.array([own[name] for own in found]) for name in names)
    return float(run_to_run(values, errors, friction["paths"])[0])


def baselines(record: Record, robot: Robot, least_squares: Array) -> dict[str, Array]:
    """Currents by Coulomb and viscous least squares, and by published constants."""
    currents = {"least_squares": baseline_current(record, least_squares)}
    constants, friction = robot.current_to_torque, robot.friction
    if constants is not None and friction is not None:
        nothing = np.zeros(6)
        coefficients = coefficients_of_constants(
            np.array(constants.torque_constant),
            np.array(constants.offset),
            np.array(friction.coulomb),
            np.array(friction.viscous),
        )
        preliminary = np.array(constants.preliminary_torque_constant)
        without = coefficients_of_constants(preliminary, nothing, nothing, nothing)
        currents["thesis"] = baseline_current(record, coefficients)
        currents["thesis_without_friction"] = baseline_current(record, without)
    return currents


def scores(
    record: Record, currents: dict[str, Array], smooth: Smooth, half: Array
) -> dict[str, Any]:
    """How well each current is predicted; a band is stated for ours alone."""
    figures = {}
    for name, current in currents.items():
        figures[name] = asdict(score(record, current, smooth, half))
        if name != "fitted":
            figures[name]["coverage"] = np.full(6, np.nan)
    return figures


def observer_torque(
    record: Record,
    torques: pd.DataFrame,
    predicted: Array,
    load_torque: Array,
    constant: Array,
    params: Any,
) -> Array:
    """The same by the generalised momentum, which needs no accelerations but of a found load."""
    rate = momentum_rate(
        motor=constant * record.current - load_torque,
        friction=constant * predicted - record.torque,
        coriolis=channel(torques, "coriolis_torque"),
        gravity=channel(torques, "gravity_torque"),
    )
    momentum = channel(torques, "momentum")
    torque = observe(momentum, rate, record.segment, record.period, params.cutoff_hz)
    return without_edges(torque, record.segment, edge(record, params.cutoff_hz))


if __name__ == "__main__":
    run_step(predict_currents, snakemake)  # type: ignore[name-defined]  # noqa: F821
