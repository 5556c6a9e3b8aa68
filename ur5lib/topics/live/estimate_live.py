"""The force of a recording as the live estimator states it, sample by sample."""

from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.records.predicted_recording import PredictedRecording
from ur5lib.robots.description import Robot
from ur5lib.topics.live.live_file import LiveFit, numbers
from ur5lib.topics.live.live_recording import follow
from ur5lib.topics.live.rows import LiveForces


def estimate_live(
    recording: PredictedRecording,
    friction: Friction,
    live: LiveFit,
    arm: Robot,
    contact_force_n: float | None,
) -> LiveForces:
    """Return the answers that the estimator of `ur5 export --format live` would have given.

    The payload includes a load that was found. contact_force_n: of a typical contact [N], None:
    from the arm's payload. Empty without a fit, without positions or currents, and if the recording
    contradicts the study.
    """
    signals, premises = recording.signals, recording.premises
    run = Measured.of(signals)
    if run is None or premises.contradictions.stop_signs or not live.known:
        return LiveForces(time=signals.time, segment=signals.segment)
    load = recording.prediction.with_load(premises.load.payload)
    about = recording.name, load, premises.place, contact_force_n
    own = numbers(arm.mounted(recording.gravity), friction, *about)
    found = follow({**own, **live.known}, run)
    return LiveForces(
        time=signals.time,
        segment=signals.segment,
        wrench=found.wrench,
        std=found.std,
        evidence=found.evidence,
        contact=found.contact,
        known=found.known,
    )
