"""Numbers of the figures of friction, thinned for the page: by velocity, and by position."""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.tables import read_csv
from ur5lib.timeseries.arrays import Array

POINTS = 30  # of friction in one direction of motion
PARTS = 24  # of a joint's range of positions
LEAST = 5  # samples of a part
QUARTILES = {"low": 0.25, "median": 0.5, "high": 0.75}


def by_velocity(numbers: Path) -> pd.DataFrame:
    """Return some samples of `friction_figure` of each joint and direction, evenly over velocity:
    velocity [rad/s]; measured, fitted, half-width of the 95 % band, and the same at rest, [Nm].
    """
    return _joined(_some(own.sort_values("velocity")) for own in _directions(_read(numbers)))


def by_position(numbers: Path) -> pd.DataFrame:
    """Return the residuals of `current_figures` by joint and part of its range of positions: start
    and end of the part [rad], and the residuals' quartiles `low`, `median`, `high`.
    """
    names = ["residual", "position"]
    return _joined(_quartiles(own) for own in _joints(_read(numbers), names) if len(own))


def _joined(parts: Iterable[pd.DataFrame]) -> pd.DataFrame:
    known = [part for part in parts if len(part)]
    return pd.concat(known, ignore_index=True) if known else pd.DataFrame()


def _read(numbers: Path) -> pd.DataFrame:
    """Return the numbers of a figure, empty if nothing was drawn."""
    drawn = numbers.is_file() and numbers.read_bytes()[:2].strip()
    return read_csv(numbers) if drawn else pd.DataFrame()


def _joints(every: pd.DataFrame, names: list[str]) -> Iterator[pd.DataFrame]:
    """Yield a table of samples for each joint; names: the words in the names of a figure's columns
    that become the names of the table's columns.
    """
    joint = 1
    while of_joint := [own for own in every if re.search(rf"joint {joint}\b", own)]:
        columns = {name: column for name in names for column in of_joint if name in column}
        own = pd.DataFrame({name: every[column] for name, column in columns.items()})
        yield own.dropna().assign(joint=joint)
        joint += 1


def _directions(every: pd.DataFrame) -> Iterator[pd.DataFrame]:
    """Yield the samples of each joint in each direction of motion."""
    names = {"velocity": "velocity", "measured": "measured", "fitted": "fitted", "95 %": "half"}
    for own in _joints(every, [*names]):
        rest = every.get(f"half of the band at rest, joint {own['joint'].min()} [Nm]")
        resting = np.nan if rest is None else rest.max()
        for direction in (-1, 1):
            moving = own[direction * own["velocity"] > 0] if len(own) else own
            if len(moving):
                yield moving.rename(columns=names).assign(resting=resting)


def _some(samples: pd.DataFrame) -> pd.DataFrame:
    """Return a few samples, evenly spaced in velocity; samples: sorted by velocity."""
    velocity = samples["velocity"].to_numpy(float)
    wanted = np.linspace(velocity[0], velocity[-1], POINTS)
    return samples.iloc[np.unique(np.searchsorted(velocity, wanted))]


def _quartiles(samples: pd.DataFrame) -> pd.DataFrame:
    """Return the quartiles of a joint's residuals over parts of its range."""
    position: Array = samples["position"].to_numpy(float)
    edges = np.linspace(position.min(), position.max(), PARTS + 1)
    part = np.clip(np.searchsorted(edges, position, side="right") - 1, 0, PARTS - 1)
    groups = samples.groupby(part)["residual"]
    found = pd.DataFrame({name: groups.quantile(share) for name, share in QUARTILES.items()})
    found = found.assign(start=edges[found.index], end=edges[found.index + 1])
    return found[groups.count() >= LEAST].assign(joint=samples["joint"].iloc[0])
