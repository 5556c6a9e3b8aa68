"""A force sensor's file and the robot's: their clocks are matched by efforts and forces.

Efforts without gravity, friction and inertia follow the joint torque of the force. The delay at
which they follow it best, in parts of the recording, gives offset and drift of the sensor's clock.
"""

from os.path import relpath
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from ur5lib.checks.block_means import FULL_FRICTION_SPEED
from ur5lib.errors import InputError
from ur5lib.importing.clocks import ROW_CLOCK
from ur5lib.importing.contents import TABLE_FORMAT, FileContents, UserStatement, contents
from ur5lib.importing.entry import StudyEntry
from ur5lib.importing.wrenches import CONTACT_FORCE, change, with_parted_wrench, wrench_blocks
from ur5lib.recordings.entries import OPPOSITE_SIGN, SKIPPED_COLUMN
from ur5lib.recordings.intake import read_and_repair
from ur5lib.records.account import AccountRow
from ur5lib.records.phrases import number
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, gravity_torque, link_frames
from ur5lib.study.reading import parse_study
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.metrics import NORMAL95

STEP = 0.02  # s, of the grid on which efforts and forces are compared
MAX_DELAY = 5.0  # s beyond what stamps say, or without these
PARTS = 4  # of the recording, whose delays give the drift
MIN_EXPLAINED = 0.2  # share of what is left of the efforts that forces explain
MIN_LEAD, APART = 1.5, 0.5  # times as much as at delays so many seconds away
NEAR = 0.2  # s, within which parts of the recording are delayed
ALL = slice(None)
MAX_GAP = 0.1  # s


class Match(NamedTuple):
    """How a sensor's clock and axes fit the robot's. offset: from the robot's first frame to the
    sensor's first sample [s], with its error; drift: share by which the robot's clock is faster;
    explained: share of the efforts; axes: of the wrench.
    """

    offset: float
    offset_std: float
    drift: float
    drift_std: float
    explained: float
    axes: str
    opposite: bool

    def in_words(self, name: str) -> str:
        """Return the match with the file of a sensor in words."""
        return (
            f"{name}: its first sample is {number(self.offset, '.3f')} ± "
            f"{number(self.offset_std, '.3f')} s after the robot's first frame, and its clock "
            f"drifts by {number(1e6 * self.drift, '.0f')} ± "
            f"{number(1e6 * self.drift_std, '.0f')} ppm: so the force explains "
            f"{number(self.explained, '.0%')} of what gravity and friction leave of the efforts; "
            "--with names another file"
        )


def sensor_in(path: Path, stated: UserStatement) -> FileContents | None:
    """Return the contents of a table with a force and a clock, but no positions; None for
    others.
    """
    try:
        file = with_parted_wrench(contents(path, stated))
    except InputError:
        return None
    clock = next(iter(file.clocks.stamps), ROW_CLOCK)
    is_table = file.format == TABLE_FORMAT and clock != ROW_CLOCK
    has_positions = any(block.meaning() == "actual_q" for block in file.blocks)
    return file if is_table and not has_positions and wrench_blocks(file, clock) else None


def joined(entry: StudyEntry, sensor: FileContents) -> tuple[float, StudyEntry, AccountRow] | None:
    """Return the share of the efforts that a sensor's force explains, the keys that its file adds
    to a robot's entry, and the row that says how their clocks were matched; None where no delay
    makes the efforts follow the force.
    """
    plain = {"study": "import", "title": "Import", "recordings": [entry]}
    recording = parse_study(plain, "the entry").recordings[0]
    arm = recording.arm.description().mounted(recording.known_gravity())
    robot = read_and_repair(recording, arm, MAX_GAP).robot
    if f"{arm.measured.channel}_0" not in robot or not arm.tells_gravity():
        return None
    clock = next(iter(sensor.clocks.stamps))
    stamps, wrench = sensor.clocks.stamps[clock], wrench_blocks(sensor, clock)
    rows = np.hstack([block.rows for block in wrench])
    force = np.pad(rows - np.median(rows, axis=0), ((0, 0), (0, 6 - rows.shape[1])))
    match = Matching(robot, arm).match(stamps - stamps[0], force)
    if match is None or match.axes != "flange":
        return None
    row = AccountRow("force sensor", "ft", "numbers", "assumed", match.in_words(sensor.path.name))
    pushed = {"role": "contact"} if change(wrench) > CONTACT_FORCE else {}
    return match.explained, {"force_sensor": _part(entry, sensor, match)} | pushed, row


def _part(entry: StudyEntry, sensor: FileContents, match: Match) -> StudyEntry:
    """Return the key `force_sensor` of an entry."""
    clock = next(iter(sensor.clocks.stamps))
    wrench, unit = wrench_blocks(sensor, clock), sensor.clocks.units.get(clock)
    named = {clock: "time"}
    for channel_name, block in zip(("ft_f", "ft_t"), wrench, strict=False):
        named |= {name: channel_name + axis for name, axis in zip(block.names, "xyz", strict=True)}
    sign = {name: OPPOSITE_SIGN for name in ("ft_f", "ft_t")[: len(wrench)] if match.opposite}
    units = ({"time": unit} if unit else {}) | sign
    columns = [named.get(name, SKIPPED_COLUMN) for name in sensor.header.columns]
    return {
        "file": relpath(sensor.path, entry["folder"]),
        "columns": columns,
        **({"units": units} if units else {}),
        "offset_s": round(match.offset, 4),
        "drift_ppm": round(1e6 * match.drift),
    }


class Matching:
    """A robot's efforts on an even grid of time, without gravity, friction and inertia."""

    def __init__(self, robot: pd.DataFrame, arm: Robot) -> None:
        """Take a repaired table of positions and efforts."""
        time = robot["time"].to_numpy(float)
        self.grid = np.arange(time[0], time[-1], STEP)
        q, effort = (
            np.stack([np.interp(self.grid, time, own) for own in channel(robot, name).T], axis=1)
            for name in ("actual_q", arm.measured.channel)
        )
        rate = np.gradient(q, STEP, axis=0)
        faster, gravity = np.gradient(rate, STEP, axis=0), gravity_torque(arm, arm.chosen_model, q)
        self.bases = [
            np.linalg.qr(
                np.column_stack(
                    [gravity[:, k], np.tanh(rate[:, k] / FULL_FRICTION_SPEED), rate[:, k], faster]
                )
            )[0]
            for k in range(q.shape[1])
        ]
        self.jacobian, self.rotation = geometric_jacobian(arm, q), link_frames(arm, q)[0][:, -1]
        self.left = self._beside(effort * arm.maker_torque_constants())

    def match(self, own_time: Array, wrench: Array) -> Match | None:
        """Return how a wrench (K, 6), less its median, at times (K,) [s] from its first sample fits
        the efforts; None where no delay is clear.
        """
        coarse = np.arange(-MAX_DELAY, MAX_DELAY, STEP)
        found = {
            axes: np.array([self._explained(d, own_time, wrench, axes) for d in coarse])
            for axes in ("flange", "base")
        }
        axes = max(found, key=lambda one: found[one][:, 0].max())
        shares, slopes = found[axes].T
        best = int(np.argmax(shares))
        elsewhere = shares[np.abs(coarse - coarse[best]) > APART].max(initial=0.0)
        if shares[best] < MIN_EXPLAINED or shares[best] < MIN_LEAD * elsewhere:
            return None
        near = coarse[best] + np.arange(-NEAR, NEAR, STEP / 4)
        parts = np.array_split(np.arange(len(self.grid)), PARTS)
        by_part = [
            [self._explained(d, own_time, wrench, axes, rows)[0] for d in near] for rows in parts
        ]
        weights = np.array([max(own) for own in by_part])
        delays = near[[int(np.argmax(own)) for own in by_part]]
        middles = np.array([self.grid[rows].mean() for rows in parts])
        line = _line(middles - self.grid[0], delays, weights)
        return Match(*line, float(shares[best]), axes, bool(slopes[best] > 0))

    def _explained(
        self, delay: float, own_time: Array, wrench: Array, axes: str, rows: Labels | slice = ALL
    ) -> tuple[float, float]:
        """Return the share of what is left of the efforts that a wrench, later by `delay`, explains
        by one factor, and that factor.
        """
        at = self.grid - self.grid[0] - delay
        values = np.stack([np.interp(at, own_time, column) for column in wrench.T], axis=1)
        if axes == "flange":
            halves = values.reshape(-1, 2, 3)
            values = np.einsum("nij,nkj->nki", self.rotation, halves).reshape(-1, 6)
        torque = self._beside(np.einsum("nij,ni->nj", self.jacobian, values))
        scale = self.left.std(axis=0) + 1e-9
        one, other = (self.left / scale)[rows].ravel(), (torque / scale)[rows].ravel()
        slope = float(one @ other / (other @ other + 1e-9))
        return float(slope * (one @ other) / (one @ one + 1e-9)), slope

    def _beside(self, torque: Array) -> Array:
        """Return what gravity, friction and inertia leave of a torque (N, n), joint by joint."""
        pairs = zip(torque.T, self.bases, strict=True)
        return np.stack([own - basis @ (basis.T @ own) for own, basis in pairs], axis=1)


def _line(middles: Array, delays: Array, weights: Array) -> tuple[float, float, float, float]:
    """Return offset and drift with their errors, by the delays (k,) of parts of the recording."""
    columns = np.column_stack([np.ones(len(middles)), middles])
    root = np.sqrt(weights)[:, None]
    (offset, drift), *_ = np.linalg.lstsq(root * columns, root[:, 0] * delays, rcond=None)
    spread = max(float(np.std(delays - columns @ [offset, drift])), STEP / 4)
    errors = spread * np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    if abs(drift) < NORMAL95 * errors[1]:  # not shown by so short a recording
        return float(np.average(delays, weights=weights)), spread, 0.0, float(errors[1])
    return float(offset), float(errors[0]), float(drift), float(errors[1])
