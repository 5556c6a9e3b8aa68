"""`ur5 export --to direct-torque`: scales of the friction that UR's controller compensates.

URScript's `direct_torque` adds, joint by joint, a share of viscous and of Coulomb friction from the
controller's model of it (`viscous_scale`, `coulomb_scale`, 0 to 1; script manual 5.25.1). What the
controller takes friction for is read in its `target_current`, which is its `target_moment` over a
torque constant plus friction. The scale is the measured friction over the expected one, both as
currents: these are what the motor gets, whichever torque constant is right.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import yaml

from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.identification.currents import CurrentFit, JointFit
from ur5lib.identification.regression import spread
from ur5lib.identification.samples import Record
from ur5lib.pipeline.current_samples import current_record
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.timeseries.arrays import Array

KINDS = ("viscous_scale", "coulomb_scale")
FAST = 0.15  # rad/s; below, Stribeck friction and the controller's smooth reversal prevail
FEWEST = 100  # samples above FAST
BLOCKS = 10  # of the jackknife
MOST = 0.2  # standard error of a scale; the maker's defaults, 0.7 to 0.9, leave as much
HEAD = """\
# Friction scales of {robot}, joints 1 to 6: `parameters` is for direct_torque of URScript (from
# PolyScope 5.25.1 and X 10.12.1 on) and set_friction_model_parameters of the maker's ROS 2 driver.
# `identified` is the measured friction over that in the controller's target_current, with its
# standard error `std_error`. That direct_torque compensates this same friction is assumed; the
# maker does not say so. What exceeds 1, the largest scale, is not compensated.
"""


class Expected(NamedTuple):
    """A fitted recording, and the controller's targets beside it.

    qd [rad/s], qdd [rad/s²], moment [Nm], current [A]: (N, 6).
    """

    record: Record
    qd: Array
    qdd: Array
    moment: Array
    current: Array


class Scales(NamedTuple):
    """Scales of viscous and Coulomb friction (2, 6), and their standard errors."""

    value: Array
    std_error: Array


def direct_torque(robot: str, results: Path | None) -> str:
    """Return an arm's friction scales as YAML. Raises InputError where they are undetermined."""
    if results is None:
        raise InputError("a study identifies friction scales; name its folder by --results")
    study = FinishedStudy(results)
    friction = study.parameters(Friction, robot, "friction")
    runs = [*expectations(study, robot, friction)]
    if not runs:
        raise InputError(
            f"{results} has no fit of {robot}'s friction to a recording with target_qd, "
            "target_qdd, target_moment and target_current, which hold the friction that the "
            "controller expects; record these outputs in `fit` recordings"
        )
    return written(robot, friction_scales(friction.fit, runs))


def expectations(study: FinishedStudy, robot: str, friction: Friction) -> Iterator[Expected]:
    """Yield the recordings of a fit that have the controller's targets."""
    model = study.arm(robot).fullest_model()
    for name in friction.from_:
        signals = study.record(Signals, name)
        known = study.record(Motion, name), study.record(Torques, name)
        record = current_record(name, signals, *known, model)
        targets = signals.target_qd, signals.target_qdd
        qd, qdd, moment, current = *targets, signals.target_moment, signals.target_current
        if qd is None or qdd is None or moment is None or current is None or record is None:
            continue
        yield Expected(record, qd, qdd, moment, current)


def friction_scales(fit: CurrentFit, runs: Sequence[Expected]) -> Scales:
    """Return the scales of all joints, NaN for a joint with too few samples in motion."""
    own = [measured_friction(model, joint, runs) for joint, model in enumerate(fit.joints)]
    known = [expected_friction(joint, runs) for joint in range(len(fit.joints))]
    (value, error), (reference, doubt) = np.stack(own, axis=-1), np.stack(known, axis=-1)
    scale = value / reference
    return Scales(scale, np.abs(scale) * np.hypot(error / value, doubt / reference))


def measured_friction(model: JointFit, joint: int, runs: Sequence[Expected]) -> Array:
    """Return viscous [A s/rad] and Coulomb [A] friction in the measured current less that of the
    links' torque and the offset, and their standard errors, (2, 2); joint: 0 to 5.

    The errors are a jackknife over blocks and, for constant and offset, the bootstrap of the fit.
    """
    parts = []
    for record in (run.record for run in runs):
        qd, torque, current = record.qd[:, joint], record.torque[:, joint], record.current[:, joint]
        parts.append(_fast(qd, np.column_stack([torque, np.ones_like(qd), current])))
    rows, estimate = np.vstack(parts), model.estimate
    columns, of_links, current = rows[:, :2], rows[:, 2:4], rows[:, 4]
    own, error = _jackknifed(columns, current - of_links @ estimate.coefficients[:2])
    of_known = _solved(columns, of_links) @ estimate.replicates[:, :2].T
    return np.stack([own, np.hypot(error, spread(of_known.T))])


def expected_friction(joint: int, runs: Sequence[Expected]) -> Array:
    """Return viscous [A s/rad] and Coulomb [A] friction in `target_current`, and their standard
    errors by a jackknife over blocks, (2, 2); joint: 0 to 5.
    """
    parts = []
    for run in runs:
        qd, qdd, moment, current = (values[:, joint] for values in run[1:])
        parts.append(_fast(qd, np.column_stack([moment, qdd, np.ones_like(qd), current])))
    rows = np.vstack(parts)
    return np.stack(_jackknifed(rows[:, :-1], rows[:, -1]))


def written(robot: str, scales: Scales) -> str:
    """Return scales as YAML. Raises InputError where a standard error exceeds MOST."""
    for kind, errors in zip(KINDS, scales.std_error, strict=True):
        if vague := [str(joint) for joint, error in enumerate(errors, 1) if not error <= MOST]:
            raise InputError(
                f"{kind} of {robot} is undetermined, with a standard error above {MOST}, for joint"
                f"{'s' * (len(vague) > 1)} {', '.join(vague)}: add `fit` recordings that move "
                "them, unless the controller's target_current has no such friction, as on arms "
                "without a wrist sensor"
            )
    parts = {
        "parameters": np.clip(scales.value, 0, 1),
        "identified": scales.value,
        "std_error": scales.std_error,
    }
    tables = {
        name: dict(zip(KINDS, np.round(values, 3).tolist(), strict=True))
        for name, values in parts.items()
    }
    head = HEAD.format(robot=robot)
    return head + yaml.safe_dump(tables, sort_keys=False, default_flow_style=None, width=99)


def _fast(qd: Array, columns: Array) -> Array:
    """Return the rows in motion of viscous and Coulomb friction's columns, and of further ones."""
    rows = np.column_stack([qd, np.sign(qd), columns])
    return np.asarray(rows[(np.abs(qd) > FAST) & np.isfinite(rows).all(axis=1)])


def _jackknifed(columns: Array, values: Array) -> tuple[Array, Array]:
    """Return the first two coefficients, and standard errors by leaving out blocks of rows."""
    every = np.arange(len(values))
    kept = (np.delete(every, block) for block in np.array_split(every, BLOCKS))
    left = [_solved(columns[rows], values[rows])[:2] for rows in kept]
    return _solved(columns, values)[:2], np.sqrt(BLOCKS - 1) * np.std(left, axis=0)


def _solved(columns: Array, values: Array) -> Array:
    """Return the coefficients by least squares, NaN with too few samples."""
    if len(columns) < FEWEST:
        return np.full((columns.shape[1], *values.shape[1:]), np.nan)
    return np.asarray(np.linalg.lstsq(columns, values, rcond=None)[0])
