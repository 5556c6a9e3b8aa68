"""The mass on the flange beyond the arm's model and given payload, from motor currents alone."""

from collections.abc import Mapping, Sequence

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.identification.current_samples import Smoother, current_record
from ur5lib.identification.payload import PayloadEstimate, estimate_payload
from ur5lib.identification.samples import smoothed_moving
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion, motions_before
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth


def estimate_load(
    recording: str,
    signals: Signals,
    motion: Motion,
    torques: Torques,
    friction: Friction,
    arm: Robot,
    lowpass: Butterworth,
    gravity: list[float] | None = None,
    before: Mapping[str, Motion] | None = None,
    chain: Sequence[str] = (),
) -> PayloadEstimate:
    """Return the load on the flange; empty without currents, a fit, or any motion.

    before, chain: as of `predict_currents`.
    """
    model, smooth = arm.fullest_model(), Smoother(*lowpass)
    earlier = motions_before(motion, chain, before or {})
    record = current_record(recording, signals, motion, torques, arm, earlier)
    if record is None or not friction.from_:
        return PayloadEstimate()
    if not smoothed_moving(record, smooth).any():  # at rest, friction hides a load
        return PayloadEstimate()
    per_load = load_regressor(arm.mounted(gravity), model, motion.q, motion.qd, motion.qdd)
    return estimate_payload(
        friction.fit_for(recording), record, per_load, smooth, whole=friction.fit
    )
