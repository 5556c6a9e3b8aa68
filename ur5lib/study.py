"""A study: the recordings to analyse, and the settings of every step.

The model below is the whole truth about `config.yaml`; `workflow/study.schema.json` is made from
it. All errors of a study are reported at once, each with its key, its value, what is allowed,
and the nearest valid name.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, Field, ValidationError
from pydantic_core import ErrorDetails

from ur5lib.errors import InputError
from ur5lib.robots.description import robot_names
from ur5lib.strict import Strict

Name = Annotated[  # it becomes a folder's name
    str,
    Field(
        pattern=r"^[A-Za-z0-9_-][A-Za-z0-9_.-]*$",
        description="letters, digits, _ - and, but for the first, .",
    ),
]


def _existing_folder(folder: str) -> str:
    if not Path(folder).is_dir():
        raise ValueError("an existing folder; fetch it (`ur5 fetch thesis`) or correct the path")
    return folder


def _existing_file(path: str) -> str:
    if not Path(path).is_file():
        raise ValueError("an existing file")
    return path


FORMATS = ["thesis-csv", "realtime-stream", "rtde-csv", "table-csv"]


def _known_robot(name: str) -> str:
    if name not in robot_names():
        raise ValueError("one of " + ", ".join(robot_names()))
    return name


class Part(Strict):
    """One run of an arm: what every format needs to know of it."""

    name: Name
    robot: Annotated[str, AfterValidator(_known_robot)] = Field(
        description="an arm described in ur5lib/robots/",
        json_schema_extra={"enum": [*robot_names()]},
    )
    folder: Annotated[str, AfterValidator(_existing_folder)] = Field(
        description="the folder that holds the device files"
    )
    role: Literal["fit", "validate", "contact"] = Field(
        description="fit: contact-free, for fitting; validate: contact-free, never fitted on; "
        "contact: something touches the arm"
    )

    def file_names(self) -> list[str]:
        """The files below its folder that it names; none when it means all of them."""
        parts = [self, getattr(self, "force_sensor", None), getattr(self, "imu", None)]
        names = [getattr(part, key, None) for part in parts for key in ("file", "start_file")]
        return [name for name in names if name is not None]


class DeviceTable(Strict):
    """A delimited table of numbers, with or without a header line."""

    file: str = Field(description="below the recording's folder")
    columns: list[str] = Field(
        min_length=1,
        description="what the columns hold, in order: time, then channels by their RTDE names; "
        "a channel without suffix stands for its six columns, - for one to skip",
    )
    units: dict[str, str] = Field(
        default={}, description="of channels that are not in SI units: deg, deg/s, ms, mA, g, ..."
    )
    time: Literal["relative_s", "epoch_s", "day_ms"] = Field(
        "relative_s", description="what the time column counts"
    )


class Sensor(DeviceTable):
    """A force sensor or an IMU with its own clock."""

    start_file: str | None = Field(
        None, description="file with the stamp of the clock's zero, where the time is relative"
    )
    start: Literal["epoch_s", "day_ms"] = Field("epoch_s", description="what that stamp counts")


class Sensors(Strict):
    """The sensors that were recorded besides the robot."""

    force_sensor: Sensor | None = None
    imu: Sensor | None = None


class ThesisRecording(Part):
    """A folder `csv_files` with one CSV per channel, as the thesis recorded."""

    format: Literal["thesis-csv"]


class StreamRecording(Part, Sensors):
    """A capture of the controller's realtime port: received_s,payload_hex."""

    format: Literal["realtime-stream"]
    file: str = Field(description="below the recording's folder")


class RtdeRecording(Part, Sensors):
    """One CSV with RTDE's names in its header, as ur_rtde and the maker's client write."""

    format: Literal["rtde-csv"]
    file: str = Field(description="below the recording's folder")


class TableRecording(Part, DeviceTable, Sensors):
    """Any delimited table whose columns the study names."""

    format: Literal["table-csv"]


Recording = Annotated[
    ThesisRecording | StreamRecording | RtdeRecording | TableRecording,
    Field(discriminator="format"),
]


class RepairFrames(Strict):
    """Putting frames back on the controller's grid."""

    max_gap_s: float = Field(
        0.1, ge=0, le=1, description="gaps up to this are interpolated, longer ones split"
    )


class FilterSignals(Strict):
    """Zero-phase Butterworth low-pass of the measured signals."""

    order: int = Field(4, ge=1, le=12)
    cutoff_hz: float = Field(10.0, gt=0, lt=62.5)


class CompareAccelerations(Strict):
    """Zero-phase Butterworth low-pass of joints and IMU where they are compared."""

    order: int = Field(4, ge=1, le=12)
    cutoff_hz: float = Field(2.0, gt=0, lt=62.5)


FrictionTerm = Literal[
    "load", "stribeck", "saturating", "quadratic", "cubic", "asymmetric", "periodic"
]


class FitFriction(Strict):
    """Torque constants and friction, from currents and motion low-passed without delay."""

    order: int = Field(4, ge=1, le=12)
    cutoff_hz: float = Field(
        2.0, gt=0, lt=62.5, description="above it, a measured current is noise"
    )
    terms: list[FrictionTerm] = Field(
        [*get_args(FrictionTerm)],
        description="to choose from besides Coulomb and viscous friction; those that predict "
        "recordings left out are taken",
    )


class RebuildForces(Strict):
    """The thesis's estimates of a contact force."""

    order: int = Field(5, ge=1, le=12, description="of the low-pass on the external torque")
    cutoff_hz: float = Field(1.454, gt=0, lt=62.5)
    min_singular_value: float = Field(
        0.01, gt=0, le=1, description="of the Jacobian; below it the torques tell no force"
    )


class EstimateForces(Strict):
    """What is known of a contact before any measurement."""

    contact_force_n: float = Field(
        10.0, gt=0, le=1000, description="standard deviation of each component"
    )
    contact_lever_m: float = Field(
        0.05, ge=0, le=1, description="how far from the flange it acts; 0: no moment"
    )


class CompareForces(Strict):
    """The force sensor that estimates are compared with."""

    bias_window_s: float = Field(
        1.0, gt=0, le=60, description="start of a run, free of contact, for the kind “corrected”"
    )


class SetThreshold(Strict):
    """From which odds on a contact is called one."""

    false_alarms_per_min: float = Field(
        1.0, ge=0, le=60, description="at most so many on the recordings for fitting"
    )


class Settings(Strict):
    """Settings of the steps, by rule."""

    repair_frames: RepairFrames = RepairFrames()
    filter_signals: FilterSignals = FilterSignals()
    compare_accelerations: CompareAccelerations = CompareAccelerations()
    fit_friction: FitFriction = FitFriction()
    rebuild_forces: RebuildForces = RebuildForces()
    estimate_forces: EstimateForces = EstimateForces()
    compare_forces: CompareForces = CompareForces()
    set_threshold: SetThreshold = SetThreshold()


class Study(Strict):
    """What `snakemake` analyses; results lie in `results/<study>/`."""

    study: Name
    title: str
    recordings: list[Recording] = Field(min_length=1)
    reference: Annotated[str, AfterValidator(_existing_file)] | None = Field(
        None, description="YAML file of published values and errata to show beside the results"
    )
    settings: Settings = Settings()


def parse_study(raw: Mapping[str, Any], source: str) -> Study:
    """The study that a configuration describes.

    raw: the configuration as plain data; source: the file it came from, for the messages.
    Raises InputError with one line for each error found.
    """
    problems = [f"recordings: {problem}" for problem in _repeated_names(raw)]
    try:
        study = Study.model_validate(raw)
    except ValidationError as error:
        schema = Study.model_json_schema()
        problems = [_explain(detail, schema) for detail in error.errors()] + problems
    if problems:
        raise InputError("\n".join(f"{source}: {problem}" for problem in problems))
    return study


def schema_text() -> str:
    """The JSON schema of a study, as committed in workflow/study.schema.json."""
    return json.dumps(Study.model_json_schema(), indent=2) + "\n"


def _repeated_names(raw: Mapping[str, Any]) -> Iterator[str]:
    recordings = raw.get("recordings")
    entries = recordings if isinstance(recordings, list) else []
    names = [entry["name"] for entry in entries if isinstance(entry, dict) and "name" in entry]
    for name in sorted({str(name) for name in names if names.count(name) > 1}):
        yield f"two are named {name!r}; give each its own name"


def _explain(error: ErrorDetails, schema: dict[str, Any]) -> str:
    """One sentence for one error: key, value, what is allowed, the nearest valid name."""
    location = [part for part in error["loc"] if part not in FORMATS]
    key, kind = _key(location), error["type"]
    if kind == "extra_forbidden":
        known = _node(schema, error["loc"][:-1])["properties"]
        return f"unknown key `{key}`{_near(location[-1], known)}; known: {', '.join(known)}"
    if kind == "union_tag_not_found":
        return f"`{key}.format` is missing; give one of {', '.join(FORMATS)}"
    if kind == "union_tag_invalid":
        value = error["ctx"]["tag"]
        allowed = ", ".join(FORMATS)
        return f"`{key}.format` is {value!r}{_near(value, FORMATS)}; give one of {allowed}"
    node = _node(schema, error["loc"])
    if kind == "missing":
        return f"`{key}` is missing; give {_allowed(node)}"
    near = _near(error["input"], _choices(node))
    allowed = error["ctx"]["error"] if kind == "value_error" else _allowed(node)
    return f"`{key}` is {_shown(error['input'])}{near}; give {allowed}"


def _key(location: Iterable[str | int]) -> str:
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return "".join(parts).lstrip(".")


def _node(schema: dict[str, Any], location: Iterable[str | int]) -> dict[str, Any]:
    """The part of a JSON schema that describes what lies at a location."""
    node = schema
    for part in location:
        if "discriminator" in node:
            node = {"$ref": node["discriminator"]["mapping"][part]}
        elif isinstance(part, int):
            node = node["items"]
        else:
            node = node.get("properties", {}).get(part, {})
        node = next((option for option in node.get("anyOf", []) if "$ref" in option), node)
        if "$ref" in node:
            node = schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
    return node


def _near(value: object, candidates: Iterable[str]) -> str:
    matches = get_close_matches(str(value), list(candidates), n=1, cutoff=0.5)
    return f" (did you mean `{matches[0]}`?)" if matches else ""


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _choices(node: dict[str, Any]) -> list[str]:
    return node.get("enum", [node["const"]] if "const" in node else [])


def _allowed(node: dict[str, Any]) -> str:
    if choices := _choices(node):
        return "one of " + ", ".join(choices)
    bounds = {
        "minimum": "at least",
        "exclusiveMinimum": "above",
        "maximum": "at most",
        "exclusiveMaximum": "below",
        "minItems": "with entries, at least",
    }
    limits = [f"{word} {node[key]}" for key, word in bounds.items() if key in node]
    kind = {"array": "a list", "object": "a mapping"}.get(
        node.get("type", ""), f"a {node.get('type', 'value')}"
    )
    if "pattern" in node:
        limits.append(f"of {node['description']}")
    return f"{kind.replace('a integer', 'an integer')} {' and '.join(limits)}".strip()
