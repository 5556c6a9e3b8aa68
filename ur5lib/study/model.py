"""A study: the recordings to analyse, and the settings of every step.

The model below is the whole truth about `config.yaml`; `workflow/study.schema.json` is made from
it.
"""

import json
from typing import Annotated, Any, Literal, get_args

from pydantic import AfterValidator, ConfigDict, Field

from ur5lib.recordings.quality import SENSORS
from ur5lib.robots.description import Gravity, Payload, robot_names
from ur5lib.stand import layout
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.strict import Strict, existing_file

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


def schema_text() -> str:
    """The JSON schema of a study, as committed in workflow/study.schema.json."""
    return json.dumps(Study.model_json_schema(), indent=2) + "\n"


def arms_without_fit(study: Study) -> list[str]:
    """Arms that no recording of role `fit` is of: their friction, hence forces, stay unknown."""
    fitted = {recording.robot for recording in study.recordings if recording.role == "fit"}
    return sorted({recording.robot for recording in study.recordings} - fitted)
