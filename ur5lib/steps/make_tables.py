"""The study's tables of results, from the results of all recordings and arms."""

from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path

import pandas as pd

from ur5lib.checks.contacts import CONTACT
from ur5lib.force.residual_model import Residuals
from ur5lib.force.sensed_contact import FREE_ROLES, touched
from ur5lib.records.accelerations import ImuComparison
from ur5lib.records.contacts import Detected
from ur5lib.records.force_errors import Compared
from ur5lib.records.friction import Friction
from ur5lib.records.judgement import Judgement
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.tables import read_cells
from ur5lib.tidy import WORDS, Row, accelerations, columns, files, forces, friction, models, table

RowsByTable = dict[str, dict[str, Iterable[Row]]]  # by table, then by recording


def make_tables(
    judgements: Mapping[str, Judgement],
    beside_imu: Mapping[str, ImuComparison],
    beside_sensor: Mapping[str, Compared],
    contacts: Mapping[str, dict[str, Detected]],
    arm: Mapping[str, Robot],
    rotors: Mapping[str, Rotors],
    identification: Mapping[str, Identification],
    calibration: Mapping[str, dict[str, ImuCalibration]],
    fitted: Mapping[str, Friction],
    residuals: Mapping[str, Residuals],
    parts: list[Path],
    unreadable: dict[str, str],
    roles: dict[str, str] | None = None,
) -> dict[str, pd.DataFrame]:
    """Return each table by its name.

    judgements: of all recordings; beside_imu to contacts: of those in motion; arm to residuals: of
    all arms; parts: CSV files that steps write for each recording or arm, in the folder of its
    name: together they are the table of their name; unreadable: the recordings without a judgement,
    each with the reason; roles: of all, by which a copy of another recording is left out, and which
    say where nothing touches the arm.
    """
    judged, compared, roles = dict(judgements), dict(beside_sensor), roles or {}
    rows = rows_of_recordings(judged, compared, unreadable, roles)
    rows |= rows_of_forces(compared, dict(contacts), roles, loaded(judged))
    written = joined(parts) | {"acceleration_bands": bands_of_accelerations(dict(beside_imu))}
    tables = {name: table(name, own) for name, own in rows.items()} | written
    tables = without_copies(tables, roles)

    def of_arms(name: str, rows: Callable[[str], Iterable[Row]]) -> None:
        tables[name] = table(name, {robot: rows(robot) for robot in arm}, "robot")

    of_arms("imu_calibration", lambda robot: accelerations.imu_calibration(calibration[robot]))
    of_arms("rotor_inertia", lambda robot: models.rotor_inertia(rotors[robot]))
    of_arms("parameters", lambda robot: models.parameters(identification[robot]))
    of_arms("excitation", lambda robot: models.excitation(identification[robot]))
    of_arms("friction", lambda robot: friction.friction(fitted[robot], arm[robot]))
    of_arms("torque_constants", lambda robot: friction.torque_constants(fitted[robot], arm[robot]))
    of_arms("cross_validation", lambda robot: friction.cross_validation(fitted[robot]))
    of_arms(
        "remarks",
        lambda robot: models.remarks(identification[robot], fitted[robot], residuals[robot]),
    )
    return tables


def rows_of_forces(
    compared: Mapping[str, Compared],
    contacts: Mapping[str, dict[str, Detected]],
    roles: Mapping[str, str] | None = None,
    loaded: Collection[str] = (),
) -> RowsByTable:
    """Return the rows about forces and contacts; loaded: recordings with an undeclared load."""
    roles = roles or {}
    free = {name for name, role in roles.items() if role in FREE_ROLES} - {*loaded}
    return {
        "force_mae": {
            name: forces.force_mae(one, roles.get(name, "")) for name, one in compared.items()
        },
        "contact_errors": {
            name: forces.contact_errors(one, contacts.get(name)) for name, one in compared.items()
        },
        "sensed": {name: forces.sensed(one) for name, one in compared.items()},
        "detection": {name: forces.detection(one) for name, one in contacts.items()},
        "fixed_threshold": {name: forces.fixed_threshold(one) for name, one in contacts.items()},
        "contacts": {name: forces.contacts(one, name in free) for name, one in contacts.items()},
    }


def loaded(judgements: Mapping[str, Judgement]) -> set[str]:
    """Return the recordings whose currents show for certain a load that nobody declared."""
    return {
        name
        for name, one in judgements.items()
        if any(row.get("taken") == WORDS[True] for row in one.rows.get("payload", ()))
    }


def rows_of_recordings(
    judgements: Mapping[str, Judgement],
    compared: Mapping[str, Compared],
    unreadable: Mapping[str, str],
    roles: Mapping[str, str] | None = None,
) -> RowsByTable:
    """Return the rows that recordings' judgements hold, and all findings; of recordings that cannot
    be read, a stop sign.
    """
    roles = roles or {}
    rows: RowsByTable = {
        name: {recording: one.rows.get(name, ()) for recording, one in judgements.items()}
        for name, own in columns().items()
        if "recording" in own
    }
    found = {name: one.findings for name, one in judgements.items()}
    found |= {
        name: beside_sensor_findings(found[name], one, roles.get(name, ""))
        for name, one in compared.items()
    }
    rows["quality"] = {name: map(files.row, own) for name, own in found.items()}
    rows["quality"] |= {name: [files.unreadable(why)] for name, why in unreadable.items()}
    return rows


def beside_sensor_findings(own: list[Finding], compared: Compared, role: str) -> list[Finding]:
    """Return the findings of a recording with those beside its force sensor.

    own: by its files, whose warning of a contact in the raw readings says less than the error.
    """
    if (touch := touched(compared.felt, role)) is not None:
        raw = ("force", CONTACT)
        own = [one for one in own if (one.device, one.finding) != raw] + [touch]
    return own + compared.findings()


def without_copies(
    tables: Mapping[str, pd.DataFrame], roles: Mapping[str, str]
) -> dict[str, pd.DataFrame]:
    """Return the tables of recordings; of copies of another recording, the findings alone."""
    quality = tables["quality"]
    copies = files.spare_copies(quality, roles)
    kept = {
        name: own[~own["recording"].isin(copies)] if "recording" in own else own
        for name, own in tables.items()
    }
    return kept | {"quality": files.name_copies(quality, roles)}


def bands_of_accelerations(imu: Mapping[str, ImuComparison]) -> pd.DataFrame:
    """Return the table of the bands of accelerations, each from the other recordings."""
    rows = {name: accelerations.acceleration_bands(one, imu) for name, one in imu.items()}
    return table("acceleration_bands", rows)


def joined(parts: Iterable[Path]) -> dict[str, pd.DataFrame]:
    """Return the tables that steps have written for each recording or arm, by name; cells as text.

    Those of a recording lie in a folder of `recordings`.
    """
    by_name: dict[tuple[str, str], dict[str, pd.DataFrame]] = {}
    for part in parts:
        owner = "recording" if part.parents[1].name == "recordings" else "robot"
        by_name.setdefault((part.stem, owner), {})[part.parent.name] = read_cells(part)
    return {
        name: pd.concat(own, names=[owner, None]).reset_index(owner)
        for (name, owner), own in by_name.items()
    }
