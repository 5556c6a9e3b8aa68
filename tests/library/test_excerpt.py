"""Parts of a recording."""

import numpy as np
import pandas as pd
import pytest

from ur5lib.errors import InputError
from ur5lib.recordings.formats import excerpt
from ur5lib.recordings.recording import DeviceRecord, RawRecording

BOOT = 5000.0  # s, of the controller's clock at the first frame
WHOLE = RawRecording(
    DeviceRecord(pd.DataFrame({"time": BOOT + np.arange(11.0)}), None, "robot.csv"), None, {}
)


@pytest.mark.parametrize(
    ("start", "end", "seconds"),
    [(2.0, 4.0, [2, 3]), (None, 2.0, [0, 1]), (9.0, None, [9, 10]), (0.0, 1.0, [0])],
)
def test_a_part_begins_at_its_start_and_ends_before_its_end(
    start: float | None, end: float | None, seconds: list[int]
) -> None:
    part = excerpt(WHOLE, start, end).robot.table
    assert (part["time"] - BOOT).tolist() == seconds
    assert part.index.tolist() == [*range(len(seconds))]


def test_a_part_without_frames_is_refused() -> None:
    with pytest.raises(InputError, match=r"robot\.csv: has no frame .*; it lasts 10 s"):
        excerpt(WHOLE, 10.5, 12.0)
