"""The predicted current of motion without contact, and the external torque."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ur5lib.channels import CURRENT, Effort
from ur5lib.checks.channels import slower_than_fit
from ur5lib.dynamics.link_model import load_regressor
from ur5lib.force.external_torque import external_torque
from ur5lib.force.tare import tared
from ur5lib.identification.current_samples import ZeroPhaseLowpass, current_record
from ur5lib.identification.currents import (
    band,
    friction_current,
    load_loss,
    mixed_at_rest,
    predict,
    torque_constants,
)
from ur5lib.identification.payload import (
    SCALED_TORQUE_ERROR,
    PayloadEstimate,
    joint_gains,
    judged_load,
)
from ur5lib.identification.samples import CurrentSamples, blocks
from ur5lib.identification.validation import baseline_current, coefficients_of_constants, score
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Motion, motions_before
from ur5lib.records.prediction import Prediction, Scores
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.timeseries.metrics import NORMAL95


class PredictedCurrents(NamedTuple):
    """Predicted currents and external torques of a recording, and their scores."""

    currents: Currents
    prediction: Prediction


class Inputs(AlignedRecording):
    """What is read of a recording."""

    premises: Premises
    role: str
    date: str
    gravity: list[float] | None
    untouched: tuple[float, float] | None
    chain: Sequence[str]
    before: Mapping[str, Motion]


@step("recording", "currents.parquet prediction=currents.json", unloaded="payload")
def predict_currents(
    recording: Inputs,
    payload: PayloadEstimate,
    unloaded: Mapping[str, PayloadEstimate],
    friction: Friction,
    arm: Robot,
    lowpass: Butterworth,
) -> PredictedCurrents:
    """Return the predicted current of motion without contact, and the external torque.

    Both are empty without currents or a fit, and where the recording contradicts the study or is
    slower than the fit. payload, unloaded: loads of the recording and of the arm's `fit`
    recordings.
    """
    signals, motion, premises = recording.signals, recording.motion, recording.premises
    summary = Prediction(recording.name in friction.from_)
    record = current_record(
        recording, arm, motions_before(motion, recording.chain, recording.before)
    )
    fit, smooth = friction.fit_for(recording.name), ZeroPhaseLowpass(*lowpass)
    slower = slower_than_fit(
        signals.actual_q, signals.segment, signals.period, smooth.cutoff, friction.period
    )
    if record is None or not fit.joints or premises.contradictions.stop_signs or slower:
        return PredictedCurrents(Currents(time=signals.time, segment=signals.segment), summary)
    load, load_torque = None, 0 * record.q
    if payload.is_known:
        may_be_taken = premises.load.source != "study" and recording.role != "fit"
        load = judged_load(
            payload, [*unloaded.values()], friction.paths, premises.load.mass, may_be_taken
        )
        if load.taken:
            states = (
                arm.mounted(recording.gravity),
                arm.fullest_model(),
                motion.q,
                motion.qd,
                motion.qdd,
            )
            load_torque = load_regressor(*states) @ payload.parameters
    record, load_torque = with_load(replace(record, day=recording.date), load_torque, fit, smooth)
    currents = predicted_currents(record, fit, load_torque, recording.torques, smooth, arm.measured)
    if friction.usual is not None:
        currents = with_usual_rest(currents, fit, friction.usual, record, smooth)
    if recording.untouched is not None:
        currents = tared(currents, motion, recording.untouched, smooth.cutoff)
    rivals = baselines(record, arm, friction.least_squares, signals)
    scored = scores(record, currents, rivals, smooth)
    return PredictedCurrents(currents, replace(summary, load=load, scores=scored))


def predicted_currents(
    record: CurrentSamples,
    fit: CurrentFit,
    load_torque: Array,
    torques: Torques,
    smooth: ZeroPhaseLowpass,
    effort: Effort = CURRENT,
) -> Currents:
    """Return prediction, band, external torque and friction of a recording.

    record: its torque includes `load_torque` (N, n) [Nm], that of an estimated load; effort:
    predicted quantity.
    """
    predicted, constant = predict(fit, record), torque_constants(fit)
    external = external_torque(constant, record.current, predicted)
    doubt = SCALED_TORQUE_ERROR * np.abs(smooth(load_torque, record))
    half = np.hypot(band(fit, record, smooth), NORMAL95 * doubt / constant)
    name = effort.quantity
    of_efforts: dict[str, Any] = {f"predicted_{name}": predicted, f"{name}_band": half}
    return Currents(
        time=torques.time,
        segment=torques.segment,
        **of_efforts,
        external_torque=smooth(external, record),
        load_doubt=doubt,
        gear_torque=smooth(record.torque, record),
        friction_torque=constant * smooth(friction_current(fit, record), record),
        load_loss=smooth(load_loss(fit, record), record),
    )


def with_usual_rest(
    currents: Currents,
    fit: CurrentFit,
    usual: CurrentFit,
    record: CurrentSamples,
    smooth: ZeroPhaseLowpass,
) -> Currents:
    """Return the currents of a fit to one path with USUAL_AT_REST of the usual fit in the
    prediction at rest.
    """
    predicted, constant = mixed_at_rest(fit, usual, record)
    external = smooth(external_torque(constant, record.current, predicted), record)
    return replace(currents, external_torque=external, predicted_current=predicted)


def with_load(
    record: CurrentSamples, load_torque: Array, fit: CurrentFit, smooth: ZeroPhaseLowpass
) -> tuple[CurrentSamples, Array]:
    """Return the record with a load's torque (N, n) [Nm] added, and that torque scaled to the
    motors.

    The factor of each motor is estimated from the recording.
    """
    if load_torque.any():
        loaded = replace(record, torque=record.torque + load_torque)
        external = external_torque(torque_constants(fit), loaded.current, predict(fit, loaded))
        left, expected = smooth(external, record), smooth(load_torque, record)
        count = int(blocks(record)[-1]) + 1
        load_torque = load_torque * (1 - joint_gains(left, expected, count))
    return replace(record, torque=record.torque + load_torque), load_torque


def baselines(
    record: CurrentSamples, robot: Robot, least_squares: Array, signals: Signals
) -> Iterator[tuple[str, Array]]:
    """Yield (name, current (N, n) [A]) of baselines: least squares, published constants, the
    controller's target.
    """
    if len(least_squares):
        yield "least_squares", baseline_current(record, least_squares)
    constants, friction = robot.current_to_torque, robot.friction
    if constants is not None and friction is not None:
        nothing = np.zeros(len(robot.joints))
        coefficients = coefficients_of_constants(
            np.array(constants.torque_constant),
            np.array(constants.offset),
            np.array(friction.coulomb),
            np.array(friction.viscous),
        )
        preliminary = np.array(constants.preliminary_torque_constant)
        without = coefficients_of_constants(preliminary, nothing, nothing, nothing)
        yield "thesis", baseline_current(record, coefficients)
        yield "thesis_without_friction", baseline_current(record, without)
    if signals.target_current is not None:
        yield "i_target", signals.target_current


def scores(
    record: CurrentSamples,
    currents: Currents,
    others: Iterable[tuple[str, Array]],
    smooth: ZeroPhaseLowpass,
) -> dict[str, Scores]:
    """Return the score of each prediction by name; only ours, `fitted`, has a band to score."""
    assert currents.predicted is not None
    assert currents.band is not None
    half = currents.band
    figures = {"fitted": score(record, currents.predicted, smooth, half)}
    for name, current in others:
        figures[name] = score(record, current, smooth, np.full_like(half, np.nan))
    return figures
