"""A device that a process records, which loads little else."""

import time

import numpy as np

from ur5lab.recorder.device import Identity, NewSamples
from ur5lab.recorder.opened import opened


class MadeUp:
    """A device at 100 Hz, which takes for ever in its hundredth `read`, in `close`, or nowhere."""

    def __init__(self, hangs_in: str = "", width: int = 1) -> None:
        self.columns = tuple(f"reading_{k}" for k in range(width))
        self.identity = Identity(model="made up", address="here", units="SI", rate_hz=100.0)
        self.hangs_in, self.count = hangs_in, 0

    def read(self) -> NewSamples:
        time.sleep(0.01)
        self.count += 1
        if self.count == 100 and self.hangs_in == "read":
            time.sleep(60)
        values = np.random.default_rng(self.count).random((1, len(self.columns)))
        return NewSamples(np.array([time.monotonic()]), values, 0)

    def close(self) -> None:
        if self.hangs_in == "close":
            time.sleep(60)


@opened.register
def _made_up(settings: MadeUp) -> MadeUp:
    return settings
