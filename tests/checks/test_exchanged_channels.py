"""Measured currents are told from their targets by their noise, of measured samples alone."""

import numpy as np
import pandas as pd
import pytest

from tests.synthetic import poor_log
from ur5lib.channels import columns
from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.recordings.frames import repair_frames
from ur5lib.records.codes import CauseCode
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel, named

CURRENTS, TARGETS = columns("actual_current"), columns("target_current")


@pytest.fixture(scope="module")
def log() -> pd.DataFrame:
    arm = load_robot(robot_path("ur5"))
    made = poor_log(arm, 30, seed=1)
    torque = gravity_torque(arm, arm.chosen_model, channel(made, "actual_q"))
    return made.assign(epoch=0, **named(torque / arm.maker_torque_constants(), "target_current"))


@pytest.mark.parametrize("is_exchanged", [False, True])
@pytest.mark.parametrize("missing", [0.1, 0.3, 0.5])
def test_cells_that_are_missing_have_no_noise(
    log: pd.DataFrame, missing: float, is_exchanged: bool
) -> None:
    holes = np.random.default_rng(0).random((len(log), 6)) < missing
    frames = log.assign(**{name: log[name].mask(holes[:, k]) for k, name in enumerate(CURRENTS)})
    if is_exchanged:
        frames = frames.rename(
            columns=dict(zip(CURRENTS + TARGETS, TARGETS + CURRENTS, strict=True))
        )
    table, *_ = repair_frames(frames, None, 0.1, "log.csv")
    signs = stop_signs(Checked(table, load_robot(robot_path("ur5")), None, None, True, cutoff=2.0))
    assert (CauseCode.EXCHANGED_CHANNELS in [sign.cause for sign in signs]) == is_exchanged
