"""What to do next: errors of the set-up first, then files, then recordings."""

from collections.abc import Iterator
from typing import Any, Literal

from ur5lib.judging.limits import HIGH_LOST_SHARE
from ur5lib.judging.recordings import felt_while_fitted, lost_shares
from ur5lib.judging.study import AT_REST, StudyTables
from ur5lib.records.codes import CauseCode
from ur5lib.records.quality import STOP
from ur5lib.records.verdicts import Advice, Asks

RECORD: Literal["recording"] = "recording"  # kinds of advice
LATER: Literal["later"] = "later"
CONTRADICTIONS = [
    CauseCode.UNLIKELY_CONSTANT,
    CauseCode.CURRENT_AGAINST_CONSTANT,
    CauseCode.TORQUE_AGAINST_GAIN,
]
ASKING = {  # by the remarks
    CauseCode.NO_MOTION: Asks.NO_MOTION,
    CauseCode.ONE_PATH: Asks.ONE_PATH,
    CauseCode.FEW_PATHS: Asks.FEW_PATHS,
}


def advice(study: StudyTables) -> Iterator[Advice]:
    """Yield what to do next, the most urgent first."""
    yield from corrections(study)
    yield from faulty_files(study)
    if study.silent() < {*study.roles()}:
        yield from missing_recordings(study)
    else:
        yield from _of_recordings(Asks.NO_EFFORT, [*study.roles()])


def corrections(study: StudyTables) -> Iterator[Advice]:
    """Ask to correct what contradicts the study: stop signs, contacts in recordings with a role
    that denies them, payloads that only the currents show, and constants far from the documented
    ones.
    """
    yield from _stops(study)
    yield from _of_recordings(Asks.TOUCHED, study.touched())
    felt = [name for name in felt_while_fitted(study) if name not in study.touched()]
    yield from _of_recordings(Asks.FELT, felt)
    hidden = study.rows("remarks", code=CauseCode.HIDDEN_CONTACT)
    for row in hidden[:1].itertuples():
        about: Any = {"robot": row.robot, "recordings": len(hidden), "detail": row.remark}
        yield Advice(code=Asks.HIDDEN, kind="correction", value=len(hidden) - 1, **about)
    loads = study.rows("payload", taken="yes")
    for row in loads[:1].itertuples():
        mass = {"value": row.configured + row.mass, "std_error": row.std_error}
        count = loads["recording"].nunique()
        yield Advice(
            code=Asks.PAYLOAD, kind="correction", recording=row.recording, recordings=count, **mass
        )
    for row in study.rows("remarks", code=CauseCode.EXPLAINED_CONTRADICTION).itertuples():
        yield Advice(code=Asks.EXPLAINED, kind="correction", robot=row.robot, detail=row.remark)
    for robot, (shown, _) in _contradicted(study).items():
        if shown:
            yield Advice(
                code=Asks.CONTRADICTION, kind="correction", robot=robot, joints=_listed(shown)
            )


def _stops(study: StudyTables) -> Iterator[Advice]:
    """Yield the first stop sign of a recording and the first of an arm that is not one of these."""
    stops = study.rows("quality", severity="stop")
    for detail in stops["detail"][:1]:
        names = [*stops.loc[stops["detail"] == detail, "recording"].unique()]
        yield from _of_recordings(Asks.STOP_RECORDING, names, detail=detail)
    for row in study.rows("remarks", step=STOP).itertuples():
        if not any(detail in row.remark for detail in stops["detail"]):
            yield Advice(code=Asks.STOP_ARM, kind="correction", robot=row.robot, detail=row.remark)
            return


def _of_recordings(
    code: Asks, names: list[str], value: float | None = None, detail: str = ""
) -> Iterator[Advice]:
    """Yield one piece of advice that names the first recording and counts all of them."""
    if names:
        about: Any = {"recording": names[0], "recordings": len(names)}
        yield Advice(code=code, kind="correction", value=value, detail=detail, **about)


def _contradicted(study: StudyTables) -> dict[str, tuple[list[int], list[int]]]:
    """Return by arm the joints with constants that contradict the documented ones without a clear
    cause: first those that gravity loads, then those with currents that say little about constants.
    """
    found: dict[str, tuple[list[int], list[int]]] = {}
    for row in study.rows("remarks", code=CONTRADICTIONS).itertuples():
        shows = row.joint in study.bearing.get(row.robot, [row.joint])
        found.setdefault(row.robot, ([], []))[not shows].append(int(row.joint))
    return found


def _listed(joints: list[int]) -> str:
    return " ".join(map(str, joints))


def faulty_files(study: StudyTables) -> Iterator[Advice]:
    """Name recordings that lost many frames, and those with a doubtful bias of the force sensor."""
    shares = lost_shares(study)
    lost = {name: share for name, share in shares.items() if share >= HIGH_LOST_SHARE}
    names = sorted(lost, key=lambda name: -lost[name])
    yield from _of_recordings(Asks.LOSSY, names, lost[names[0]] if names else None)
    yield from _of_recordings(Asks.DOUBTED, study.doubted())


def missing_recordings(study: StudyTables) -> Iterator[Advice]:
    """Ask for recordings that would determine the parameters still undetermined."""
    for robot in sorted(study.placeholders.difference(study.listed("parameters", "robot"))):
        refused = study.rows("remarks", robot=robot, step="identification")
        why = "; ".join(refused["remark"])
        yield Advice(code=Asks.UNKNOWN_LINKS, kind=RECORD, robot=robot, detail=why)
    remarks = study.rows("remarks", code=[*ASKING])
    order = remarks.assign(order=remarks["code"].map([*ASKING].index))
    for (_, robot, code), part in order.groupby(["order", "robot", "code"], sort=True):
        joints = _listed([*part["joint"].astype(int)])
        kind = LATER if ASKING[code] == Asks.FEW_PATHS else RECORD  # surer intervals only
        yield Advice(code=ASKING[code], kind=kind, robot=robot, joints=joints)
    for role in (Asks.FIT, Asks.VALIDATE):
        if not study.with_role(role):
            detail = AT_REST if study.with_role(AT_REST) else ""
            yield Advice(code=role, kind=RECORD, detail=detail)
    for row in study.tables["excitation"].dropna(subset="motion").itertuples():
        yield Advice(code=Asks.ADVISED, kind=RECORD, robot=row.robot, detail=row.motion)
    for robot, (_, light) in _contradicted(study).items():
        if light:
            load = study.loads.get(robot)
            yield Advice(
                code=Asks.LIGHT, kind=RECORD, robot=robot, joints=_listed(light), value=load
            )
    sensed = study.tables["sensed"]
    if study.tables["force_mae"].empty and not (sensed["contacts"] > 0).any():
        yield Advice(code=Asks.PUSHES, kind=RECORD)
