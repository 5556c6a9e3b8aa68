"""The study's tables of results, from the results of all recordings and arms."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import pandas as pd

from ur5lib.checks import files
from ur5lib.errors import Remark
from ur5lib.force.residual_model import Residuals
from ur5lib.force.touched import touched
from ur5lib.judging.acceleration_bands import acceleration_bands
from ur5lib.judging.may_be_used import friction_rows, torque_constants
from ur5lib.records.acceleration_errors import AccelerationBand, AccelerationError, Innovation
from ur5lib.records.accelerations import ImuComparison
from ur5lib.records.account import AccountRow
from ur5lib.records.codes import Found
from ur5lib.records.contact_place import PlaceRow
from ur5lib.records.contacts import Contact, ContactError, Contacts, Detection, FixedThreshold
from ur5lib.records.fits import (
    CalibratedQuantity,
    CrossValidation,
    ExcitationRow,
    FrictionRow,
    ParameterRow,
    RemarkRow,
    RotorRow,
    TorqueConstant,
)
from ur5lib.records.force_errors import Compared, ForceError, Sensed
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import (
    ClockRow,
    CurrentError,
    FileRead,
    JointPath,
    Judgement,
    LoadRow,
    QualityRow,
    RecordingSummary,
    TorqueError,
)
from ur5lib.records.models import Identification, Rotors, Terms
from ur5lib.records.opened import Opened
from ur5lib.records.quality import STOP, Finding
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.tables import read_cells, table_by_owner

OF_RECORDINGS = {
    "recordings": RecordingSummary,
    "paths": JointPath,
    "files": FileRead,
    "account": AccountRow,
    "quality": QualityRow,
    "clocks": ClockRow,
    "acceleration_bands": AccelerationBand,
    "torque_mae": TorqueError,
    "current_rmse": CurrentError,
    "payload": LoadRow,
    "force_mae": ForceError,
    "contact_errors": ContactError,
    "sensed": Sensed,
    "detection": Detection,
    "fixed_threshold": FixedThreshold,
    "contacts": Contact,
    "contact_place": PlaceRow,
}
OF_ARMS = {
    "imu_calibration": CalibratedQuantity,
    "rotor_inertia": RotorRow,
    "parameters": ParameterRow,
    "excitation": ExcitationRow,
    "remarks": RemarkRow,
    "friction": FrictionRow,
    "torque_constants": TorqueConstant,
    "cross_validation": CrossValidation,
}

OF_MOTION = {  # another step makes these; they are empty if all recordings are at rest
    "acceleration_mae": AccelerationError,
    "innovations": Innovation,
}
CALIBRATED = {"mounting": "rad", "tilt": "rad", "gyroscope_bias": "rad/s", "place": "m"}

Rows = Mapping[str, Iterable[object]]  # rows of a table, by recording or arm


class Fits(Opened):
    """What is read of an arm."""

    identified: Robot
    rotors: Rotors
    identification: Identification
    friction: Friction


class Inputs(Opened):
    """What is read of a recording."""

    comparison: ImuComparison
    compared: Compared
    contacts: Contacts


def make_tables(
    judgements: Mapping[str, Judgement],
    recordings: Mapping[str, Inputs],
    arms: Mapping[str, Fits],
    calibration: Mapping[str, dict[str, ImuCalibration]],
    residuals: Mapping[str, Residuals],
    parts: list[Path],
    unreadable: dict[str, str],
    roles: dict[str, str] | None = None,
) -> dict[str, pd.DataFrame]:
    """Return each table by its name.

    judgements: of all recordings; recordings: those in motion; calibration: of each arm's IMU;
    parts: CSV files of each recording or arm, in folders of their names, which are joined to one
    table for each file name; unreadable: recordings without a judgement, each with the reason;
    roles: of all, which decide which copy of a recording is left out, and where nothing touches the
    arm.
    """
    roles, judged, moved = roles or {}, dict(judgements), dict(recordings)
    compared = {name: recording.compared for name, recording in moved.items()}
    contacts = {name: recording.contacts for name, recording in moved.items()}
    imu = {name: recording.comparison for name, recording in moved.items()}
    rows = rows_of_recordings(judged, compared, contacts, imu)
    rows["quality"] = found_of_recordings(judged, compared, contacts, unreadable, roles)
    pushed = {name for name, one in compared.items() if touched(one.sensed, roles.get(name, ""))}
    each = {
        robot: rows_of_arm(arm, calibration[robot], residuals[robot], pushed)
        for robot, arm in arms.items()
    }
    of_arms = {name: {robot: own[name] for robot, own in each.items()} for name in OF_ARMS}
    tables = {name: table_by_owner(kind, {}) for name, kind in OF_MOTION.items()} | joined(parts)
    tables |= {name: table_by_owner(kind, rows[name]) for name, kind in OF_RECORDINGS.items()}
    return without_copies(tables, roles) | {
        name: table_by_owner(kind, of_arms[name], "robot") for name, kind in OF_ARMS.items()
    }


def rows_of_arm(
    arm: Fits,
    calibration: Mapping[str, ImuCalibration],
    residuals: Residuals,
    pushed: set[str],
) -> dict[str, Iterable[object]]:
    """Return the rows of an arm by table; pushed: the recordings without the role of a contact on
    which a force sensor reads some.
    """
    friction, identification = arm.friction, arm.identification
    is_touched = not pushed.isdisjoint(friction.from_)
    return {
        "imu_calibration": calibrated(calibration),
        "rotor_inertia": rotor_rows(arm.rotors),
        "parameters": identification.parameters,
        "excitation": excited(identification),
        "friction": friction_rows(friction, arm.identified, is_touched),
        "torque_constants": torque_constants(friction, arm.identified, is_touched),
        "cross_validation": cross_validated(friction),
        "remarks": remarks(identification, friction, residuals),
    }


def rows_of_recordings(
    judged: Mapping[str, Judgement],
    compared: Mapping[str, Compared],
    contacts: Mapping[str, Contacts],
    imu: Mapping[str, ImuComparison],
) -> dict[str, Rows]:
    """Return the rows of recordings, by table and then by recording: from their judgements, and
    from the comparisons with their sensors.
    """
    return {
        **{
            field.name: {name: getattr(one, field.name) for name, one in judged.items()}
            for field in fields(Judgement)
            if field.name in OF_RECORDINGS
        },
        "acceleration_bands": {name: acceleration_bands(one, imu) for name, one in imu.items()},
        "force_mae": {name: one.errors for name, one in compared.items()},
        "sensed": {name: [one.sensed] for name, one in compared.items() if one.sensed},
        "contact_errors": {name: one.errors for name, one in contacts.items()},
        "detection": {name: one.detections for name, one in contacts.items()},
        "fixed_threshold": {name: one.fixed_thresholds for name, one in contacts.items()},
        "contacts": {name: one.contacts for name, one in contacts.items()},
        "contact_place": {name: one.places for name, one in contacts.items()},
    }


def found_of_recordings(
    judged: Mapping[str, Judgement],
    compared: Mapping[str, Compared],
    contacts: Mapping[str, Contacts],
    unreadable: Mapping[str, str],
    roles: Mapping[str, str],
) -> Rows:
    """Return the rows of all findings; a recording that cannot be read has a stop sign."""
    found = {name: one.findings for name, one in judged.items()}
    found |= {
        name: beside_sensor_findings(found[name], one, roles.get(name, ""))
        for name, one in compared.items()
    }
    found |= {name: found[name] + one.findings() for name, one in contacts.items()}
    rows = {name: [*map(files.quality_row, own)] for name, own in found.items()}
    return rows | {name: [files.unreadable(why)] for name, why in unreadable.items()}


def beside_sensor_findings(own: list[Finding], compared: Compared, role: str) -> list[Finding]:
    """Return the findings on a recording, from its files and from the comparison with its force
    sensor.

    own: those from its files; an error that the sensor reads contacts replaces their warning of
    contact in raw readings.
    """
    if (touch := touched(compared.sensed, role)) is not None:
        raw = ("force", Found.CONTACT)
        own = [one for one in own if (one.device, one.code) != raw] + [touch]
    return own + compared.findings()


def without_copies(
    tables: Mapping[str, pd.DataFrame], roles: Mapping[str, str]
) -> dict[str, pd.DataFrame]:
    """Return the tables without copies of other recordings, except for their findings."""
    quality = tables["quality"]
    copies = files.spare_copies(quality, roles)
    kept = {
        name: own[~own["recording"].isin(copies)] if "recording" in own else own
        for name, own in tables.items()
    }
    return kept | {"quality": files.name_copies(quality, roles)}


def calibrated(calibration: Mapping[str, ImuCalibration]) -> Iterator[CalibratedQuantity]:
    """Yield the calibration of an arm's IMU from all `fit` recordings; nothing if there is none."""
    if (fit := calibration.get("all")) is None:
        return
    for quantity, unit in CALIBRATED.items():
        values, errors = getattr(fit, quantity), getattr(fit, f"{quantity}_std")
        for k, (axis, value, std) in enumerate(zip("xyz", values, errors, strict=False)):
            of_place = quantity == "place"
            yield CalibratedQuantity(
                quantity=quantity,
                axis=axis,
                unit=unit,
                value=float(value),
                std_error=float(std),
                described=float(fit.described[k]) if of_place else None,
                held_out=fit.held_out if of_place else None,
            )


def rotor_rows(rotors: Rotors) -> Iterator[RotorRow]:
    """Yield rotor inertias, with the further fitted terms, which should be zero."""
    if rotors.value is None or rotors.std_error is None:
        return
    pairs = zip(_by_joint(rotors.value), _by_joint(rotors.std_error), strict=True)
    for joint, (value, std) in enumerate(pairs, start=1):
        terms = {"value": value.pop("inertia"), "std_error": std.pop("inertia")}
        errors = {f"{name}_std_error": error for name, error in std.items()}
        yield RotorRow(joint=joint, **terms, **value, **errors)


def _by_joint(terms: Terms) -> Iterator[dict[str, float]]:
    """Yield the terms of each joint by name, joint after joint."""
    for values in zip(*vars(terms).values(), strict=True):
        yield dict(zip(vars(terms), map(float, values), strict=True))


def excited(identification: Identification) -> Iterator[ExcitationRow]:
    """Yield what the recordings determine of an arm's parameters, and advice on what to record;
    nothing without an identified model.
    """
    if (found := identification.excitation) is not None:
        yield ExcitationRow(
            combinations=found.combinations,
            undetermined=len(found.undetermined),
            **found.condition,
            advice="; ".join(one.text for one in found.advice),
            motion=(found.advice[0].motion or None) if found.advice else None,
        )


def cross_validated(friction: Friction) -> Iterator[CrossValidation]:
    """Yield, for each pair of recordings, the RMSE of the fit to one that is tested on the
    other.
    """
    names, tested = friction.from_, friction.cross_validation
    for fitted_on, errors in zip(names, tested, strict=True):
        for tested_on, each in zip(names, errors, strict=True):
            about: dict[str, Any] = {"fitted_on": fitted_on, "tested_on": tested_on}
            for joint, rmse in enumerate(each.tolist(), start=1):
                yield CrossValidation(**about, joint=joint, rmse_lowpassed=rmse)


def remarks(
    identification: Identification, friction: Friction, residuals: Residuals
) -> Iterator[RemarkRow]:
    """Yield remarks on the fits of an arm by joint, and reasons of failed fits."""
    fits = {"identification": identification, "friction": friction, "contact forces": residuals}
    for step, fitted in fits.items():
        refused = filter(None, [getattr(fitted, "refused", None)])
        yield from (_remark(step, one) for one in [*getattr(fitted, "remarks", ()), *refused])
        if isinstance(fitted, Friction):
            yield from _remarks_of_joints(fitted)


def _remarks_of_joints(friction: Friction) -> Iterator[RemarkRow]:
    if friction.stopped is not None:
        yield _remark(STOP, friction.stopped)
    for joint, fit in enumerate(friction.fit.joints, start=1):
        yield from (_remark("friction", one, joint) for one in fit.remarks)


def _remark(step: str, remark: Remark, joint: int | None = None) -> RemarkRow:
    return RemarkRow(step=step, joint=joint, remark=remark.sentence(), code=remark.code)


def joined(parts: Iterable[Path]) -> dict[str, pd.DataFrame]:
    """Return tables that steps wrote for each recording or arm, joined by name; cells as text.

    parts: a file of a recording lies in recordings/<recording>/, one of an arm in another folder
    with the arm's name.
    """
    by_name: dict[tuple[str, str], dict[str, pd.DataFrame]] = {}
    for part in parts:
        owner = "recording" if part.parents[1].name == "recordings" else "robot"
        by_name.setdefault((part.stem, owner), {})[part.parent.name] = read_cells(part)
    return {
        name: pd.concat(own, names=[owner, None]).reset_index(owner)
        for (name, owner), own in by_name.items()
    }
