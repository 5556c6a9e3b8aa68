"""`ur5 export --to live`: what a causal estimate of the force needs of an arm, as JSON."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from ur5lib import __version__
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.force.detection import CONTACT_FORCE
from ur5lib.force.live_file import Measured, follow, learned, numbers
from ur5lib.force.residual_model import Residuals
from ur5lib.identification.samples import path_of
from ur5lib.records.forces import SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.prediction import Prediction
from ur5lib.records.signals import Signals
from ur5lib.records.wording import in_words
from ur5lib.robots.description import Robot
from ur5lib.study.model import Recording
from ur5lib.tables import json_text, read_record
from ur5lib.timeseries.trajectories import group_by_path

FORMAT = "ur5lib live 1"
UNITS = "SI: m, kg, s, rad, N, Nm, A; links in the axes of their joint, joints from 1"


def live_arm(study: FinishedStudy | None, robot: str, as_in: str) -> str:
    """Return the file of an arm; as_in: recording whose payload and mounting it has, "" for none.

    Raises InputError where no force may be stated, with the report's reason.
    """
    if study is None:
        raise InputError("--to live is what a study fitted; name its folder by --results")
    arm, friction = study.arm(robot), study.parameters(Friction, robot, "friction")
    refused = study.parameters(Residuals, robot, "residuals").refused
    for remark in (friction.stopped, friction.refused, refused):
        if remark is not None:
            raise InputError(f"no force of {robot} is stated: {in_words(remark)}")
    entries = [one for one in study.configuration().recordings if one.arm.known_as == robot]
    runs = {entry.name: run for entry in entries if (run := _measured(study, arm, entry))}
    fitted = [name for name in friction.from_ if name in runs]
    if not fitted:
        raise InputError(
            f"{study.folder} has no recording without contact that {robot} was fitted to; add one "
            "of the role `fit`, with currents"
        )
    paths = [
        path_of(run.q, np.gradient(run.q, run.period, axis=0), run.period)
        for run in (runs[name][1] for name in fitted)
    ]
    allowed = study.configuration().settings.alarms.false_per_min
    known = learned([runs[name] for name in fitted], len(set(group_by_path(paths))), allowed)
    mounted = arm.mounted(study.recording(as_in).known_gravity()) if as_in else arm
    payload = study.payload(as_in) if as_in else None
    judged = [
        _judged(study, entry, {**runs[entry.name][0], **known}, runs[entry.name][1])
        for entry in entries
        if entry.name in runs and entry.name not in fitted
    ]
    head = {"format": FORMAT, "units": UNITS, "exported_by": f"ur5lib {__version__}"}
    return json_text(
        head
        | {"arm": robot, "payload": payload and payload.model_dump(mode="json")}
        | numbers(mounted, friction, "", payload)
        | known
        | {"validity": _validity(study, entries, fitted), "judged_on": judged}
        | {"fitted_on": {name: study.quality(name).read for name in fitted}}
    )


def _measured(
    study: FinishedStudy, arm: Robot, entry: Recording
) -> tuple[dict[str, Any], Measured] | None:
    """Return the arm in a recording and its samples, None at rest, unread, or with a load."""
    folder = study.folder / "recordings" / entry.name
    if entry.at_rest or not (folder / "currents.json").is_file():
        return None
    run = Measured.of(study.record(Signals, entry.name))
    if run is None or read_record(Prediction, folder / "currents.json").is_loaded:
        return None
    friction = study.parameters(Friction, entry.arm.known_as, "friction")
    mounted = arm.mounted(entry.known_gravity())
    return numbers(mounted, friction, entry.name, study.payload(entry.name)), run


def _judged(
    study: FinishedStudy, entry: Recording, arm: dict[str, Any], run: Measured
) -> dict[str, Any]:
    """Return how the estimator does on a recording that nothing was learnt from."""
    found = follow(arm, run)
    row: dict[str, Any] = {"recording": entry.name, "role": entry.role}
    row |= {"alarms": len(found.alarms()), "known_share": found.known()}
    row |= {"minutes": len(run.time) * run.period / 60, "rmse_in_contact": None}
    path = study.folder / "recordings" / entry.name / "sensor.parquet"
    sensed = SensorWrenches.read(path).wrench.get("compensated") if path.is_file() else None
    if sensed is not None:
        touched = np.linalg.norm(sensed[:, :3], axis=1) > CONTACT_FORCE
        if touched.any():
            squares = ((found.wrench - sensed)[touched, :3] ** 2).sum(axis=1)
            row["rmse_in_contact"] = float(np.sqrt(np.nanmean(squares)))
    return row


def _validity(study: FinishedStudy, entries: list[Recording], fitted: list[str]) -> dict[str, Any]:
    """Return the dates of the recordings fitted to, and their motors' temperatures [°C]."""
    dates = {str(one.date) for one in entries if one.name in fitted and one.date is not None}
    known = [*_temperatures(study, fitted)]
    spans = {"low": min(known)[0], "high": max(high for _, high in known)} if known else None
    return {"dates": sorted(dates), "temperature": spans}


def _temperatures(study: FinishedStudy, names: list[str]) -> Iterator[tuple[float, float]]:
    """Yield the lowest and highest temperature [°C] of a motor in each recording that has them."""
    for name in names:
        known = study.record(Signals, name).joint_temperatures
        if known is not None:
            yield float(np.nanmin(known)), float(np.nanmax(known))
