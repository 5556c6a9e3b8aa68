"""The load on the flange beyond the arm's model and given payload, from motor currents alone."""

from collections.abc import Mapping, Sequence

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.identification.current_samples import ZeroPhaseLowpass, current_record
from ur5lib.identification.payload import PayloadEstimate, estimate_payload
from ur5lib.identification.samples import smoothed_moving
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion, motions_before
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth


class Inputs(AlignedRecording):
    """What is read of a recording."""

    gravity: list[float] | None
    chain: Sequence[str]
    before: Mapping[str, Motion]


@step("recording", "payload.json")
def estimate_load(
    recording: Inputs, friction: Friction, arm: Robot, lowpass: Butterworth
) -> PayloadEstimate:
    """Return the undeclared load on the flange; empty without currents, a fit, or any motion."""
    model, smooth, motion = arm.fullest_model(), ZeroPhaseLowpass(*lowpass), recording.motion
    record = current_record(
        recording, arm, motions_before(motion, recording.chain, recording.before)
    )
    if record is None or not friction.from_:
        return PayloadEstimate()
    if not smoothed_moving(record, smooth).any():  # at rest, friction hides a load
        return PayloadEstimate()
    per_load = load_regressor(
        arm.mounted(recording.gravity), model, motion.q, motion.qd, motion.qdd
    )
    return estimate_payload(
        friction.fit_for(recording.name), record, per_load, smooth, whole=friction.fit
    )
