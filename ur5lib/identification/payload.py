"""The payload's mass from motor currents alone.

A payload adds a torque that is linear in its mass and first moments. Friction grows with the
torque, too, so both are estimated alternately. Apparent loads of unloaded runs scale the errors.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.special import stdtrit

from ur5lib.identification.currents import motions, predicted_currents, torque_constants
from ur5lib.identification.regression import Normal, regress, spread
from ur5lib.identification.samples import (
    INDEPENDENT_STEP,
    CurrentSamples,
    Smooth,
    blocks,
    columns_of,
    held_columns,
    smoothed_moving,
)
from ur5lib.records.friction import CurrentFit, JointFit
from ur5lib.records.prediction import JudgedLoad, LoadEstimate
from ur5lib.robots.friction import GEAR_EFFICIENCY_STD, JointMotion
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.metrics import NORMAL95

FRICTION_ROUNDS = 5  # load and friction are estimated in turn, this many times
PAYLOAD_DRAWS = 50  # replicates of the bootstrap
UNSCALED_TORQUE_ERROR = 0.3  # relative error of a joint's torque under a load, before it is scaled
SCALED_TORQUE_ERROR = 0.1  # relative error of a joint's torque under a load, after it is scaled
RUN_PARTS = 3  # a run has this many parts, each of which must show the load
AXIS_TOLERANCE = 1e-9  # shorter axes, relative to the longest principal one, are rounding
PAYLOAD_PRIOR_STD = 100.0  # kg, kg m
Maps = Sequence[Array]  # coefficients (P,) of each joint, as fitted or drawn


@dataclass(frozen=True)
class PayloadEstimate:
    """A payload estimated from a run's currents.

    parameters, std_error: (P,), of the regressor's columns [kg, kg m, ...], the mass first; errors
    are from the bootstrap over the run's blocks and over the fit, without the variation between
    runs; parts: masses [kg] from each part of the run alone. All are empty where nothing was
    estimated.
    """

    parameters: Array = field(default_factory=lambda: np.zeros(0))
    std_error: Array = field(default_factory=lambda: np.zeros(0))
    parts: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def is_known(self) -> bool:
        """Return whether anything was estimated."""
        return len(self.parameters) > 0


def error_growth(parameters: Array, std_error: Array, paths: int) -> Array:
    """Return the factor (P,) on standard errors with which they cover the loads that unloaded runs
    seem to have.

    Birge's ratio √(Σ (x/s)² / Σ (1 - s²/σ²)), at least one, times Student's t / 1.96 for few paths.
    parameters x, std_error s: (R, P), of unloaded runs, each under a fit without it; 0 ± σ: prior;
    paths: number of their trajectories.
    """
    known = std_error > 0
    deviations = np.divide(parameters, std_error, out=np.zeros_like(parameters), where=known)
    told = np.where(known, 1 - (std_error / PAYLOAD_PRIOR_STD) ** 2, 0.0).clip(min=0.0)
    ratio = np.sum(deviations**2, axis=0) / np.maximum(np.sum(told, axis=0), 1.0)
    few_paths = stdtrit(max(1, paths - 1), 0.975) / NORMAL95
    return np.asarray(few_paths * np.sqrt(np.maximum(ratio, 1.0)))


def judge(payload: PayloadEstimate, growth: float) -> LoadEstimate:
    """Return the load's mass with its total error and whether it is certain; growth: factor on the
    mass's error, see `error_growth`.
    """
    mass = float(payload.parameters[0])
    error = float(np.hypot(growth * payload.std_error[0], GEAR_EFFICIENCY_STD * mass))
    half = error * NORMAL95
    lasting = bool((payload.parts > mass / 2).all())
    return LoadEstimate(mass, error, (mass - half, mass + half), mass > 3 * error and lasting)


def judged_load(
    payload: PayloadEstimate,
    unloaded: Sequence[PayloadEstimate],
    paths: int,
    configured: float,
    may_be_taken: bool,
) -> JudgedLoad:
    """Return the undeclared load, with whether it is taken into account.

    It is if it is certain and may be. unloaded: payloads of the recordings to fit on, along `paths`
    paths; configured: mass of the payload that the controller was given [kg]; may_be_taken: false
    if the study declares that payload, or in a recording to fit on, where the payload is taken as
    given.
    """
    growth = np.ones_like(payload.parameters)
    if estimates := [
        (estimate.parameters, estimate.std_error) for estimate in unloaded if estimate.is_known
    ]:
        values, errors = np.stack(estimates, axis=1)
        growth = error_growth(values, errors, paths)
    load = judge(payload, float(growth[0]))
    center = center_std = np.full(3, np.nan)
    if load.certain:
        center = payload.parameters[1:] / load.mass
        # c = h / m: σ_c² = (σ_h² + c² σ_m²) / m²
        moment_std = (growth * payload.std_error)[1:]
        center_std = np.hypot(moment_std, center * load.std_error) / load.mass
    return JudgedLoad(
        **vars(load),
        configured=configured,
        carried=configured + load.mass,
        taken=load.certain and may_be_taken,
        center_of_mass=center,
        center_of_mass_std=center_std,
    )


def joint_gains(external_torque: Array, load: Array, count: int) -> Array:
    """Return by which share (n,) each joint's torque under a load is wrong.

    external_torque: (N, n) [Nm], without the load's torque; load: the load's torque, with the same
    low-pass; count: number of independent values among the samples. The torque constants of joints
    that carry little are uncertain. Least squares with a prior of 0 ± UNSCALED_TORQUE_ERROR.
    """
    finite = np.isfinite(external_torque + load).all(axis=1)
    external_torque, load = external_torque[finite], load[finite]
    noise = external_torque.var(axis=0) if finite.any() else np.ones(load.shape[1])
    # g = Σ τ_ext τ / (Σ τ² + N σ² / (n σ_g²)), n independent of N samples
    prior_weight = noise / UNSCALED_TORQUE_ERROR**2 * len(load) / max(1, count)
    return np.asarray(
        (external_torque * load).sum(axis=0) / ((load**2).sum(axis=0) + prior_weight + 1e-12)
    )


def estimate_payload(
    fit: CurrentFit,
    record: CurrentSamples,
    regressor: Array,
    smooth: Smooth,
    whole: CurrentFit | None = None,
    seed: int = 0,
) -> PayloadEstimate:
    """Return the payload that the currents show and `record.torque` does not contain.

    regressor: (N, 6, P) torque [Nm] per mass [kg], first moment [kg m], ... of the payload; the
    mass comes first; whole: the fit to all paths, with replicates that show the errors of `fit`,
    which may lack some paths; None for `fit` itself. Only joints in motion count: at rest, friction
    hides a load.
    """
    # regressor in units of each joint's band, low-passed and thinned, samples in motion only
    stride = max(1, round(INDEPENDENT_STEP / record.period))
    scale = torque_constants(fit) * [joint.band_moving or np.nan for joint in fit.joints]
    parts = [smooth(column, record)[::stride] for column in np.moveaxis(regressor, 2, 0)]
    explained = np.stack(parts, axis=2)
    moving = smoothed_moving(record, smooth)[::stride]
    rows = moving & np.isfinite(explained).all(axis=2) & np.isfinite(scale)
    block = np.repeat(blocks(record)[::stride, None], rows.shape[1], axis=1)[rows]
    columns = (explained / scale[:, None])[rows]
    axes, along = _principal_axes(columns)
    unloaded = [*motions(record)]

    def solve(maps: Maps, current: Array, start: Array, count: Labels, prior_mean: Array) -> Array:
        constants = 1 / np.array([coefficients[0] for coefficients in maps])
        torque = (current * constants / scale)[rows] + columns @ start
        return np.asarray(axes.T @ _huber_solution(along, torque, block, count, axes @ prior_mean))

    once = np.ones(1 + block.max(initial=0), dtype=np.int64)
    fitted = [joint.estimate.coefficients for joint in fit.joints]
    solution = no_load = np.zeros(regressor.shape[2])  # payload and friction in turn
    for _ in range(FRICTION_ROUNDS):
        loaded = _motions_under(unloaded, record.torque + regressor @ solution)
        unexplained = smooth(record.current - predicted_currents(fit, loaded), record)[::stride]
        solution = solve(fitted, unexplained, solution, once, no_load)
    # from here on, friction is that under this load: replicates only weight its columns anew
    loaded = _motions_under(unloaded, record.torque + regressor @ solution)
    sources = _low_passed_columns(fit, loaded, record, smooth)
    # bootstrap over fits, blocks and priors, so that undetermined parameters are uncertain
    generator, draws = np.random.default_rng(seed), []
    by_joint = map(_replicates, fit.joints, (whole or fit).joints)
    replicates = [*zip(*by_joint, strict=True)]  # drawn alike for all joints
    for _ in range(PAYLOAD_DRAWS):
        drawn_maps = replicates[generator.integers(len(replicates))]
        count = generator.multinomial(len(once), once / len(once))
        drawn_mean = generator.normal(no_load, PAYLOAD_PRIOR_STD)
        current = _unexplained_current(fit, drawn_maps, sources)
        draws.append(solve(drawn_maps, current, solution, count, drawn_mean))
    unexplained = _unexplained_current(fit, fitted, sources)
    counts = _counts_by_part(block)
    parts = [solve(fitted, unexplained, solution, count, no_load)[0] for count in counts]
    return PayloadEstimate(solution, spread(np.array(draws)), np.array(parts))


def _replicates(joint: JointFit, whole: JointFit) -> Array:
    """Return replicates (B, P): the coefficients of `joint` plus the bootstrap errors of `whole`.

    Terms that `whole` lacks have no error.
    """
    estimate, names = whole.estimate, whole.names()
    errors = dict(zip(names, (estimate.replicates - estimate.coefficients).T, strict=True))
    none = np.zeros(len(estimate.replicates))
    of_terms = [errors.get(name, none) for name in joint.names()]
    return np.asarray(joint.estimate.coefficients + np.stack(of_terms, axis=1))


def _counts_by_part(block: Labels) -> list[Labels]:
    """Return, for each of RUN_PARTS parts of a run, which blocks belong to it, as counts 0 or 1."""
    every_block, parts = (
        np.arange(1 + block.max(initial=0)),
        np.array_split(np.unique(block), RUN_PARTS),
    )
    return [np.isin(every_block, part).astype(np.int64) for part in parts]


def _motions_under(joints: Sequence[JointMotion], torque: Array) -> Iterator[JointMotion]:
    """Yield the joints' motions under another torque (N, n) [Nm]."""
    for motion, joint_torque in zip(joints, torque.T, strict=True):
        yield replace(motion, torque=joint_torque)


def _low_passed_columns(
    fit: CurrentFit, joints: Iterable[JointMotion], record: CurrentSamples, smooth: Smooth
) -> list[Array]:
    """Return, for each joint, its columns in motion and at rest, and its current, (n, P + D + 2),
    low-passed and thinned.

    They are NaN, also for the low-pass, where any joint's are.
    """
    stride, moves = max(1, round(INDEPENDENT_STEP / record.period)), [*joints]
    finite = np.isfinite(record.current - predicted_currents(fit, moves)).all(axis=1)
    sources = []
    for motion, model, current in zip(moves, fit.joints, record.current.T, strict=True):
        known = columns_of(motion, model.terms), held_columns(motion, model.distances)
        columns = np.column_stack([*known, current])
        columns[~finite] = np.nan
        sources.append(smooth(columns, record)[::stride].copy())
    return sources


def _unexplained_current(fit: CurrentFit, maps: Maps, sources: Sequence[Array]) -> Array:
    """Return measured minus predicted currents (M, n) [A]; sources: by `_low_passed_columns`."""
    joints = zip(sources, maps, fit.joints, strict=True)
    currents = [
        columns @ [*-coefficients, *-model.held, 1.0] for columns, coefficients, model in joints
    ]
    return np.stack(currents, axis=1)


def _principal_axes(columns: Array) -> tuple[Array, Array]:
    """Return the principal axes (P, P) of columns (n, P), one a row, and the columns (n, P) along
    them.

    Columns are zero along axes that the data do not determine, as of an arm that moves in a plane:
    these keep the prior's mean. Solved together, rounding would let precise data outweigh the prior
    there.
    """
    size = columns.shape[1]
    triangle = np.linalg.qr(np.concatenate([columns, np.zeros((size, size))]), mode="r")
    _, length, axes = np.linalg.svd(triangle)
    return axes, columns @ np.where(length > AXIS_TOLERANCE * length[0], axes.T, 0.0)


def _huber_solution(
    columns: Array, torque: Array, block: Labels, count: Labels, prior_mean: Array
) -> Array:
    """Return Huber's estimate (P,) from blocks, each taken `count` times, with a wide prior around
    prior_mean (P,).
    """
    repeated = np.repeat(np.arange(len(block)), count[block])
    wide = Normal(prior_mean, np.eye(columns.shape[1]) / PAYLOAD_PRIOR_STD**2)
    return regress(columns[repeated], torque[repeated], block[repeated], wide).coefficients
