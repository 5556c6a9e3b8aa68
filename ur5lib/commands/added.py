"""What `ur5 convert --into` adds to each row of a recording's file: estimates and their quality."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.chain.recordings import forces_of, frame_of
from ur5lib.chain.steps import Files
from ur5lib.force.estimators import LEADING, STATIC
from ur5lib.force.thresholds import alarms
from ur5lib.records.table import WRENCH
from ur5lib.tables import column_unit
from ur5lib.timeseries.arrays import Array, Labels, Mask

CLEAR = 3.0  # standard deviations, from which on an estimate without odds is a contact
ESTIMATED, FILLED, UNKNOWN = range(3)
QUALITY_OF = "quality_"  # begins the name of an estimate's quality
QUALITY = f"{ESTIMATED} estimated, {FILLED} from interpolated readings, {UNKNOWN} nothing is known"
FRAME = "the environment acting on the arm, axes of the base, moments about the last frame's origin"
HOW = {LEADING: "by all samples of the recording", STATIC: "without any fit, of a resting arm"}


@dataclass(frozen=True)
class Added:
    """Values that are added: (N,), or (N, 6) of a wrench [F, n], NaN where nothing is known.

    name: as in forces.parquet, without axes; unit: of all columns, or `N, Nm`.
    """

    name: str
    values: np.ndarray
    unit: str
    meaning: str

    @property
    def parts(self) -> Sequence[str]:
        """Return the ends of the columns' names: those of a wrench, or one empty name."""
        return [f"_{part}" for part in WRENCH] if self.values.ndim == 2 else [""]

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns (N,) by their names in tables."""
        wide = self.values[:, None] if self.values.ndim == 1 else self.values
        return {self.name + part: wide[:, k] for k, part in enumerate(self.parts)}

    def units(self) -> dict[str, str]:
        """Return the unit of each column."""
        return {name: column_unit(name, self.unit) for name in self.columns()}

    def on(self, samples: Labels) -> "Added":
        """Return the values of rows; samples: the sample (M,) of each row, -1 where it has none."""
        unknown = UNKNOWN if self.name.startswith(QUALITY_OF) else 0
        nothing = np.nan if self.values.dtype.kind == "f" else unknown
        known = (samples >= 0).reshape(-1, *[1] * (self.values.ndim - 1))
        values = np.where(known, self.values[samples], nothing).astype(self.values.dtype)
        return replace(self, values=values)


def offline(files: Files, thresholds: Mapping[str, float]) -> Iterator[Added]:
    """Yield what the estimate by all samples states of a recording, nothing where no force is
    stated.

    files: of the recording after `estimate_forces`; thresholds: of log-odds, by estimate.
    """
    forces = forces_of(files["forces"])
    name = next((one for one in (LEADING, STATIC) if f"{one}_Fx" in forces), None)
    if name is None:
        return
    wrench, std = wrench_of(forces, name), wrench_of(forces, f"{name}_std")
    odds = forces[f"log_odds_{name}"].to_numpy() if f"log_odds_{name}" in forces else None
    touched: Mask = np.zeros(len(forces), bool)
    if odds is None:  # nobody counts how often this one is wrong
        touched = np.asarray((np.abs(wrench) > CLEAR * std).any(axis=1))
    else:
        for start, end in alarms(odds, thresholds.get(name, 0.0)):
            touched[start:end] = True
    yield from estimate(name, HOW[name], wrench, std, touched, odds)
    if "link" in forces:
        link = forces["link"].to_numpy()
        yield Added(f"link_{name}", link, "1", "likeliest touched link, from 1, of contacts moving")
    yield quality(name, files, np.asarray(np.isfinite(std).all(axis=1)))


def estimate(
    name: str, how: str, wrench: Array, std: Array, touched: Mask, odds: Array | None
) -> Iterator[Added]:
    """Yield a contact wrench (N, 6), its standard deviation, whether there is a contact (N,), and
    its log-odds (N,), if known.

    how: the estimate is made.
    """
    yield Added(name, wrench, "N, Nm", f"contact wrench {how}: {FRAME}")
    yield Added(f"{name}_std", std, "N, Nm", f"standard deviation of {name}")
    yield Added(f"contact_{name}", touched.astype(np.uint8), "1", f"1 in a contact, by {name}")
    if odds is not None:
        yield Added(f"log_odds_{name}", odds, "1", f"log-odds of a contact, by {name}")


def quality(name: str, files: Files, known: Mask) -> Added:
    """Return the quality (N,) of each sample of an estimate; known: (N,), where it states one."""
    filled = frame_of(files["robot"], ["interpolated"])["interpolated"].to_numpy(bool)
    values = np.where(known, np.where(filled, FILLED, ESTIMATED), UNKNOWN).astype(np.uint8)
    return Added(QUALITY_OF + name, values, "1", QUALITY)


def wrench_of(frame: pd.DataFrame, name: str) -> Array:
    """Return the columns (N, 6) of a wrench."""
    return np.asarray(frame[[f"{name}_{part}" for part in WRENCH]].to_numpy(float))


def described(added: Sequence[Added]) -> dict[str, Any]:
    """Return unit and meaning of each column."""
    return {
        column: {"unit": unit, "meaning": one.meaning}
        for one in added
        for column, unit in one.units().items()
    }
