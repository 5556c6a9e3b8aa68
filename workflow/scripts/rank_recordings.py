"""What another recording of an arm is worth: the bands before and after it, in a user's units."""

from typing import Any

from ur5lib.excitation.outlook import Bands, Earlier, Outlook, RecordedStates, feels_forces
from ur5lib.pipeline.carried import Carried
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.models import Identification
from ur5lib.pipeline.records.motion import Motion
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_rows

SECONDS = 20.0  # of the recordings that may come next, as `ur5 excite` designs them


def rank_recordings(input: Any, output: Any, params: Any) -> None:
    arm, friction = load_robot(input.arm), read_record(Friction, input.friction)
    base = read_record(Identification, input.identification)
    rows = list[Bands]()
    if friction.fit.joints and feels_forces(arm):
        recordings = []
        files = zip(params.recordings, params.gravities, input.motion, input.loads, strict=True)
        for name, gravity, motion_file, load in files:
            if name in {*friction.from_, *base.from_}:
                motion, carried = Motion.read(motion_file), read_record(Carried, load)
                robot = arm.carrying(carried.payload).mounted(gravity)
                states = motion.q, motion.qd, motion.qdd
                recordings.append(RecordedStates.along(robot, motion.time, *states))
        known = Earlier(
            friction.fit,
            friction.parameters,
            base.noise,
            fitted=len(friction.from_),
            recordings=recordings,
        )
        outlook = Outlook(arm, known)
        rows = outlook.ranked(outlook.candidates(SECONDS))
    write_rows(Bands, rows, output.ranking)
