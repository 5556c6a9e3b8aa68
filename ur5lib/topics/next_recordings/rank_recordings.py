"""The value of another recording of an arm: the bands before and after it, in a user's units."""

from collections.abc import Mapping, Sequence

from ur5lib.excitation.outlook import Bands, Earlier, Outlook, RecordedStates, feels_forces
from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.topics.next_recordings.found import NOW
from ur5lib.topics.next_recordings.rows import RankedBands

WORTHWHILE_BAND_RATIO = 0.9  # a worthwhile recording leaves at most this share of a force's band
# Candidates last as long as the recordings that `ur5 excite` designs.
CANDIDATE_DURATION = 20.0  # s


@step("arm", "next_recordings.csv", recordings="fit", identification="summary")
def rank_recordings(
    arm: Robot,
    motion: Mapping[str, Motion],
    premises: Mapping[str, Premises],
    friction: Friction,
    identification: Identification,
    gravities: dict[str, list[float] | None],
) -> list[RankedBands]:
    """Return the bands after each kind of recording; empty without a fit.

    motion, premises, gravities: of the arm's `fit` recordings.
    """
    if not friction.fit.joints or not feels_forces(arm):
        return []
    recordings = []
    for name in motion:
        if name in {*friction.from_, *identification.from_}:
            moved, load = motion[name], premises[name].load.payload
            robot = arm.carrying(load).mounted(gravities[name])
            recordings.append(RecordedStates.along(robot, moved.time, moved.q, moved.qd, moved.qdd))
    known = Earlier(
        friction.fit,
        friction.parameters,
        identification.noise,
        fitted=len(friction.from_),
        recordings=recordings,
    )
    outlook = Outlook(arm, known)
    return with_worth(outlook.ranked(outlook.candidates(CANDIDATE_DURATION)))


def with_worth(ranked: Sequence[Bands]) -> list[RankedBands]:
    """Return the bands after each recording, with `worthwhile` added."""
    now = next(one.force for one in ranked if one.after == NOW)
    return [
        RankedBands(
            **vars(one), worthwhile="yes" if one.force <= WORTHWHILE_BAND_RATIO * now else "no"
        )
        for one in ranked
    ]
