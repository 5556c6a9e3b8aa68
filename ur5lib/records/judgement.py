"""The judgement of a recording without a sensor and its contacts."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ur5lib.records.account import AccountRow
from ur5lib.records.codes import Found
from ur5lib.records.prediction import Prediction
from ur5lib.records.quality import Finding
from ur5lib.timeseries.arrays import Array

PATH_TIMES = 32  # of a recording, to draw its path


@dataclass(frozen=True, kw_only=True)
class QualityRow:
    """A row of quality.csv: a finding, its code, and its whole sentence as `detail`."""

    device: str
    finding: str
    severity: str
    count: int
    detail: str
    place: str = ""
    code: Found


@dataclass(frozen=True, kw_only=True)
class RecordingSummary:
    """A row of recordings.csv: rows that were read, frames after the repair, times [s]; jitter_s:
    99 % of the deviations of time stamps; devices, moving_joints (from 1): between spaces.
    """

    duration_s: float
    rows_read: int
    frames: int
    longest_step_s: float
    jitter_s: float
    devices: str
    moving_joints: str


@dataclass(frozen=True, kw_only=True)
class JointPath:
    """A row of paths.csv: the angles of a joint [rad] at 32 evenly spaced frames, by spaces."""

    joint: int
    angles: str


@dataclass(frozen=True, kw_only=True)
class FileRead:
    """A row of files.csv: a file that a recording was read from, and its SHA-256."""

    file: str
    sha256: str


@dataclass(frozen=True, kw_only=True)
class ClockRow:
    """A row of clocks.csv: the clock of a device, as `SettledClock`; drift in ppm."""

    device: str
    offset_s: float
    offset_std_s: float
    drift_ppm: float | None
    drift_std_ppm: float | None
    method: str
    end_std_s: float


@dataclass(frozen=True, kw_only=True)
class TorqueError:
    """A row of torque_mae.csv: MAE of a joint's torque [Nm] by a link model against
    `target_moment`, all of it and below 2 Hz, and that of zero torque.

    motion: target or measured.
    """

    motion: str
    model: str
    joint: int
    mae: float
    mae_2hz: float
    zero_mae: float
    zero_mae_2hz: float


@dataclass(frozen=True, kw_only=True)
class CurrentError:
    """A row of current_rmse.csv: the errors of a model's prediction at a joint, as `Scores`;
    fitted: whether it is a recording of the fit; rmse_lowpassed: of currents below
    `lowpass.currents.cutoff_hz`; zero_rmse_lowpassed: of their mean; rmse_before_motion: until the
    joint first moves, empty where the recording before says to which side friction keeps it.
    """

    model: str
    fitted: bool
    joint: int
    rmse: float
    rmse_lowpassed: float
    mae: float
    r2: float
    coverage95: float
    band_factor95: float
    rmse_before_motion: float
    coverage95_before_motion: float
    zero_rmse_lowpassed: float


def current_errors(prediction: Prediction) -> Iterator[CurrentError]:
    """Yield the errors of each model's prediction of the currents."""
    for model, scores in prediction.scores.items():
        errors = vars(scores) | {"zero_rmse_lowpassed": scores.zero_rmse_lowpassed}
        for name in ("coverage", "coverage_before_motion"):
            errors[name.replace("coverage", "coverage95")] = errors.pop(name)
        for joint, values in by_joint(errors):
            yield CurrentError(model=model, fitted=prediction.fitted, joint=joint, **values)


def by_joint(columns: Mapping[str, Array]) -> Iterator[tuple[int, dict[str, float]]]:
    """Yield each joint, from 1, with its values of columns (n,)."""
    names = [*columns]
    for joint, values in enumerate(zip(*columns.values(), strict=True), start=1):
        yield joint, dict(zip(names, map(float, values), strict=True))


@dataclass(frozen=True, kw_only=True)
class LoadRow:
    """A row of payload.csv: an undeclared load on the flange, as `JudgedLoad` [kg, m]."""

    mass: float
    std_error: float
    low: float
    high: float
    center_of_mass_x: float
    center_of_mass_y: float
    center_of_mass_z: float
    configured: float
    taken: bool
    center_of_mass_std_x: float
    center_of_mass_std_y: float
    center_of_mass_std_z: float


@dataclass(frozen=True, kw_only=True)
class Judgement:
    """judgement.json: findings about a recording, for the table `quality`, and its rows for the
    tables with the names of the other fields.
    """

    findings: list[Finding] = field(default_factory=list)
    recordings: list[RecordingSummary] = field(default_factory=list)
    paths: list[JointPath] = field(default_factory=list)
    files: list[FileRead] = field(default_factory=list)
    account: list[AccountRow] = field(default_factory=list)
    clocks: list[ClockRow] = field(default_factory=list)
    torque_mae: list[TorqueError] = field(default_factory=list)
    current_rmse: list[CurrentError] = field(default_factory=list)
    payload: list[LoadRow] = field(default_factory=list)
