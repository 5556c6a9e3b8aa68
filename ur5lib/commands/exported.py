"""`ur5 export`: an arm, as described or as identified, in the formats of other programs."""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.optimize import nnls

from ur5lib import __version__
from ur5lib.commands.compensation import compensation
from ur5lib.commands.overruled import Overruled, overruled
from ur5lib.errors import InputError, perhaps, unknown
from ur5lib.finished import StudyFiles
from ur5lib.identification.base_parameters import parameter_names
from ur5lib.identification.currents import motor_torque
from ur5lib.recordings.arm_joints import JOINTS
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import CurrentFit, Friction, Parameter
from ur5lib.records.models import BaseParameter, Identification, Rotors
from ur5lib.records.motion import Motion
from ur5lib.robots.description import Robot, described
from ur5lib.robots.exports import JointFriction, isaac, sdf, urdf
from ur5lib.robots.inertia import rigid_bodies, written_bodies
from ur5lib.robots.mjcf import mjcf
from ur5lib.study.turn import reserved
from ur5lib.tables import json_text, write_text
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import DEAD_ZONE
from ur5lib.workspace.topics import modules_of_topics

TcpPose = tuple[float, float, float, float, float, float]
WRITERS: dict[str, Callable[[Robot, str, JointFriction | None, TcpPose | None], str]] = {
    "urdf": lambda arm, model, friction, _: urdf(arm, written_bodies(arm, model), friction),
    "mjcf": mjcf,
    "sdf": lambda arm, model, friction, _: sdf(arm, written_bodies(arm, model), friction),
    "isaac": lambda arm, model, friction, _: isaac(arm, model, friction),
}
ROS_NAMES = [f"{joint}_joint" for joint in JOINTS]  # of a UR's joints, base to wrist
OF_TOPICS = {
    name: write
    for topic in modules_of_topics("exports").values()
    for name, write in topic.FORMATS.items()
}
FOLDERS = {
    name: files_of
    for topic in modules_of_topics("exports").values()
    for name, files_of in getattr(topic, "FOLDERS", {}).items()
}
FORMATS = (*WRITERS, "json", "sensor", *OF_TOPICS, *FOLDERS)
FITTED = ("constants", "currents")  # questions of verdicts.csv about what is fitted to an arm
MIN_MOVING_SAMPLES = 100  # least number that determines a joint's friction
UNIT_NOTE = "SI: m, kg, s, rad, N, Nm, A; joints from 1; low and high: the 95 % interval"
BANDS = "band_moving", "band_reversing", "band_standing", "band_unknown"
FITTED_FIELDS = ("terms", "distances", "held", *BANDS, "contradicted")


def exported(
    robot: str,
    model: str | None,
    to: str,
    results: Path | None,
    as_in: str,
    ros_names: bool = False,
    accept: str = "",
) -> str:
    """Return the text of an arm in a format: one of its link models, by default the chosen or the
    identified one, bias and tool of its force sensor, or an export of a topic.

    results: of a study that identified the arm; as_in: recording with the payload and mounting to
    use, "" for none; ros_names: whether a UR's joints get their names in ROS; accept: reason to
    export values that the verdicts say not to use, which is written to the file. Raises InputError
    for unknown names, missing results, and such verdicts without a reason.
    """
    if to not in FORMATS:
        raise unknown("format", to, FORMATS)
    study = None if results is None else StudyFiles(results)
    if to in FOLDERS:
        raise InputError(f"--format {to} is a folder; name it by --output")
    if to in OF_TOPICS:
        return str(OF_TOPICS[to](study, robot, as_in, accept))
    if to == "sensor":
        return compensation(study, robot, as_in)
    arm = described(robot) if study is None else study.arm(robot)
    if as_in and study is None:
        raise InputError("--as-in names a recording of a study; name its folder by --results")
    if ros_names and not arm.is_ur():
        raise InputError(f"ROS names the joints of a UR, not of {robot}; leave out --ros-names")
    if as_in and study is not None:
        arm = arm.carrying(study.payload(as_in)).mounted(study.recording(as_in).known_gravity())
    model = _link_model(arm, robot, model, study)
    asked = (*FITTED, "links") if model == "identified" else FITTED
    against = _overruled(study, robot, asked, accept)
    friction = None if study is None else simulator_friction(robot, model, study)
    if to in WRITERS:
        text = WRITERS[to](arm, model, friction, tool_centre_point(study, as_in))
        text = re.sub(r"\bjoint_([1-6])\b", called_by_ros, text) if ros_names else text
        return against.as_comment(in_xml=to != "isaac") + text
    parameters = described_arm(arm, model) | against.in_json()
    if study is not None:
        parameters |= identified_parameters(study, robot, friction)
        fitted = {name for names in parameters["fitted_on"].values() for name in names}
        parameters["files"] = {name: study.quality(name).read for name in sorted(fitted)}
    return json_text(parameters)


def write_folder(
    to: str, robot: str, results: Path | None, as_in: str, accept: str, folder: Path
) -> None:
    """Write an export of a topic that has several files, all or none; arguments: as of `exported`.

    Raises InputError if the folder exists.
    """
    study = None if results is None else StudyFiles(results)
    files = FOLDERS[to](study, robot, as_in, accept)
    with reserved(folder), TemporaryDirectory(dir=folder.parent, prefix=".") as aside:
        if folder.exists():
            raise InputError(f"{folder} exists; name another by --output")
        whole = Path(aside, folder.name)
        whole.mkdir()
        for name, text in files.items():
            write_text(text, whole / name)
            if text.startswith("#!"):
                (whole / name).chmod(0o755)
        whole.rename(folder)


def _link_model(arm: Robot, robot: str, model: str | None, study: StudyFiles | None) -> str:
    """Return the link model that is exported. Raises InputError where the arm lacks it."""
    if model is None and arm.links == "unknown":
        raise InputError(
            f"the links of {robot} are placeholders that no fit has replaced; name by --results a "
            "study whose recordings tell them (its report says why, where they do not), or the "
            f"placeholders by --model {arm.chosen_model}"
        )
    model = model or (arm.chosen_model if study is None else arm.fullest_model())
    if model not in arm.models:
        near = perhaps(model, arm.models)
        raise InputError(
            f"{robot} has no link model {model!r}{near}; available: {', '.join(arm.models)}"
        )
    return model


def _overruled(
    study: StudyFiles | None, robot: str, questions: Sequence[str], accept: str
) -> Overruled:
    """Return the study's verdicts against an export, overruled by the reason `accept`; none without
    a study.
    """
    return Overruled() if study is None else overruled(study, robot, questions, accept)


def tool_centre_point(study: StudyFiles | None, recording: str) -> TcpPose | None:
    """Return the tool centre point of a recording, None without a recording or a declared one."""
    tool = study.recording(recording).known_tool() if study and recording else None
    return tool.tcp if tool else None


def called_by_ros(name: re.Match[str]) -> str:
    """Return a joint's name in ROS; name: a match with the joint's number as group 1."""
    return ROS_NAMES[int(name[1]) - 1]


def simulator_friction(robot: str, model: str, study: StudyFiles) -> JointFriction | None:
    """Return the Coulomb and viscous friction closest to the identified friction, which has more
    terms, over the fitted recordings; None without a fit.
    """
    friction = study.parameters(Friction, robot, "friction")
    if not friction.from_:
        return None
    fit = friction.fit
    qd = np.concatenate([study.record(Motion, name).qd for name in friction.from_])
    torque = np.concatenate([friction_torque(fit, study, name, model) for name in friction.from_])
    fitted = map(_coulomb_and_viscous, qd.T, torque.T)
    return JointFriction(*np.array([*fitted]).T)


def friction_torque(fit: CurrentFit, study: StudyFiles, recording: str, model: str) -> Array:
    """Return the predicted torque of friction (N, n) [Nm] in a recording, k i + b - τ."""
    current = study.record(Currents, recording).predicted
    torques = study.record(Torques, recording)
    assert current is not None
    return motor_torque(fit, current) - torques.measured[model] - torques.payload_torque


def _coulomb_and_viscous(qd: Array, torque: Array) -> Array:
    """Return a joint's Coulomb and viscous friction [Nm, Nm s/rad] by non-negative least squares,
    and the share of the torque's mean square that they explain, (3,).

    NaN for a joint with too few samples in motion. qd [rad/s], torque [Nm]: (N,).
    """
    moving = (np.abs(qd) > DEAD_ZONE) & np.isfinite(torque)
    if np.count_nonzero(moving) < MIN_MOVING_SAMPLES:
        return np.full(3, np.nan)
    columns = np.column_stack([np.sign(qd), qd])[moving]
    values, left = nnls(columns, torque[moving])
    return np.append(values, 1 - left**2 / np.sum(torque[moving] ** 2))


def described_arm(arm: Robot, model: str) -> dict[str, Any]:
    """Return an arm's kinematics and limits, and one of its link models as rigid bodies.

    Centres of mass are in the frames of the links, inertia tensors about them.
    """
    keys = {"name", "gravity", "denavit_hartenberg", "calibration", "joints", "motors"}
    return {
        "units": UNIT_NOTE,
        "exported_by": f"ur5lib {__version__}",
        "arm": arm.model_dump(mode="json", include=keys, exclude_none=True),
        "link_model": {"name": model, **asdict(rigid_bodies(arm, model))},
    }


def identified_parameters(
    study: StudyFiles, robot: str, friction: JointFriction | None
) -> dict[str, Any]:
    """Return the identified parameters of an arm with standard errors and intervals.

    friction: in the form of simulators. Lists are empty where nothing could be fitted. Raises
    InputError where a summary is missing.
    """
    rotors, model = (
        study.parameters(Rotors, robot, "rotor_inertia"),
        study.parameters(Identification, robot, "identification"),
    )
    currents = study.parameters(Friction, robot, "friction")
    return {
        "base_parameters": [
            _shown(row, "weights") | _interval(row.value, row.std_error) | {"sum_of": _sum_of(row)}
            for row in model.parameters
        ],
        "rotor_inertia": [*_rotor_rows(rotors)],
        "torque_noise": model.noise,
        "currents": [
            _shown(row, "interval") | dict(zip(("low", "high"), row.interval, strict=True))
            for row in currents.parameters
        ],
        "known_constants": currents.known_constants,
        "current_model": [
            {name: getattr(joint, name) for name in FITTED_FIELDS}
            | {"remarks": [one.sentence() for one in joint.remarks]}
            for joint in currents.fit.joints
        ],
        "simulator_friction": None if friction is None else asdict(friction),
        "fitted_on": {"link_model": model.from_, "currents": currents.from_},
    }


def _sum_of(row: BaseParameter) -> dict[str, float]:
    """Return the nonzero coefficients of the links' parameters in a base parameter, by the
    parameters' names.
    """
    names = parameter_names(len(row.weights))
    return {names[i]: float(row.weights[i]) for i in np.flatnonzero(row.weights)}


def _shown(row: BaseParameter | Parameter, hidden: str) -> dict[str, str | float | bool]:
    """Return the fields of a record except the field named `hidden`."""
    return {name: value for name, value in vars(row).items() if name != hidden}


def _rotor_rows(rotors: Rotors) -> Iterator[dict[str, float]]:
    if rotors.value is not None and rotors.std_error is not None:
        pairs = zip(rotors.value.inertia, rotors.std_error.inertia, strict=True)
        for joint, (value, error) in enumerate(pairs, 1):
            yield {"joint": joint, "value": value, "std_error": error, **_interval(value, error)}


def _interval(value: float, error: float) -> dict[str, float]:
    return {"low": value - NORMAL95 * error, "high": value + NORMAL95 * error}
