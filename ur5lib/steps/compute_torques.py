"""Joint torques of every link model: at the targets and at the measured motion; stop signs."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.checks.channels import fast_between_samples, too_short
from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import CHECKED_COLUMNS, stop_signs
from ur5lib.checks.torques import given_load
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.force.tare import Span, tare_doubts
from ur5lib.records.accepted import accepting
from ur5lib.records.carried import Carried, carried, disagreements
from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Contradictions, Finding
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot
from ur5lib.tables import read_footer, read_table
from ur5lib.timeseries.arrays import Six


class RecordingTorques(NamedTuple):
    """The torques of a recording, and what they rest on."""

    torques: Torques
    premises: Premises


def compute_torques(
    signals: Path,
    motion: Motion,
    arm: Robot,
    role: str,
    cutoff_hz: float,
    gravity: list[float] | None = None,
    payload: Payload | None = None,
    tcp: Six | None = None,
    accepted: dict[str, str] | None = None,
    untouched: Span | None = None,
) -> RecordingTorques:
    """Return the torques of every link model, and what in the recording contradicts the study.

    signals: file of `Signals`; gravity, payload, tcp: as the study declares them; role: of the
    recording; cutoff_hz: of the currents' low-pass; accepted: why the study overrules stop signs,
    by kind; untouched: span [s] that the study declares as a tare.
    """
    known, robot = Signals.read(signals), arm.mounted(gravity)
    load = carried(payload, known)
    doubts = disagreements(payload, tcp, known)
    doubts += too_short(known.segment, known.period, cutoff_hz)
    if untouched is not None:
        doubts += tare_doubts(untouched, known, robot, cutoff_hz, motion.motor_qd)
    doubts += fast_between_samples(
        known.actual_q, known.segment, known.period, robot.velocity_limits()
    )
    contradictions = contradicting(
        Checked(
            robot=checked_columns(signals),
            arm=robot,
            configured=load.configured,
            declared=load.payload,
            fitted=role == "fit",
            cutoff=cutoff_hz,
        ),
        doubts,
        accepted or {},
    )
    torques = joint_torques(robot, load, known, motion)
    return RecordingTorques(torques, Premises(load, contradictions))


def checked_columns(signals: Path) -> pd.DataFrame:
    """Return what the checks need of a file of `Signals`."""
    names = CHECKED_COLUMNS.intersection(read_footer(signals).schema.names)
    return read_table(signals, [*names])


def contradicting(
    checked: Checked, doubts: list[Finding], accepted: Mapping[str, str]
) -> Contradictions:
    """Return the stop signs of a recording, and further doubts."""
    doubts = [*doubts, *checked.odd_targets.values()]
    stops = stop_signs(checked, accepted)
    if not stops:  # from which others would follow
        doubts += given_load(checked)
    return accepting(Contradictions(stops, doubts), accepted)


def joint_torques(robot: Robot, load: Carried, signals: Signals, motion: Motion) -> Torques:
    """Return the torques of all link models.

    robot: under the recording's gravity; load: what it carries.
    """
    given = {model: LinkModel(robot.carrying(load.configured), model) for model in robot.models}
    states, fullest = (motion.q, motion.qd, motion.qdd), robot.fullest_model()
    measured = {name: model.inverse_dynamics(*states) for name, model in given.items()}
    target = signals.target_q, signals.target_qd, signals.target_qdd
    known = [values for values in target if values is not None]
    # what the payload adds to the one that the controller was given
    added = np.zeros_like(motion.q)
    if load.payload != load.configured:
        true = LinkModel(robot.carrying(load.payload), fullest)
        added = true.inverse_dynamics(*states) - measured[fullest]
    return Torques(
        time=signals.time,
        segment=signals.segment,
        interpolated=signals.interpolated,
        target={
            name: model.inverse_dynamics(*known) for name, model in given.items() if len(known) == 3
        },
        measured=measured,
        payload_torque=added,
    )
