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

from pydantic import AfterValidator, ConfigDict, Field, ValidationError
from pydantic_core import ErrorDetails

from ur5lib.errors import InputError
from ur5lib.recordings.quality import SENSORS
from ur5lib.robots.description import Gravity, Payload, robot_names
from ur5lib.stand import layout
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.strict import Strict, existing_file

FILE_KEYS = {"folder", "file", "force_sensor", "imu"}
QUOTE = "'"  # around a discriminator's name, as pydantic tells it

Name = Annotated[  # it becomes a folder's name
    str,
    Field(
        pattern=r"^[A-Za-z0-9_-][A-Za-z0-9_.-]*$",
        description="letters, digits, _ - and, but for the first, .",
    ),
]


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
    folder: str = Field(description="the folder that holds the device files")
    role: Literal["fit", "validate", "contact"] = Field(
        description="fit: contact-free, for fitting; validate: contact-free, never fitted on; "
        "contact: something touches the arm"
    )
    gravity: Gravity | None = Field(
        None,
        description="in the base frame [m/s²], for an arm on a ceiling, a wall or a slope; by "
        "default as in the arm's description",
    )
    payload: Payload | None = Field(
        None,
        description="what the arm carries beyond its description, told to the controller or not; "
        "by default what RTDE's `payload` channels say, else nothing",
    )
    format: str

    def known_payload(self) -> Payload | None:
        """What the study says that the arm carries."""
        return self.payload

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

    force_sensor: Sensor | None = Field(None, description="where there is one")
    imu: Sensor | None = Field(None, description="where there is one")


def _or_simulated(schema: dict[str, Any]) -> None:
    """Either the keys that say where real files are, or `simulate`."""
    files = [key for key in ("folder", "file") if key in schema["required"]]
    schema["required"] = [key for key in schema["required"] if key not in files]
    schema["oneOf"] = [{"required": files}, {"required": ["simulate"]}]


class Simulable(Part):
    """A recording that the virtual test stand can make."""

    model_config = ConfigDict(json_schema_extra=_or_simulated)

    simulate: SimulatedRecording | None = Field(
        None,
        description="let the virtual test stand make it, in raw/<study>/<name>, without the keys "
        "that say where real files are",
    )

    def known_payload(self) -> Payload | None:
        """What the study says that the arm carries, or its plan where the files cannot say it."""
        if self.payload or self.simulate is None or self.format in layout.TELLING:
            return self.payload
        return self.simulate.payload

    def file_names(self) -> list[str]:
        """The files below its folder; those that the stand writes where it makes them."""
        if self.simulate is None:
            return super().file_names()
        return layout.file_names(self.format, self.simulate.model_dump())


class ThesisRecording(Simulable):
    """A folder `csv_files` with one CSV per channel, as the thesis recorded."""

    format: Literal["thesis-csv"]


class StreamRecording(Simulable, Sensors):
    """A capture of the controller's realtime port: received_s,payload_hex."""

    format: Literal["realtime-stream"]
    file: str = Field(description="below the recording's folder")


class RtdeRecording(Simulable, Sensors):
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


ORDER = "of the Butterworth filter, which runs forwards and backwards"
CUTOFF = "where a signal loses half its amplitude (-6 dB)"


class RepairFrames(Strict):
    """Putting frames back on the controller's grid."""

    max_gap_s: float = Field(
        0.1, ge=0, le=1, description="gaps up to this are interpolated, longer ones split"
    )


class FilterSignals(Strict):
    """Zero-phase Butterworth low-pass of the measured signals."""

    order: int = Field(4, ge=1, le=12, description=ORDER)
    cutoff_hz: float = Field(10.0, gt=0, lt=62.5, description=CUTOFF)


class CompareAccelerations(Strict):
    """Zero-phase Butterworth low-pass of joints and IMU where they are compared."""

    order: int = Field(4, ge=1, le=12, description=ORDER)
    cutoff_hz: float = Field(2.0, gt=0, lt=62.5, description=CUTOFF)


FrictionTerm = Literal["stribeck", "saturating", "quadratic", "cubic", "asymmetric"]


class FitFriction(Strict):
    """Torque constants and friction, from currents and motion low-passed without delay."""

    order: int = Field(4, ge=1, le=12, description=ORDER)
    cutoff_hz: float = Field(
        2.0, gt=0, lt=62.5, description="above it, a measured current is noise"
    )
    terms: list[FrictionTerm] = Field(
        [*get_args(FrictionTerm)],
        description="to choose from besides Coulomb, viscous and load-dependent friction and what "
        "comes once a turn; those that predict recordings left out are taken",
    )


class RebuildForces(Strict):
    """The thesis's estimates of a contact force."""

    order: int = Field(5, ge=1, le=12, description="of the low-pass on the external torque")
    cutoff_hz: float = Field(1.454, gt=0, lt=62.5, description="the thesis's (erratum 4)")
    min_singular_value: float = Field(
        0.01, gt=0, le=1, description="of the Jacobian; below it the torques tell no force"
    )


class EstimateForces(Strict):
    """What is known of a contact before any measurement."""

    contact_force_n: float = Field(
        15.0, gt=0, le=1000, description="a usual contact; each contact's own data override it"
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
    title: str = Field(description="of the report")
    recordings: list[Recording] = Field(min_length=1, description="what was recorded")
    reference: Annotated[str, AfterValidator(existing_file)] | None = Field(
        None, description="YAML file of published values and errata to show beside the results"
    )
    hosts: dict[str, list[Literal["force_sensor", "imu"]]] = Field(
        {},
        description="computers, by any name, each with the devices whose stamps its clock gives; "
        "devices of one host share its drift",
    )
    settings: Settings = Field(Settings(), description="of the steps")

    def devices_of_hosts(self) -> dict[str, list[str]]:
        """Each host's devices, by their names in results."""
        return {host: [SENSORS[key] for key in keys] for host, keys in self.hosts.items()}


def parse_study(raw: Mapping[str, Any], source: str) -> Study:
    """The study that a configuration describes.

    raw: the configuration as plain data; source: the file it came from, for the messages.
    Raises InputError with one line for each error found.
    """
    problems = [
        *_missing_folders(raw),
        *_files_of_simulated(raw),
        *_repeated_names(raw),
        *_repeated_files(raw),
        *_devices_on_two_hosts(raw),
    ]
    try:
        study = Study.model_validate(_with_simulated_files(raw))
    except ValidationError as error:
        schema = Study.model_json_schema()
        problems = [_explain(detail, schema) for detail in error.errors()] + problems
    if problems:
        raise InputError("\n".join(f"{source}: {problem}" for problem in problems))
    return study


def schema_text() -> str:
    """The JSON schema of a study, as committed in workflow/study.schema.json."""
    return json.dumps(Study.model_json_schema(), indent=2) + "\n"


def _entries(raw: Mapping[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """The entries of the recordings that are mappings, each after its place."""
    recordings = raw.get("recordings")
    entries = recordings if isinstance(recordings, list) else []
    return [(f"recordings[{k}]", e) for k, e in enumerate(entries) if isinstance(e, dict)]


def _missing_folders(raw: Mapping[str, Any]) -> Iterator[str]:
    for place, entry in _entries(raw):
        folder = entry.get("folder")
        if "simulate" not in entry and isinstance(folder, str) and not Path(folder).is_dir():
            yield (
                f"`{place}.folder` is {_shown(folder)}, which is not in {Path.cwd()}; run in the "
                "project's folder, correct the path, or fetch it (`ur5 fetch thesis`)"
            )


def _files_of_simulated(raw: Mapping[str, Any]) -> Iterator[str]:
    for place, entry in _entries(raw):
        if "simulate" in entry:
            for key in sorted(entry.keys() & FILE_KEYS):
                yield f"`{place}.{key}` says where real files are; leave it or `simulate` out"


def _with_simulated_files(raw: Mapping[str, Any]) -> dict[str, Any]:
    """The configuration, its simulated recordings with the files that the stand will write."""
    study = {**raw}
    if isinstance(raw.get("recordings"), list):
        study["recordings"] = [_with_files(entry, raw.get("study")) for entry in raw["recordings"]]
    return study


def _with_files(entry: Any, study: object) -> Any:
    if not isinstance(entry, dict) or not isinstance(plan := entry.get("simulate"), dict):
        return entry
    files = {"folder": f"raw/{study}/{entry.get('name')}"}
    if entry.get("format") in layout.FORMATS:
        files |= layout.device_keys(entry["format"], plan)
    return entry | files


def _repeated_names(raw: Mapping[str, Any]) -> Iterator[str]:
    names = [entry["name"] for _, entry in _entries(raw) if "name" in entry]
    for name in sorted({str(name) for name in names if names.count(name) > 1}):
        yield f"recordings: two are named {name!r}; give each its own name"


def _repeated_files(raw: Mapping[str, Any]) -> Iterator[str]:
    """Recordings of the same file: what is validated on what it was fitted on proves nothing."""
    real = [entry for _, entry in _entries(raw) if isinstance(entry.get("folder"), str)]
    paths = [str(Path(entry["folder"], str(entry.get("file", "")))) for entry in real]
    for path in sorted({path for path in paths if paths.count(path) > 1}):
        names = [
            str(entry.get("name")) for entry, its in zip(real, paths, strict=True) if its == path
        ]
        yield f"recordings: {' and '.join(names)} are both {path}; give each its own file"


def _devices_on_two_hosts(raw: Mapping[str, Any]) -> Iterator[str]:
    hosts = raw.get("hosts")
    lists = hosts.values() if isinstance(hosts, dict) else []
    named = [device for devices in lists if isinstance(devices, list) for device in devices]
    for device in sorted({str(device) for device in named if named.count(device) > 1}):
        yield f"hosts: {device} is named twice; name it on the one host that stamps its samples"


def arms_without_fit(study: Study) -> list[str]:
    """Arms that no recording of role `fit` is of: their friction, hence forces, stay unknown."""
    fitted = {recording.robot for recording in study.recordings if recording.role == "fit"}
    return sorted({recording.robot for recording in study.recordings} - fitted)


def _explain(error: ErrorDetails, schema: dict[str, Any]) -> str:
    """One sentence for one error: key, value, what is allowed, the nearest valid name."""
    location, node = _descend(schema, error["loc"])
    key, kind = _key(location), error["type"]
    if kind == "extra_forbidden":
        known = _descend(schema, error["loc"][:-1])[1]["properties"]
        return f"unknown key `{key}`{_near(location[-1], known)}; known: {', '.join(known)}"
    if kind.startswith("union_tag"):
        return _explain_tag(error, key, list(branches(node)))
    if kind == "missing":
        return f"`{key}` is missing; give {allowed(node)}"
    near = _near(error["input"], _choices(node))
    told = error["ctx"]["error"] if kind == "value_error" else allowed(node)
    return f"`{key}` is {_shown(error['input'])}{near}; give {told}"


def _explain_tag(error: ErrorDetails, key: str, tags: list[str]) -> str:
    """Of a part that comes in several kinds, told apart by its `format` or `kind`."""
    key = f"{key}.{error['ctx']['discriminator'].strip(QUOTE)}"
    known = f"give one of {', '.join(tags)}"
    if error["type"] == "union_tag_not_found":
        return f"`{key}` is missing; {known}"
    value = error["ctx"]["tag"]
    return f"`{key}` is {value!r}{_near(value, tags)}; {known}"


def _key(location: Iterable[str | int]) -> str:
    parts = (f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return "".join(parts).lstrip(".")


def _descend(
    schema: dict[str, Any], location: Iterable[str | int]
) -> tuple[list[str | int], dict[str, Any]]:
    """The keys of a location, less the tags of its kinds, and what a JSON schema says there."""
    node, keys = schema, list[str | int]()
    for part in location:
        kinds = branches(node)
        if part in kinds:
            node = kinds[str(part)]
        else:
            keys.append(part)
            node = _child(node, part)
        node = next((option for option in node.get("anyOf", []) if "$ref" in option), node)
        if "$ref" in node:
            node = schema["$defs"][node["$ref"].rsplit("/", 1)[-1]]
    return keys, node


def branches(node: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """The kinds of a part by their tags; where values of two types are allowed, these."""
    tags = {ref: tag for tag, ref in node.get("discriminator", {}).get("mapping", {}).items()}
    options = {tags.get(o.get("$ref"), o.get("type")): o for o in node.get("oneOf", [])}
    return {tag: option for tag, option in options.items() if tag is not None}


def _child(node: dict[str, Any], part: str | int) -> dict[str, Any]:
    """What a schema says of a key, or of an entry of a list."""
    if isinstance(part, str):
        return node.get("properties", {}).get(part, node.get("additionalProperties") or {})
    each = node.get("prefixItems", [])
    return each[part] if part < len(each) else node.get("items", {})


def _near(value: object, candidates: Iterable[str]) -> str:
    matches = get_close_matches(str(value), list(candidates), n=1, cutoff=0.5)
    return f" (did you mean `{matches[0]}`?)" if matches else ""


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _choices(node: dict[str, Any]) -> list[str]:
    return node.get("enum", [node["const"]] if "const" in node else [])


def allowed(node: dict[str, Any]) -> str:
    """What a node of a JSON schema allows, in words: "a number above 0 and below 62.5"."""
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
    if "maxItems" in node:
        limits = [f"of {node['maxItems']}"]
    type_ = "object" if "discriminator" in node else node.get("type", "value")
    kind = {"array": "a list", "object": "a mapping"}.get(type_, f"a {type_}")
    if "pattern" in node:
        limits.append(f"of {node['description']}")
    return f"{kind.replace('a integer', 'an integer')} {' and '.join(limits)}".strip()
