"""Judge a recording by itself: findings, and its rows of the study's tables."""

from dataclasses import replace

from ur5lib.checks.channels import slower_than_fit
from ur5lib.force.problem import unusual_friction
from ur5lib.force.residual_model import Residuals
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import Judgement, Rows
from ur5lib.records.motion import Alignment, Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import UNUSUAL_FRICTION, Finding, Quality
from ur5lib.records.signals import Signals
from ur5lib.tidy import files, friction, models, written


def judge_recording(
    quality: Quality,
    signals: Signals,
    motion: Motion,
    alignment: Alignment,
    torques: Torques,
    premises: Premises,
    currents: Currents,
    prediction: Prediction,
    friction: Friction,
    residuals: Residuals,
    cutoff_hz: float,
) -> Judgement:
    """Return a recording's findings, and its rows of tables.

    cutoff_hz: of the currents' low-pass [Hz].
    """
    rows = {
        **of_files(quality, signals, alignment),
        **of_models(signals, torques, prediction),
    }
    slower = slower_than_fit(
        signals.actual_q, signals.segment, signals.period, cutoff_hz, friction.period
    )
    share = unusual_friction(motion, currents, residuals)
    doubts = slower if share is None else [*slower, _unusual(share)]
    known = premises.contradictions
    contradictions = replace(known, findings=[*known.findings, *doubts])
    return Judgement(rows, files.findings(quality, contradictions, alignment.clocks))


def of_files(quality: Quality, signals: Signals, alignment: Alignment) -> dict[str, Rows]:
    """Return the rows about the recording's files."""
    return written(
        recordings=files.recordings(quality, signals),
        files=files.files(quality),
        account=files.account(quality),
        clocks=files.clocks(alignment.clocks),
    )


def of_models(signals: Signals, torques: Torques, prediction: Prediction) -> dict[str, Rows]:
    """Return the rows about link models, and about currents and the load that they show."""
    return written(
        torque_mae=models.torque_mae(signals, torques),
        current_rmse=friction.current_rmse(prediction),
        payload=friction.payload(prediction),
    )


def _unusual(share: float) -> Finding:
    """Return the warning of a recording with a share of the usual friction."""
    detail = (
        f"the currents show {share:.0%} of the friction that such a motion usually has, as where a "
        "hand leads the arm; since nothing was fitted, its contact force cannot be told from that, "
        "and none is stated: record motion without contact with the role fit"
    )
    return Finding("robot", UNUSUAL_FRICTION, "warning", 1, detail)
