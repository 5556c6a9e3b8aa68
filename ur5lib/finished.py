"""The results of a study that was run: as data frames for a notebook, as records for commands."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache, cached_property
from os.path import isdir, isfile  # unlike pathlib, false for names that are too long
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import pandas as pd

from ur5lib.chain.by_joint import by_joint
from ur5lib.chain.model import Model
from ur5lib.chain.recordings import forces_of, frame_of
from ur5lib.chain.shown import Shown
from ur5lib.chain.steps import Files
from ur5lib.channels import CURRENT, TORQUE
from ur5lib.errors import InputError, briefly, expect_text, unknown
from ur5lib.jobs.unreadable import reason
from ur5lib.records.force_errors import SensorAccount
from ur5lib.records.judgement import Judgement
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.table import Table
from ur5lib.records.units import column_units
from ur5lib.robots.description import Payload, Robot, load_robot
from ur5lib.study.address import results_folder
from ur5lib.study.model import Recording, Settings, Study
from ur5lib.study.reading import read_plain, study_of_results
from ur5lib.tables import intact, read_csv, read_record
from ur5lib.workspace.topics import modules_of_topics

if TYPE_CHECKING:
    import xarray

Record = TypeVar("Record")
FILES_OF_ARM = {  # files of an arm that a model needs
    "described": "described.yaml",
    "arm": "arm.yaml",
    "urdf": "arm.urdf",
    "drifts": "drifts.json",
    "rotors": "rotor_inertia.json",
    "summary": "identification.json",
    "friction": "friction.json",
    "residuals": "residuals.json",
    "threshold": "threshold.json",
}
FILES_OF_FITTED = {  # files of a fitted recording that a model needs
    "signals": "signals.parquet",
    "motion": "motion.parquet",
    "torques": "torques.parquet",
    "currents": "currents.parquet",
    "payload": "payload.json",
}


def load(study: str | Path) -> FinishedStudy:
    """Return the results of a study.

    study: its name, as `mine`, its YAML file, or the folder of its results. Raises InputError where
    there are none.

        >>> ur5lib.load("mine").forces("pushed")["Fmap_Fx"].max()
        1.0
    """
    return FinishedStudy(results_folder(expect_text(study, "study")))


def arm_of(entry: Mapping[str, Any]) -> str:
    """Return the name of the arm of a recording's entry in a built study."""
    robot = entry["robot"]
    return str(robot if isinstance(robot, str) else robot.get("name") or robot["arm"])


def no_verdicts(folder: Path) -> str:
    """Return the sentence of an error: the results are of an earlier version, which wrote no
    verdicts.
    """
    name = folder.name
    return f"{folder} has no verdicts, as results of an earlier version; `ur5 run {name}` again"


class FinishedStudy(Shown):
    """The results in a folder `results/<study>`.

        >>> ur5lib.load("mine").recordings
        ['pushed']

    A frame of a recording has its `time` [s] as index (N,), one column per channel, in SI units. A
    frame and a table have their columns' units in `attrs["units"]`; `N, Nm` is the unit of a column
    with forces and moments; where the unit differs from row to row, the column `unit` or
    `parameter` has it. Methods raise InputError for missing files and unknown names.
    """

    def __init__(self, folder: str | Path) -> None:
        """Take a folder `results/<study>`. Raises InputError where it has no results."""
        self.folder = Path(expect_text(folder, "folder"))
        if not any(isdir(self.folder / part) for part in ("recordings", "tables")):
            raise InputError(
                f"{folder} holds no results of a study; build it by `ur5 run`, and name the folder "
                "results/<study>"
            )

    @property
    def recordings(self) -> list[str]:
        """Return the names of the recordings, without those of postures at rest."""
        return sorted(path.name for path in (self.folder / "recordings").glob("*"))

    @property
    def tables(self) -> list[str]:
        """Return the names of the tables of results."""
        return sorted(path.stem for path in (self.folder / "tables").glob("*.csv"))

    @property
    def verdicts(self) -> pd.DataFrame:
        """Return, for each question (as force, currents) and arm, how good the result is, and why:
        rows of `ur5lib.records.verdicts.Verdict`.

        Of several rows of a question, that of rank 1 decides; `arm` is empty for one on all arms.
        Raises InputError where an earlier version wrote the results, without verdicts.
        """
        return self._judged("verdicts")

    @property
    def uses(self) -> pd.DataFrame:
        """Return what each recording may be used for: recording, purpose, use (yes, no) and reason.

        Raises InputError where an earlier version wrote the results, without verdicts.
        """
        return self._judged("uses")

    def arm(self, robot: str) -> Robot:
        """Return an arm with the link models that were identified."""
        path = self._existing("parameters", robot, "arm.yaml")
        with intact(path):
            return load_robot(path)

    def record(self, kind: type[Record], recording: str, name: str = "") -> Record:
        """Return a file of a recording as a record, e.g. `Motion` of motion.parquet.

        name: of the file without its ending, if it differs from that of the record, e.g. `sensor`
        for `SensorWrenches`.
        """
        stem = name or kind.__name__.lower()
        if issubclass(kind, Table):
            return kind.read(self._existing("recordings", recording, f"{stem}.parquet"))
        return read_record(kind, self._existing("recordings", recording, f"{stem}.json"))

    def table(self, name: str) -> pd.DataFrame:
        """Return a table of results, as in `tables/<name>.csv`: one value a row, SI units.

        E.g. `torque_constants` and `friction` by arm and joint, `force_mae` by recording.
        """
        own = self._known(name, self.tables, "table")
        table = read_csv(self.folder / "tables" / f"{own}.csv")
        table.attrs["units"] = column_units(own, table, self._effort_unit, _units_of_topics())
        return table

    def signals(self, recording: str) -> pd.DataFrame:
        """Return the signals of all devices on the robot's clock, `actual_q_0` ..., in SI units."""
        return self.frame(recording, "signals")

    def motion(self, recording: str) -> pd.DataFrame:
        """Return the smoothed motion: `q_0` ..., `qd_0` ..., `qdd_0` ... [rad, rad/s, rad/s²].

        `_std` in a name marks a standard deviation.
        """
        return self.frame(recording, "motion")

    def torques(self, recording: str) -> pd.DataFrame:
        """Return the torques [Nm] of every link model at the targets, `tau_target_<model>_0` ...,
        and at the measured motion, `tau_measured_<model>_0` ....
        """
        return self.frame(recording, "torques")

    def currents(self, recording: str) -> pd.DataFrame:
        """Return predicted currents and half-widths of their 95 % band, `predicted_current_0` ...,
        `current_band_0` ... [A], for an arm that measures torques `predicted_torque_0` ...,
        `torque_band_0` ... [Nm], and the external torque, `tau_ext_0` ... [Nm].
        """
        return self.frame(recording, "currents")

    def forces(self, recording: str) -> pd.DataFrame:
        """Return the estimated contact wrenches, `Fmap_Fx` ... `Fmap_nz` [N, Nm], and their `_std`.

        The environment on the arm, base axes, at the origin of frame 6. `log_odds_Fmap`: log-odds
        of a contact. Other estimators have columns with their names. NaN where none is stated.
        Where no contact is found (`if_untouched`), the force is within ± `untouched_x` ... if
        nothing has touched since the arm came to rest; a contact of up to `hidden_x` ... could be
        hidden, of up to `hidden_at_all_x` ... since before [N]. `unsmoothed_x` ...: for peaks [N].
        Of a contact in motion, `link` is the likeliest one, `off_flange` the probability that it is
        not the last.
        """
        return forces_of(self._of_recording(recording, "forces"))

    def sensor(self, recording: str) -> pd.DataFrame:
        """Return the force sensor's wrench [N, Nm] as read, less its mean at the start, and less
        bias and tool weight: `printed_Fx` ..., `corrected_Fx` ..., `compensated_Fx` ....
        """
        return self.frame(recording, "sensor")

    def frame(self, recording: str, name: str) -> pd.DataFrame:
        """Return the samples in `recordings/<recording>/<name>.parquet`."""
        return frame_of(self._of_recording(recording, name))

    def to_xarray(self, recording: str, name: str = "signals") -> xarray.Dataset:
        """Return the frame of a recording with a dimension `joint`, from 1 as in tables.

        Raises InputError without xarray, an extra.
        """
        return by_joint(self.frame(recording, name))

    def _of_recording(self, recording: str, name: str) -> Path:
        own = self._known(recording, self.recordings, "recording")
        names = [path.stem for path in (self.folder / "recordings" / own).glob("*.parquet")]
        return self._existing("recordings", own, f"{self._known(name, names, 'file')}.parquet")

    def model(self, robot: str) -> Model:
        """Return the model that was fitted to an arm, the same as `ur5lib.fit` of its recordings.

        Raises InputError where the study has no such arm, or is not built.
        """
        plain = read_plain(self._existing("configuration.yaml"))
        entries = [one for one in plain["recordings"] if arm_of(one) == robot]
        if not entries:
            raise unknown("arm", robot, sorted({arm_of(one) for one in plain["recordings"]}))
        settings = Settings.model_validate(plain["settings"])
        arm = {
            name: self._existing("parameters", robot, file) for name, file in FILES_OF_ARM.items()
        }
        fitted = {one["name"]: self._fitted(one["name"]) for one in entries if one["role"] == "fit"}
        return Model._of(settings, robot, {**arm}, fitted, self.folder)

    def summary(self) -> pd.DataFrame:
        """Return role, length and worst finding of each recording."""
        own = read_plain(self._existing("configuration.yaml"))["recordings"]
        table = pd.DataFrame({"recording": [one["name"] for one in own]})
        table["arm"] = [arm_of(one) for one in own]
        table["role"] = [one["role"] for one in own]
        length = self.table("recordings").set_index("recording")["duration_s"]
        table["duration [s]"] = table["recording"].map(length).round(1)
        found = self.table("quality").groupby("recording")["severity"].agg(set)
        kinds = ("stop", "error", "warning", "note")
        worst = found.map(lambda severities: next(one for one in kinds if one in severities))
        table["worst finding"] = table["recording"].map(worst).fillna("nothing")
        return table

    def _title(self) -> str:
        names = f"{len(self.recordings)} recordings, {len(self.tables)} tables"
        return f"Results of {self.folder}: {names}; `.model(arm)` is what was fitted"

    def _judged(self, name: str) -> pd.DataFrame:
        """Return a table that the step `judge_study` wrote."""
        if name not in self.tables:
            raise InputError(no_verdicts(self.folder))
        return self.table(name)

    @cached_property
    def _effort_unit(self) -> str:
        """Return the unit of torques if all arms of the study measure torques, else that of
        currents.
        """
        arms = (self.folder / "parameters").glob("*/described.yaml")
        units = {load_robot(arm).measured.unit for arm in arms}
        return TORQUE.unit if units == {TORQUE.unit} else CURRENT.unit

    def _fitted(self, recording: str) -> Files:
        """Return the files of a recording of the fit that a model needs, {} if the recording cannot
        be read.
        """
        folder = self.folder / "recordings" / recording
        files = {name: folder / file for name, file in FILES_OF_FITTED.items()}
        return {name: own for name, own in files.items() if isfile(own) and not reason(str(own))}

    def _existing(self, *parts: str) -> Path:
        path = self.folder.joinpath(*(expect_text(part, "result") for part in parts))
        if not isfile(path):
            raise InputError(
                f"{path} does not exist; check the folder and the names, or `ur5 run` the study"
            )
        if why := reason(str(path)):
            raise InputError(f"the recording of {path} cannot be read: {why}")
        return path

    def _known(self, name: str, names: list[str], kind: str) -> str:
        """Return `name` unchanged. Raises InputError with the closest of `names` if it is not among
        them; kind: of the named thing.
        """
        if isinstance(name, str) and name in names:
            return name
        near = get_close_matches(str(name), names, n=1) or sorted(names) or ["none"]
        raise InputError(
            f"{self.folder} has no {kind} {briefly(name)}, but {', '.join(near)}; correct the "
            "name, or `ur5 run` the study again"
        )


@cache
def _units_of_topics() -> dict[str, dict[str, str]]:
    """Return the units of the topics' tables, by a pattern of the columns' names."""
    return {k: v for topic in modules_of_topics("units").values() for k, v in topic.UNITS.items()}


class StudyFiles(FinishedStudy):
    """A finished study with its files as records, which commands read."""

    def configuration(self) -> Study:
        """Return the study with every default filled in."""
        path = self._existing("configuration.yaml")
        with intact(path):
            plain = read_plain(path)
        return study_of_results(plain, str(path))

    def recording(self, name: str) -> Recording:
        """Return the entry of a recording in the study."""
        entries = {entry.name: entry for entry in self.configuration().recordings}
        return entries[self._known(name, [*entries], "recording")]

    def parameters(self, kind: type[Record], robot: str, name: str) -> Record:
        """Return what was fitted to an arm, e.g. `Friction` of `parameters/<arm>/friction.json`."""
        return read_record(kind, self._existing("parameters", robot, f"{name}.json"))

    def quality(self, recording: str) -> Quality:
        """Return the files and the timing of a recording."""
        return self.record(Quality, recording)

    def judgement(self, recording: str) -> Judgement:
        """Return the findings on one recording and its rows of the result tables
        (`judgement.json`).
        """
        return self.record(Judgement, recording)

    def beside_sensor(self, recording: str) -> SensorAccount:
        """Return the bias and the tool that were subtracted from the reading of a recording's force
        sensor.
        """
        return self.record(SensorAccount, recording, "beside_sensor")

    def payload(self, recording: str) -> Payload | None:
        """Return the payload on the flange during a recording, None without one."""
        return self.record(Premises, recording).load.payload

    def start(self, recording: str) -> float | None:
        """Return time zero of a recording in seconds since 1970; None where unknown."""
        name = self._known(recording, self.recordings, "recording")
        path = self.folder / "recordings" / name / "quality.json"
        return self.quality(name).start_epoch_s if path.is_file() else None
