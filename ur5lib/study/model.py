"""A study: the recordings to analyse, and the settings of every step.

The model below defines every key of `config.yaml`; `workflow/study.schema.json` and
`docs/settings.md` are generated from it.
"""

import datetime
import json
from functools import cached_property
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

from ur5lib.recordings.entries import (
    ChannelFiles,
    Files,
    RtdeFiles,
    StoredFiles,
    StreamFiles,
    TableFiles,
    ThesisFiles,
)
from ur5lib.records.contact_place import TOOL_RADIUS
from ur5lib.records.quality import SENSORS
from ur5lib.robots.description import Gravity, Payload, Vector3
from ur5lib.stand import layout
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.strict import PathText, Strict, existing_file
from ur5lib.study.accept import Accept
from ur5lib.study.arms import ArmSettings, MountingSetting, Name, NamedArm, Tool
from ur5lib.study.devices import LabSettings

ORDER_TEXT = "order of the Butterworth filter, which runs forwards and backwards"
PREVIOUS = "previous"  # `after`: each file of a pattern follows the previous one
CUTOFF_TEXT = (
    "frequency at which a signal loses half its amplitude (-6 dB); a recording of at most twice "
    "this rate is not filtered"
)


def _day(value: Any) -> datetime.date:
    """Return the day of a date or time from YAML."""
    try:
        stated = value if isinstance(value, datetime.date) else datetime.date.fromisoformat(value)
    except (TypeError, ValueError):
        raise ValueError("a date, as in 2026-03-09") from None
    return stated.date() if isinstance(stated, datetime.datetime) else stated


Day = Annotated[datetime.date, BeforeValidator(_day)]


Second = Annotated[float, Field(ge=0, allow_inf_nan=False)]


def _in_order(span: tuple[float, float]) -> tuple[float, float]:
    if span[1] <= span[0]:
        raise ValueError("a start and a later end [s]")
    return span


class ContactPlaceSetting(Strict):
    """The place on the arm where contacts are expected."""

    position_m: Vector3 = Field(description="place in frame 6 [m]")
    within_m: float = Field(
        TOOL_RADIUS, gt=0, le=2, description="usual distance of a contact from it [m]"
    )


class Part(Strict):
    """One run of an arm, and its use in the study: the keys that every format has."""

    name: Name
    robot: NamedArm | None = Field(
        None,
        description="the arm, as described in ur5lib/robots/ or robots/, or a mapping with its "
        "differences; default: `robot` of the study",
    )
    role: Literal["fit", "validate", "contact"] = Field(
        description="fit: contact-free, used for fitting; validate: contact-free, never used for "
        "fitting; contact: something touches the arm"
    )
    gravity: Gravity | None = Field(
        None,
        description="vector in the base frame [m/s²], for an arm on a ceiling, a wall or a slope; "
        "default: that of the arm's description",
    )
    mounting: MountingSetting | None = Field(
        None,
        description="how the arm stands: floor, wall, ceiling, angles, or gravity in the base "
        "frame [m/s²]; default: that of `robot`",
    )
    tool: Tool | None = Field(
        None, description="what is mounted on the flange; default: that of `robot`"
    )
    payload: Payload | None = Field(
        None,
        description="load on the flange that the arm's description and its tool lack, whether the "
        "controller knows it or not; default: the recorded `payload` channels of RTDE, otherwise "
        "none",
    )
    contact_place: ContactPlaceSetting | None = Field(
        None,
        description="place where the arm is touched; default: the tool centre point, of `tool` or "
        "recorded, else anywhere on the wrist",
    )
    date: Day | None = Field(
        None,
        description="day of the recording, as in 2026-03-09; default: that of its start stamp (UTC)"
        ", where it has one; six dates or more show how an arm changes",
    )
    after: str | None = Field(
        None,
        min_length=1,
        description="recording of the arm that came directly before, nothing having moved it in "
        "between: what friction remembers of that motion is known at the start; `previous`: each "
        "file of a pattern follows the one before it, by the numbers in their paths",
    )
    untouched: Annotated[tuple[Second, Second], AfterValidator(_in_order)] | None = Field(
        None,
        description="span [s] from the recording's start in which the arm rests and nothing "
        "touches it, as in [0, 1.5]: a tare for the forces of role `contact`",
    )

    accept: Accept | None = Field(
        None,
        description="reasons for which stop signs of this recording are overruled, by their kind, "
        "beside those of the study",
    )

    @cached_property
    def arm(self) -> ArmSettings:
        """Return the arm as settings, even if the entry has only its name."""
        assert self.robot is not None, "`parse_study` gives each recording its arm"
        return ArmSettings(arm=self.robot) if isinstance(self.robot, str) else self.robot

    def accepted(self) -> dict[str, str]:
        """Return the reasons for which stop signs are overruled, by kind."""
        return self.accept.model_dump(exclude_none=True) if self.accept else {}

    def known_gravity(self) -> Vector3 | None:
        """Return gravity in the base frame [m/s²]; None: as described for the arm."""
        return self.gravity or self.arm.gravity(self.mounting or self.arm.mounting)

    def known_tool(self) -> Tool | None:
        """Return the tool on the flange, None where the study declares none."""
        return self.tool or self.arm.tool

    def known_payload(self) -> Payload | None:
        """Return the declared load on the flange, tool included."""
        tool, load = self.known_tool(), self.declared_load()
        return load.joined(tool.payload() if tool else None) if load else tool and tool.payload()

    def stated_contact_place(self) -> tuple[Vector3, float] | None:
        """Return the place of contacts (3,) [m], frame 6, and their usual distance from it [m].

        None where the study states no place.
        """
        place = self.contact_place
        return None if place is None else (place.position_m, place.within_m)

    def sensor_mounting(self) -> tuple[Vector3 | None, Vector3 | None]:
        """Return position [m] and turn [°] of the force sensor; None: as described for the arm."""
        mounting = getattr(getattr(self, "force_sensor", None), "mounting", None)
        return (mounting.position_m, mounting.rotation_deg) if mounting else (None, None)

    def declared_load(self) -> Payload | None:
        """Return the payload that the study declares in addition to the tool."""
        return self.payload


def _or_simulated(schema: dict[str, Any]) -> None:
    """Change a recording's JSON schema so that it requires either the keys of real files, or
    `simulate`.
    """
    files = [key for key in ("folder", "file") if key in schema["required"]]
    schema["required"] = [key for key in schema["required"] if key not in files]
    schema["oneOf"] = [{"required": files}, {"required": ["simulate"]}]


class Simulable(Files, Part):
    """A recording that the virtual test stand can simulate."""

    model_config = ConfigDict(json_schema_extra=_or_simulated)

    simulate: SimulatedRecording | None = Field(
        None,
        description="simulate the recording on the virtual test stand, in raw/<study>/<name>; "
        "replaces the keys that locate real files",
    )

    def declared_load(self) -> Payload | None:
        """Return the declared payload; without one, the simulated one, unless the files record it
        and the tool is unknown.
        """
        recorded = self.format in layout.FORMATS_WITH_PAYLOAD and not self.known_tool()
        if self.payload or self.simulate is None or recorded:
            return self.payload
        return self.simulate.payload

    def plan(self) -> SimulatedRecording:
        """Return the plan of a simulated recording, with the tool as payload."""
        assert self.simulate is not None, f"{self.name} is not simulated"
        tool, load = self.known_tool(), self.simulate.payload
        if tool is None:
            return self.simulate
        return self.simulate.model_copy(update={"payload": tool.payload().joined(load)})

    def file_names(self) -> list[str]:
        """Return the files in its folder, or, if simulated, those that the test stand writes."""
        if self.simulate is None:
            return super().file_names()
        return layout.file_names(self.format, self.simulate.sensors())


class RecordedEntry(Simulable):
    """A recording in a format of `ur5 record`, which may come from an emulated laboratory.

    A recording of an emulated laboratory has a file with its truth.
    """

    truth: PathText | None = Field(
        None,
        description="path within the recording's folder of the truth about it, which "
        "`ur5 record` leaves with `--emulate`, without its suffixes .parquet and .json",
    )


class ThesisRecording(ThesisFiles, Simulable):
    """A folder `csv_files` with one CSV per channel, as recorded for the thesis."""


class StreamRecording(StreamFiles, RecordedEntry):
    """A capture of the controller's realtime port, with lines received_s,payload_hex."""


class RtdeRecording(RtdeFiles, RecordedEntry):
    """One CSV with RTDE names in its header, as written by ur_rtde and UR's own client."""


class TableRecording(TableFiles, Part):
    """Any delimited table with columns that the study declares."""


class StoredRecording(StoredFiles, Part):
    """Arrays in an HDF5, MAT, NumPy, Parquet or Feather file, a ROS bag, or of your own format."""


class ChannelFilesRecording(ChannelFiles, Part):
    """A text file for each channel: one value a line, or one row of values."""


Recording = Annotated[
    ThesisRecording
    | StreamRecording
    | RtdeRecording
    | TableRecording
    | StoredRecording
    | ChannelFilesRecording,
    Field(discriminator="format"),
]


class Frames(Strict):
    """Repair of the controller's frames: which gaps of the time grid are filled."""

    max_gap_s: float = Field(
        0.1,
        ge=0,
        le=1,
        description="gaps up to this length are interpolated, longer ones split the recording",
    )


class MotionLowpass(Strict):
    """Low-pass filter of the controller's torque and the measured motion.

    It is used to identify the link model.
    """

    order: int = Field(4, ge=1, le=12, description=ORDER_TEXT)
    cutoff_hz: float = Field(10.0, gt=0, lt=1000, description=CUTOFF_TEXT)


class CurrentLowpass(MotionLowpass):
    """Low-pass filter of currents, the motion that explains them, and external torques."""

    cutoff_hz: float = Field(
        2.0, gt=0, lt=1000, description="above this frequency, measured currents are mostly noise"
    )


class AccelerationLowpass(MotionLowpass):
    """Low-pass filter of the end effector's accelerations, by joints and by the IMU."""

    cutoff_hz: float = Field(2.0, gt=0, lt=1000, description=CUTOFF_TEXT)


class PublishedLowpass(Strict):
    """Low-pass filter of the external torque, used in the thesis's estimates of a contact force."""

    order: int = Field(5, ge=1, le=12, description=ORDER_TEXT)
    cutoff_hz: float = Field(
        1.454, gt=0, lt=1000, description="cut-off frequency in the thesis (erratum 4)"
    )


class Lowpass(Strict):
    """Butterworth low-pass filters by filtered signal, without delay.

    `ur5lib.study.given.STEPS` hands motion and currents to most steps that filter with them.
    """

    motion: MotionLowpass = MotionLowpass()
    currents: CurrentLowpass = CurrentLowpass()
    accelerations: AccelerationLowpass = AccelerationLowpass()
    published_forces: PublishedLowpass = PublishedLowpass()

    def cutoffs_hz(self) -> dict[str, float]:
        """Return the cut-off of each filter [Hz], by the filtered signal."""
        return {name: design["cutoff_hz"] for name, design in self.model_dump().items()}


class FrictionSettings(Strict):
    """What is fitted of joint friction, besides Coulomb, viscous and load friction."""

    terms: list[str] | None = Field(
        None,
        description="further terms, as velocity_root, velocity_square, velocity_stribeck or those "
        "of extensions, [] for none; by default those that reduce errors on paths left out",
    )
    prior: bool = Field(
        True, description="whether a UR's friction is expected to be as that of other URs"
    )


class Contact(Strict):
    """What is known in advance about contacts."""

    force_n: float | None = Field(
        None,
        gt=0,
        le=10_000,
        description="force of a typical contact, by default 0.3 of the weight of the rated "
        "payload; the data of each contact override it",
    )


class AlarmSettings(Strict):
    """Settings of the alarms that report a contact."""

    false_per_min: float = Field(
        1.0, ge=0, le=60, description="highest rate allowed on the `fit` recordings"
    )


class TrialPushes(Strict):
    """Trial pushes on contact-free recordings, which show the smallest push that is found."""

    per_arm: int = Field(
        900,
        ge=90,
        le=100_000,
        description="number on an arm's recordings, at least, where they have time for any; of "
        "fewer than 10 of an axis at rest, in slow or in fast motion, no push is stated; of fewer "
        "than 40, its interval contains the push less often than 95 % (60 to 90 %)",
    )
    posture_deg: list[float] | None = Field(
        None,
        description="joints [°] of a posture, beside recorded ones, for which the push at rest is "
        "stated",
    )


class ForceSensorSettings(Strict):
    """Settings of the force sensor with which estimates are compared."""

    bias_window_s: float = Field(
        1.0,
        gt=0,
        le=60,
        description="contact-free start of a run whose mean is removed in the kind “corrected”",
    )


class Singularities(Strict):
    """The limit of poses near a singularity, in which torques do not determine a force."""

    min_singular_value: float = Field(
        0.01, gt=0, le=1, description="smallest singular value of a usable Jacobian"
    )


class Settings(Strict):
    """Settings of the analysis, by concept."""

    frames: Frames = Frames()
    lowpass: Lowpass = Lowpass()
    friction: FrictionSettings = FrictionSettings()
    contact: Contact = Contact()
    alarms: AlarmSettings = AlarmSettings()
    pushes: TrialPushes = TrialPushes()
    sensor: ForceSensorSettings = ForceSensorSettings()
    singularities: Singularities = Singularities()


class Study(Strict):
    """The configuration of one run of `snakemake`; its results are in `results/<study>/`."""

    study: Name
    title: str = Field(description="title of the report")
    robot: NamedArm | None = Field(
        None, description="the arm of all recordings that name none themselves"
    )
    recordings: list[Recording] = Field(min_length=1, description="recordings to analyse")
    reference: Annotated[str, AfterValidator(existing_file)] | None = Field(
        None, description="YAML file with published values and errata to compare the results with"
    )
    compare_with: list[Name] = Field(
        [],
        description="other studies whose results are built: the report shows what differs from "
        "theirs by more than its error, as `ur5 compare` does",
    )
    devices: LabSettings | None = Field(
        None, description="devices that `ur5 record` records; the analysis does not use them"
    )
    accept: Accept | None = Field(
        None,
        description="reasons for which stop signs are overruled in all recordings, by their kind, "
        "as in {order: the drives are numbered from the flange}",
    )
    hosts: dict[str, list[Literal["force_sensor", "imu"]]] = Field(
        {},
        description="computers, under names of your choice, each with the devices whose samples it "
        "timestamps; devices of one host share its clock drift",
    )
    settings: Settings = Field(Settings(), description="settings of the analysis")

    def __repr__(self) -> str:
        """Return name, number of recordings and arms; all settings take some hundred lines."""
        return f"Study({self.study}: {len(self.recordings)} recordings of {', '.join(self.arms())})"

    def arms(self) -> dict[str, ArmSettings]:
        """Return the arms by their names in results, without mountings and tools."""
        arms = [recording.arm for recording in self.recordings]
        return {arm.known_as: arm.itself() for arm in reversed(arms)}  # the first of a name counts

    def devices_of_hosts(self) -> dict[str, list[str]]:
        """Return each host's devices, by their names in results."""
        return {host: [SENSORS[key] for key in keys] for host, keys in self.hosts.items()}


def schema_text() -> str:
    """Return the JSON schema of a study, as committed in workflow/study.schema.json."""
    return json.dumps(Study.model_json_schema(), indent=2) + "\n"


def arms_without_fit(study: Study) -> list[str]:
    """Return the arms without a `fit` recording in motion; their friction is not fitted."""
    recordings = study.recordings
    fitted = {
        recording.arm.known_as
        for recording in recordings
        if recording.role == "fit" and not recording.at_rest
    }
    return sorted({recording.arm.known_as for recording in recordings} - fitted)
