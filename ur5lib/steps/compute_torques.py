"""Joint torques of every link model, at targets and measured motion, and doubts about them."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.checks.checked import Checked
from ur5lib.checks.contacts import sensed_contacts
from ur5lib.checks.findings import contradictions
from ur5lib.checks.stop_signs import CHECKED_COLUMNS
from ur5lib.checks.tool import shown_tool_center
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.force.tare import tare_doubts
from ur5lib.records.carried import Carried, carried, disagreements, medians
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.contact_place import contact_place as contact_place_of
from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.premises import Premises
from ur5lib.records.signals import SENSOR_COLUMNS, Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Payload, Robot, Vector3
from ur5lib.tables import Source, read_footer, read_table
from ur5lib.timeseries.arrays import Six


class RecordingTorques(NamedTuple):
    """The torques of a recording by link model, and what they rest on: payload, contradictions, and
    place of contacts.
    """

    torques: Torques
    premises: Premises


class Inputs(Opened):
    """What is read of a recording."""

    signals: Signals
    motion: Motion
    role: str
    gravity: list[float] | None
    untouched: tuple[float, float] | None


@step("recording", "torques.parquet premises.json", payload="declared_payload")
def compute_torques(
    recording: Inputs,
    arm: Robot,
    cutoffs_hz: dict[str, float],
    payload: Payload | None = None,
    tcp: Six | None = None,
    accepted: dict[str, str] | None = None,
    contact_place: tuple[Vector3, float] | None = None,
) -> RecordingTorques:
    """Return the torques of every link model, and contradictions between recording and study.

    payload, tcp: as the study declares them; cutoffs_hz: of the low-pass filters by name; accepted:
    reasons of the study to overrule stop signs, by kind; contact_place: as it states it: place (3,)
    [m], frame 6, and usual distance from it [m].
    """
    known, motion, robot = recording.signals, recording.motion, arm.mounted(recording.gravity)
    load = carried(payload, known)
    doubts, cutoff = disagreements(payload, tcp, known), cutoffs_hz["currents"]
    if recording.untouched is not None:
        doubts += tare_doubts(recording.untouched, known, robot, cutoff, motion.motor_qd)
    table, fitted = checked_columns(known.file), recording.role == "fit"
    touched = recording.role == "contact"
    checked = Checked(table, robot, load.configured, load.payload, fitted, cutoff, touched)
    if not touched:
        doubts += sensed_contacts(table, load.mass)
    sensed = known.force_sensor is not None
    found = contradictions(checked, doubts, sensed, cutoffs_hz, accepted or {})
    place = place_of_contacts(contact_place, tcp, known, load, table, robot)
    premises = Premises(load, found, place, checked.felt)
    return RecordingTorques(joint_torques(robot, load, known, motion), premises)


def place_of_contacts(
    stated: tuple[Vector3, float] | None,
    tcp: Six | None,
    signals: Signals,
    load: Carried,
    table: pd.DataFrame,
    arm: Robot,
) -> ContactPlace:
    """Return the place on the arm at which contacts are assumed.

    stated, tcp: as the study declares them; table: of the signals, with the columns of the checks.
    """
    set_tool = None if signals.tcp_offset is None else medians(signals.tcp_offset, 6)
    shown_tool = shown_tool_center(table, arm) if set_tool is None else None
    mounted = signals.force_sensor is not None and not arm.wrist_sensor
    return contact_place_of(
        stated,
        tools={"tool": tcp, "tcp_offset": set_tool, "actual_TCP_pose": shown_tool},
        centers={
            "sensor": arm.mounting.force_sensor if mounted else None,
            "payload": None if load.payload is None else load.payload.center_of_mass,
        },
    )


def checked_columns(signals: Source) -> pd.DataFrame:
    """Return the columns that the checks use from a file of `Signals`."""
    names = CHECKED_COLUMNS.union(SENSOR_COLUMNS["force"])
    return read_table(signals, [*names.intersection(read_footer(signals).schema.names)])


def joint_torques(robot: Robot, load: Carried, signals: Signals, motion: Motion) -> Torques:
    """Return the torques of all link models.

    robot: under the recording's gravity; load: on its flange.
    """
    given = {model: LinkModel(robot.carrying(load.configured), model) for model in robot.models}
    states, fullest = (motion.q, motion.qd, motion.qdd), robot.fullest_model()
    measured = {name: model.inverse_dynamics(*states) for name, model in given.items()}
    target = signals.target_q, signals.target_qd, signals.target_qdd
    known = [values for values in target if values is not None]
    # difference between the true payload and the one that the controller was given
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
