"""The models of the real arms, against what their controllers computed."""

import numpy as np
import pytest

from tests.conftest import shared_folder
from tests.entries import read_and_check
from tests.real_arms import RealStudy
from ur5lib.commands.check import look_through
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.carried import carried
from ur5lib.records.codes import Found
from ur5lib.records.signals import Signals
from ur5lib.study.model import Study
from ur5lib.study.reading import parse_study


@pytest.mark.parametrize("number", range(1, 6))
def test_gravity_of_the_ur10e_at_rest(real_ur10e: RealStudy, number: int) -> None:
    one = real_ur10e.recording(f"ur-20_01_17-p{number}")
    signals = one.signals
    assert signals.actual_qd is not None
    assert signals.target_moment is not None
    at_rest = (np.abs(signals.actual_qd).max(axis=1) < 1e-3) & ~signals.interpolated
    torque = LinkModel(one.robot, "maker").gravity_torque(signals.actual_q[at_rest])
    assert at_rest.sum() > 100
    assert np.abs(signals.target_moment[at_rest] - torque).max() < 0.13


@pytest.fixture(scope="module")
def real_ur5e() -> Study:
    folder = str(shared_folder("ur5e", "they have no licence and are not downloaded"))
    entries = [
        {"name": name, "format": "rtde-csv", "folder": folder, "role": "contact"}
        | {"file": f"rtde_500hz_{name}.csv"}
        for name in ("moving", "freedrive")
    ]
    study = {"study": "ur5e", "title": "A UR5e", "robot": "ur5e", "recordings": entries}
    return parse_study(study, "ur5e.yaml")


def test_the_ur5e_s_model_is_its_controller_s(real_ur5e: Study) -> None:
    """With the rotors, and the payload that its file states; nothing else is said of the arm."""
    moving = real_ur5e.recordings[0]
    robot = moving.arm.description()
    taken = read_and_check(moving, robot, 0.1).robot
    signals = Signals.from_table(taken)
    payload = carried(moving.known_payload(), signals).payload
    assert payload is not None
    assert payload.mass == pytest.approx(0.1)
    states = (signals.target_q, signals.target_qd, signals.target_qdd)
    torque = LinkModel(robot.carrying(payload), "maker+rotors").inverse_dynamics(*states)
    error = np.abs(signals.target_moment - torque)[~signals.interpolated]
    assert (error.mean(axis=0) < [0.002, 0.02, 0.002, 0.001, 0.001, 0.001]).all()  # Nm


def test_findings_about_the_ur5e_are_true(real_ur5e: Study) -> None:
    found = {
        recording.name: {one.code for one in look_through(recording, real_ur5e)[0].findings}
        for recording in real_ur5e.recordings
    }
    frames = {Found.REPEATED_FRAMES, Found.STALE_STAMPS, Found.LOST_FRAMES, Found.CROWDED_FRAMES}
    known = {Found.UNUSED_CHANNELS, Found.WRIST_SENSOR} | frames
    hardly_moved = {Found.SIGN_NOT_CHECKED, "unmoved"}  # base, and wrist 2 by 3 mrad
    assert found["moving"] == known | hardly_moved
    assert found["freedrive"] == known | {Found.STALE_DATA, Found.SILENT_CHANNEL}
