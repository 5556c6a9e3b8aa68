"""Joint motion from the encoders by a Kalman smoother."""

from typing import Any

from ur5lib.pipeline.smoothed_motion import measured, motion_account, motion_noise, motion_record
from ur5lib.records.signals import Signals
from ur5lib.smoothing.encoders import smooth_encoders
from ur5lib.tables import write_json


def smooth_motion(input: Any, output: Any, params: Any) -> None:
    signals = Signals.read(input.signals)
    motion = smooth_encoders(signals.time, signals.segment, *measured(signals))
    motion_record(signals, motion).write(output.motion)
    motion_noise(signals, motion).write(output.noise)
    write_json({"encoders": motion_account(motion)}, output.summary)
