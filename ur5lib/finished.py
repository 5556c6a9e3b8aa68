"""The results of a study that was run, as data frames for a notebook."""

from difflib import get_close_matches
from pathlib import Path

import pandas as pd

from ur5lib.errors import InputError
from ur5lib.tables import read_csv, read_json, read_table, read_units


class FinishedStudy:
    """The results in a folder `results/<study>`.

    A frame of a recording has its `time` [s] as index, one column per channel, and the columns'
    units in `frame.attrs["units"]`. Its methods raise InputError for what is not there.
    """

    def __init__(self, folder: str | Path) -> None:
        """folder: results/<study>. Raises InputError where it holds no results."""
        self.folder = Path(folder)
        if not (self.folder / "recordings").is_dir():
            raise InputError(
                f"{folder} holds no results of a study; run snakemake first, and name the folder "
                "results/<study>"
            )

    @property
    def recordings(self) -> list[str]:
        """Return the names of the recordings."""
        return sorted(path.name for path in (self.folder / "recordings").iterdir())

    @property
    def tables(self) -> list[str]:
        """Return the names of the tables of results."""
        return sorted(path.stem for path in (self.folder / "tables").glob("*.csv"))

    def table(self, name: str) -> pd.DataFrame:
        """Return a table of results, as in tables/<name>.csv: one value a row, SI units."""
        return read_csv(self.folder / "tables" / f"{_known(name, self.tables, 'table')}.csv")

    def signals(self, recording: str) -> pd.DataFrame:
        """Return what the devices recorded, on the robot's clock, under RTDE's names."""
        return self.frame(recording, "signals")

    def motion(self, recording: str) -> pd.DataFrame:
        """Return smoothed joint positions, velocities, accelerations, and their `_std`."""
        return self.frame(recording, "motion")

    def torques(self, recording: str) -> pd.DataFrame:
        """Return the torques of every link model, at the targets and at the measured motion."""
        return self.frame(recording, "torques")

    def currents(self, recording: str) -> pd.DataFrame:
        """Return predicted currents with their 95 % band, and the external torque."""
        return self.frame(recording, "currents")

    def forces(self, recording: str) -> pd.DataFrame:
        """Return the estimated contact wrenches and their `_std`.

        The environment on the arm, base axes, at the origin of frame 6.
        """
        return self.frame(recording, "forces")

    def sensor(self, recording: str) -> pd.DataFrame:
        """Return the force sensor's wrench: as printed, corrected and compensated."""
        return self.frame(recording, "sensor")

    def frame(self, recording: str, name: str) -> pd.DataFrame:
        """Return recordings/<recording>/<name>.parquet."""
        folder = self.folder / "recordings" / _known(recording, self.recordings, "recording")
        names = [path.stem for path in folder.glob("*.parquet")]
        path = folder / f"{_known(name, names, 'file')}.parquet"
        frame = read_table(path).set_index("time")
        frame.attrs["units"] = read_units(path)
        return frame

    def start(self, recording: str) -> float | None:
        """Return when a recording's `time` was zero, in seconds since 1970; None where unknown."""
        name = _known(recording, self.recordings, "recording")
        quality = self.folder / "recordings" / name / "quality.json"
        return read_json(quality).get("start_epoch_s") if quality.is_file() else None


def _known(name: str, names: list[str], kind: str) -> str:
    """Return a name that is among those there are. Raises InputError with the closest one."""
    if name in names:
        return name
    near = get_close_matches(name, names, n=1)
    hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(sorted(names)) or 'none'}"
    raise InputError(f"no {kind} {name!r} in the results; {hint}")
