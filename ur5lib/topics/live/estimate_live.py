"""The force of a recording as the live estimator states it, sample by sample."""

import numpy as np

from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.topics.live.live_file import LiveFit, numbers
from ur5lib.topics.live.live_recording import follow
from ur5lib.topics.live.rows import LiveForces


class Inputs(Opened):
    """What is read of a recording."""

    name: str
    gravity: list[float] | None
    signals: Signals
    premises: Premises
    prediction: Prediction


@step("recording", "live_forces.parquet")
def estimate_live(
    recording: Inputs,
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
    found = follow({**own, **live.known}, run, limited=True)
    return LiveForces(
        time=signals.time,
        segment=signals.segment,
        wrench=found.wrench,
        std=found.std,
        evidence=found.evidence,
        contact=found.contact,
        known=found.known,
        untouched=found.untouched,
        hidden=found.hidden,
        hidden_at_all=found.hidden_at_all,
        link=np.where(found.link > 0, found.link, np.nan),
        off_flange=np.where(found.link > 0, found.off_flange, np.nan),
    )
