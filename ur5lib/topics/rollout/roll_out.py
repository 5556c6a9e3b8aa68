"""How far an arm's models go astray in open loop: each is simulated under recorded efforts, over
windows of recordings that the fit of its friction has not seen.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import scipy  # loads scipy.spatial at its first use

from ur5lib.dynamics.many_arms import ManyArms
from ur5lib.identification.current_samples import measured_samples
from ur5lib.identification.samples import CurrentSamples
from ur5lib.recordings.copies import same_runs
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.steps.fit_friction import untouched
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.trajectories import POSITION_TOLERANCE, scaled_states
from ur5lib.topics.rollout.errors import MIN_WINDOWS, deviations, rows_of
from ur5lib.topics.rollout.models import (
    IDENTIFIED,
    STILL,
    Constants,
    Contender,
    contenders,
    terms_of,
    with_described,
)
from ur5lib.topics.rollout.rows import RolledOut
from ur5lib.topics.rollout.simulation import ManyFrictions, simulated
from ur5lib.topics.rollout.windows import (
    ENDS,
    HORIZONS,
    Windows,
    joined,
    starts_of,
    starts_within,
    windows_at,
)

MOST_WINDOWS = 100  # of an arm; of more, every so many
NONE = np.zeros(0, dtype=np.int64)
SEARCHED_STEP = 0.008  # s; among states this far apart, repeats are searched


class Inputs(Opened):
    """What is read of a recording."""

    signals: Signals
    motion: Motion
    premises: Premises
    prediction: Prediction
    quality: Quality


class Run(NamedTuple):
    """A recording: its samples, with unknown efforts in contacts, and the arm as it was."""

    samples: CurrentSamples
    arm: Robot


@step("arm", "rollout.csv", recordings="drawn")
def roll_out(
    arm: Robot,
    recordings: Mapping[str, Inputs],
    friction: Friction,
    gravities: dict[str, list[float] | None],
) -> list[RolledOut]:
    """Return the errors of simulated arms after each of HORIZONS; empty without enough windows.

    recordings, gravities: of the arm's contact-free recordings.
    """
    runs = runs_of(arm, recordings, friction, gravities)
    windows = windows_of(runs)
    return [] if windows is None else [*compared(arm, runs, friction, windows)]


def runs_of(
    arm: Robot,
    recordings: Mapping[str, Inputs],
    friction: Friction,
    gravities: Mapping[str, list[float] | None],
) -> list[Run]:
    """Return the recordings that a fit has not seen, without copies of others; empty without a fit,
    and for an arm with coupled motors, whose friction acts on shafts. Arguments: as of `roll_out`.
    """
    if not friction.from_ or arm.drives.coupling:
        return []
    prints = {name: recording.quality.fingerprint for name, recording in recordings.items()}
    copied = {one if other in friction.from_ else other for one, other in same_runs(prints)}
    described = with_described(arm)
    return [
        Run(samples, described.carrying(recording.premises.load.payload).mounted(gravities[name]))
        for name, recording in recordings.items()
        if name not in copied and is_unseen(name, arm, friction)
        if (samples := samples_of(name, recording, arm))
    ]


def windows_of(runs: Sequence[Run]) -> Windows | None:
    """Return the windows of recordings, at most MOST_WINDOWS, evenly; None if there are too few."""
    every = [windows_at(run.samples, starts_of(run.samples), k) for k, run in enumerate(runs)]
    count = sum(len(own.row) for own in every)
    if count < MIN_WINDOWS:
        return None
    chosen = np.linspace(0, count - 1, min(count, MOST_WINDOWS)).astype(np.int64)
    return joined(every).at(chosen)


def is_unseen(name: str, arm: Robot, friction: Friction) -> bool:
    """Return whether there is a fit that has not seen a recording's efforts; to those of the fit,
    unknown links are fitted, too.
    """
    left_out = any(name in own.recordings for own in friction.left_out)
    return name not in friction.from_ or (left_out and arm.links == "known")


def samples_of(name: str, recording: Inputs, arm: Robot) -> CurrentSamples | None:
    """Return the samples of a recording; None without a prediction of its efforts, with a load that
    nobody declared, or of which samples are further apart than the first of HORIZONS.
    """
    signals, motion = recording.signals, recording.motion
    is_slow = len(motion.time) < 2 or motion.period > HORIZONS[0]
    if not recording.prediction.scores or recording.prediction.is_loaded or is_slow:
        return None
    samples = measured_samples(name, signals, motion, arm, np.zeros_like(motion.q))
    return samples and untouched(samples, signals.time, recording.premises.touched)


def compared(
    arm: Robot, runs: Sequence[Run], friction: Friction, windows: Windows
) -> Iterator[RolledOut]:
    """Yield the rows of rollout.csv of an arm; windows: of its runs."""
    again, repeated = repeats(windows, runs)
    cases = [(own, windows) for own in contenders(arm, friction)]
    *ends, ends_again = rolled([*cases, (cases[0][0], again)], runs, friction)
    names = [own.name for own, _ in cases]
    found = dict(zip(names, (deviations(arm, q, windows.reached) for q in ends), strict=True))
    still = np.broadcast_to(windows.q[:, None], windows.reached.shape)
    found[STILL] = deviations(arm, still, windows.reached)
    differing = deviations(arm, ends_again, again.reached) - found[IDENTIFIED][repeated]
    yield from rows_of(found, differing, len(np.unique(windows.recording)))


def repeats(windows: Windows, runs: Sequence[Run]) -> tuple[Windows, Labels]:
    """Return windows of other recordings with the motion of some windows, and the places (R,) of
    these among them.

    A repeat begins in the same state, and passes the same postures.
    """
    states = scaled_states(windows.q, windows.qd)
    found, left = [(windows.at(NONE), NONE)], np.ones(len(states), bool)
    for k, run in enumerate(runs):
        places = np.flatnonzero(left & (windows.recording != k))
        rows = searched(run.samples)
        if len(rows) and len(places):
            others = scaled_states(run.samples.q[rows], run.samples.qd[rows])
            apart = scipy.spatial.distance.cdist(states[places], others)
            near = apart.min(axis=1) < 1
            again, of = windows_at(run.samples, rows[apart.argmin(axis=1)[near]], k), places[near]
            away = np.abs(again.reached - windows.reached[of]).max(axis=(1, 2))
            same = np.flatnonzero(away < POSITION_TOLERANCE)
            found.append((again.at(same), of[same]))
            left[of[same]] = False
    parts, places_of_all = zip(*found, strict=True)
    return joined(parts), np.concatenate(places_of_all)


def searched(samples: CurrentSamples) -> Labels:
    """Return the samples from which on a window may repeat another."""
    every = max(1, round(SEARCHED_STEP / samples.period))
    return starts_within(samples, np.arange(0, len(samples.q), every))


def rolled(
    cases: Sequence[tuple[Contender, Windows]], runs: Sequence[Run], friction: Friction
) -> list[Array]:
    """Return the angles (W, H, n) [rad] after each of HORIZONS, for each pair of an arm and
    windows.
    """
    fits = [friction.fit_for(run.samples.name) for run in runs]
    terms, known = terms_of(fits), friction.known_constants
    documented, fitted = None if known is None else known.value, Constants.of(fits, terms)
    each = [fitted.of_contender(contender, terms, documented) for contender, _ in cases]
    constants = Constants(*map(np.concatenate, zip(*each, strict=True)))
    windows, counts = joined([own for _, own in cases]), [len(own.row) for _, own in cases]
    of = np.repeat(np.arange(len(cases)), counts) * len(runs) + windows.recording
    kinds = [(run.arm, contender.links) for contender, _ in cases for run in runs]
    torque_constant, offset, coefficients, rotors = (own[of] for own in constants)
    arm = kinds[0][0]
    balanced = np.isin(arm.joint_numbers, arm.balanced_joints).astype(float)
    angles = simulated(
        ManyArms(kinds, of, rotors),
        ManyFrictions(terms, coefficients, balanced),
        windows.start,
        torque_constant[:, None] * windows.effort + offset[:, None],
    )
    return np.split(angles[:, ENDS - 1], np.cumsum(counts)[:-1])
