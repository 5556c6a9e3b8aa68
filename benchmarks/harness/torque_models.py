"""Models of torque from motion, fitted to some runs of an arm to predict the torques of others.

Ours is the model of a study's steps. The others take velocities and accelerations from a spline
through the positions.
"""

from collections.abc import Callable, Sequence
from copy import copy
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
import yaml
from scipy.interpolate import make_interp_spline

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.current_samples import ZeroPhaseLowpass, current_record, prior_of
from ur5lib.identification.currents import band, predict
from ur5lib.identification.samples import CurrentSamples, tracks
from ur5lib.recordings.entries import ENTRY
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.carried import carried
from ur5lib.records.friction import CurrentFit
from ur5lib.records.motion import Motion, posture_change
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, robot_of
from ur5lib.robots.friction import Track, direction_over_distances
from ur5lib.steps.align_recording import align_recording
from ur5lib.steps.compute_torques import joint_torques
from ur5lib.steps.fit_friction import fitted_friction
from ur5lib.steps.identify_model import identify_model
from ur5lib.steps.read_recording import read_recording
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth

MAX_GAP = 0.1  # s, as in studies
MOTION, CURRENTS = Butterworth(4, 10.0), Butterworth(4, 2.0)
SMOOTH = ZeroPhaseLowpass(*CURRENTS)
MEMORIES = (1e-5, 1e-4, 1e-3, 1e-2)  # rad; parts of dry friction reverse over these distances
# Ten times SAME_POSTURE of a study, since all files are of one session.
SESSION_POSTURE = 1e-3  # rad
RIDGE = 1e-8  # of the columns' mean squares, since the columns are linearly dependent


class Run:
    """A recording of an arm: as a study's steps read and smooth it, and by a spline."""

    def __init__(self, arm: Robot, file: Path) -> None:
        """Read a table of time, positions and motor torques."""
        self.name, self.arm = file.stem, arm
        keys = {"format": "table-csv", "folder": str(file.parent), "file": file.name}
        columns = {"columns": ["time", "actual_q", "actual_torque"]}
        read = read_recording(ENTRY.validate_python(keys | columns), [file], arm, MAX_GAP)
        aligned = align_recording(read.robot, read.force, read.imu, read.clocks)
        self.signals, self.motion = Signals.from_table(aligned.signals), aligned.motion
        self.before: Sequence[Motion] = ()  # motions of the earlier runs, see `chained`

    @cached_property
    def torque(self) -> Array:
        """The measured torque (N, n) [Nm] of the joints."""
        assert self.signals.effort is not None
        return self.signals.effort

    @cached_property
    def by_spline(self) -> tuple[Array, Array, Array]:
        """Return q, q̇ and q̈ (N, n) of a quintic spline through the positions."""
        spline = make_interp_spline(self.signals.time, self.signals.actual_q, k=5)
        q, qd, qdd = (spline(self.signals.time, order) for order in range(3))
        return q, qd, qdd

    @cached_property
    def rigid(self) -> Array:
        """Return the regressor (N, n, P) of links and rotors on the spline `by_spline`."""
        return LinkModel(self.arm, self.arm.chosen_model).regressor(*self.by_spline)


def chained(runs: Sequence[Run]) -> list[Run]:
    """Return runs with their earlier motions, as far back as each begins where the last ended."""
    following = [*map(copy, runs)]
    for earlier, run in pairwise(following):
        moved = np.abs(posture_change(earlier.motion, run.motion)).max()
        run.before = [*earlier.before, earlier.motion] if moved < SESSION_POSTURE else []
    return following


Columns = Callable[[Run], Array]  # regressors (N, n, P) of a run


def linear_map(run: Run) -> Array:
    """Return columns of q, q̇, q̈ and a constant, separate for each joint."""
    inputs = np.column_stack([*run.by_spline, np.ones(len(run.torque))])
    return in_rows([inputs] * run.torque.shape[1])


def rigid_links(run: Run) -> Array:
    """Return columns of links and rotors, and of each joint's sign(q̇), q̇ and a constant."""
    _, qd, _ = run.by_spline
    columns = np.stack([np.sign(qd), qd, np.ones_like(qd)], axis=2)
    return np.concatenate([run.rigid, in_rows(columns.swapaxes(0, 1))], axis=2)


def with_gears(run: Run) -> Array:
    """Return `rigid_links` with root and square of the velocity, and a counterbalance on each
    joint.
    """
    q, qd, _ = run.by_spline
    gears = [np.sign(qd) * np.sqrt(np.abs(qd)), qd * np.abs(qd), np.sin(q), np.cos(q)]
    further = np.stack(gears, axis=2).swapaxes(0, 1)
    return np.concatenate([rigid_links(run), in_rows(further)], axis=2)


def with_memory(run: Run) -> Array:
    """Return `with_gears` with dry friction of parallel Dahl elements (MEMORIES)."""
    q, qd, _ = run.by_spline
    known = run.signals.segment, run.signals.period
    states = []
    for joint, own in enumerate(zip(q.T, qd.T, strict=True)):
        over = direction_over_distances(Track(*own, *known), tracks(run.before, joint))
        states.append(np.stack([*map(over, MEMORIES)], axis=1))
    return np.concatenate([with_gears(run), in_rows(states)], axis=2)


def in_rows(columns: Sequence[Array] | Array) -> Array:
    """Return (N, n, n C) of the joints' columns (N, C), each in its own row."""
    count, width = columns[0].shape
    rows = np.zeros((count, len(columns), len(columns) * width))
    for joint, own in enumerate(columns):
        rows[:, joint, joint * width : (joint + 1) * width] = own
    return rows


def least_squares(of: Columns, fitted: Sequence[Run], judged: Sequence[Run]) -> list[Array]:
    """Return the torques of judged runs by least squares on fitted runs, weighted by joint."""
    size = np.concatenate([run.torque for run in fitted]).std(axis=0)
    rows = np.concatenate([of(run) / size[:, None] for run in fitted])
    rows = rows.reshape(-1, rows.shape[-1])
    target = np.concatenate([run.torque / size for run in fitted]).ravel()
    scale = np.sqrt((rows**2).mean(axis=0)) + 1e-12
    scaled = rows / scale
    normal = scaled.T @ scaled + RIDGE * len(rows) * np.eye(rows.shape[1])
    coefficients = np.linalg.solve(normal, scaled.T @ target) / scale
    return [of(run) @ coefficients for run in judged]


class Ours:
    """The arm and its friction, as a study's steps identify them on some runs."""

    def __init__(self, arm: Robot, fitted: Sequence[Run]) -> None:
        """Identify links, gears and counterbalances, then friction."""
        signals = {run.name: run.signals for run in fitted}
        motion = {run.name: run.motion for run in fitted}
        found = identify_model(arm, signals, motion, dict.fromkeys(signals), MOTION, CURRENTS)
        self.arm = robot_of(yaml.safe_load(found.arm))
        records = [*map(self.record, fitted)]
        self.friction = fitted_friction(records, prior_of(self.arm, []), SMOOTH)

    def record(self, run: Run) -> CurrentSamples:
        """Return a run's samples with the torque of the links found."""
        signals, motion = run.signals, run.motion
        torques = joint_torques(self.arm, carried(None, signals), signals, motion)
        record = current_record(
            AlignedRecording(name=run.name, signals=signals, motion=motion, torques=torques),
            self.arm,
            run.before,
        )
        assert record is not None
        return record

    def predicted(self, run: Run, fit: CurrentFit | None = None) -> tuple[Array, Array]:
        """Return the torque (N, n) [Nm] of a run, low-passed except at its ends, and the half-width
        of its 95 % band, NaN at the ends.
        """
        record, fit = self.record(run), fit or self.friction.fit
        predicted = predict(fit, record)
        slow = SMOOTH(predicted, record)
        return np.where(np.isfinite(slow), slow, predicted), band(fit, record, SMOOTH)

    def inputs(self, run: Run, fit: CurrentFit) -> tuple[Array, Array]:
        """Return (q, q̇, predicted torque) (N, 3 n) of a run, and the residual torque (N, n)."""
        torque, _ = self.predicted(run, fit)
        return np.hstack([run.motion.q, run.motion.motor_qd, torque]), run.torque - torque
