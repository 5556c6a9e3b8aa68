"""The file of an arm: all that a causal estimate of its force needs."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ur5lib import __version__
from ur5lib.channels import CURRENT
from ur5lib.commands.exported import ROS_NAMES
from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.force.sensed_contact import in_contact
from ur5lib.jobs.unreadable import reason
from ur5lib.records.codes import Found
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.forces import SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot
from ur5lib.study.model import Recording
from ur5lib.timeseries.segments import runs
from ur5lib.topics.live.live import FORMAT
from ur5lib.topics.live.live_file import LiveFit, numbers
from ur5lib.topics.live.rows import LiveForces

PUSH_COLUMNS = ["motion", "axis", "value", "low", "high", "bound", "largest_tried", "seconds"]
PUSH_COLUMNS += ["trials", "blind"]
USUAL_CONSTANT = 10.0  # Nm/A
UNITS = "SI: m, kg, s, rad, N, Nm, A; links in the axes of their joint, joints from 1"


def known_of_arm(study: StudyFiles, robot: str, as_in: str) -> dict[str, Any]:
    """Return the contents of an arm's file.

    as_in: recording with the payload (declared or found), the place of contacts and the mounting to
    use, "" for none. Raises InputError with the report's reason if no force may be stated.
    """
    arm, friction = study.arm(robot), study.parameters(Friction, robot, "friction")
    live = study.parameters(LiveFit, robot, "live")
    if live.refused is not None:
        raise InputError(f"no force of {robot} is stated: {live.refused.sentence()}")
    if not live.known:
        raise InputError(
            f"{study.folder} has no recording without contact that {robot} was fitted to; add one "
            "of the role `fit`, with currents"
        )
    entries = [one for one in study.configuration().recordings if one.arm.known_as == robot]
    mounted = arm.mounted(study.recording(as_in).known_gravity()) if as_in else arm
    payload = carried(study, as_in) if as_in else None
    force = study.configuration().settings.contact.force_n
    places = {study.record(Premises, name).place for name in ([as_in] if as_in else friction.from_)}
    place = places.pop() if len(places) == 1 else ContactPlace()
    others = [entry for entry in entries if entry.name not in friction.from_]
    head = {"format": FORMAT, "units": UNITS, "exported_by": f"ur5lib {__version__}"}
    known = numbers(mounted, friction, "", payload, place, force)
    return (
        head
        | {"arm": robot, "payload": payload and payload.model_dump(mode="json")}
        | {"joints": ROS_NAMES if arm.is_ur() else [f"joint_{k}" for k in arm.joint_numbers]}
        | with_input(known, arm, input_of(study, friction.from_))
        | live.known
        | {"validity": _validity(study, entries, friction.from_)}
        | {"smallest_pushes": [*_pushes(study, robot)]}
        | {"judged_on": [*_judged(study, others)]}
        | {"fitted_on": {name: study.quality(name).read for name in friction.from_}}
    )


def input_of(study: StudyFiles, names: list[str]) -> str:
    """Return the kind of effort (`KINDS`) that the fitted recordings have."""
    codes = {found.code for name in names for found in study.quality(name).findings}
    if Found.GRAVITY_ADDED in codes:
        return "torque_less_gravity"
    measured = study.arm(study.recording(names[0]).arm.known_as).measured
    return "torque" if Found.CURRENTS_FROM_TORQUES in codes else measured.quantity


def with_input(known: dict[str, Any], arm: Robot, input: str) -> dict[str, Any]:
    """Return an arm's numbers in the unit of its efforts, with their kind, and the motors'
    documented torque constants; 10 Nm/A, the usual one, where these are unknown.
    """
    documented = np.array(arm.maker_torque_constants())
    if arm.measured != CURRENT:  # gains of 1 Nm/Nm
        documented = np.full(len(documented), np.nan)
    own = known["torque_constant"] if input == "current" else [USUAL_CONSTANT] * len(documented)
    motor = np.where(np.isnan(documented), own, documented)
    if input != "current" and arm.measured == CURRENT:  # recordings were divided by these
        known |= {
            "torque_constant": (known["torque_constant"] / motor).tolist(),
            "current": (known["current"] * motor).tolist(),
        }
    return known | {"input": input, "motor_constant": motor.tolist()}


def carried(study: StudyFiles, recording: str) -> Payload | None:
    """Return the arm's payload in a recording: the declared one plus the load that was found."""
    found = study.record(Prediction, recording, "currents")
    return found.with_load(study.payload(recording))


def _pushes(study: StudyFiles, robot: str) -> Iterator[dict[str, Any]]:
    """Yield the smallest pushes that the live estimator finds, by motion and axis."""
    if "live_pushes" in study.tables:  # results of earlier versions lack it
        rows = study.table("live_pushes").query("robot == @robot")
        yield from (
            rows[PUSH_COLUMNS].astype({"bound": object}).fillna({"bound": ""}).to_dict("records")
        )


def _judged(study: StudyFiles, entries: list[Recording]) -> Iterator[dict[str, Any]]:
    """Yield for each recording from which the estimator learnt nothing its role, alarms, minutes,
    known share of time, and RMSE in contact.
    """
    for entry in entries:
        folder = study.folder / "recordings" / entry.name
        path = folder / "live_forces.parquet"
        if entry.at_rest or not path.is_file() or reason(str(path)):
            continue
        found = LiveForces.read(path)
        if found.wrench is None or found.contact is None or found.known is None:
            continue
        row: dict[str, Any] = {"recording": entry.name, "role": entry.role}
        row |= {"alarms": len(runs(found.contact)), "known_share": float(found.known.mean())}
        row |= {"minutes": len(found.time) * found.period / 60, "rmse_in_contact": None}
        sensed = SensorWrenches.read(folder / "sensor.parquet").wrench.get("compensated")
        if sensed is not None:
            touched = in_contact(np.linalg.norm(sensed[:, :3], axis=1))
            if touched.any():
                squares = ((found.wrench - sensed)[touched, :3] ** 2).sum(axis=1)
                row["rmse_in_contact"] = float(np.sqrt(np.nanmean(squares)))
        yield row


def _validity(study: StudyFiles, entries: list[Recording], fitted: list[str]) -> dict[str, Any]:
    """Return dates and motor temperatures [°C] of the fitted recordings."""
    dates = {str(one.date) for one in entries if one.name in fitted and one.date is not None}
    known = [*_temperatures(study, fitted)]
    spans = {"low": min(known)[0], "high": max(high for _, high in known)} if known else None
    return {"dates": sorted(dates), "temperature": spans}


def _temperatures(study: StudyFiles, names: list[str]) -> Iterator[tuple[float, float]]:
    """Yield the lowest and highest temperature [°C] of a motor in each recording that has them."""
    for name in names:
        known = study.record(Signals, name).joint_temperatures
        if known is not None:
            yield float(np.nanmin(known)), float(np.nanmax(known))
