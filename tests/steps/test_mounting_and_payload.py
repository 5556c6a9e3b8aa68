"""Steps that compute torques do so under a recording's gravity, with what its arm carries."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.made_records import motion_of
from ur5lib.identification.current_samples import current_record
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot, load_robot
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import Experiment, perform
from ur5lib.steps.compute_torques import RecordingTorques, compute_torques
from ur5lib.steps.identify_model import identify_model
from ur5lib.tables import write_table, write_text
from ur5lib.timeseries.lowpass import Butterworth

CYCLE, EVERY = 0.008, 8
WALL, TILTED = [0.0, -9.81, 0.0], [4.905, 0.0, -8.4957]
TOLD = Payload(mass=1.5, center_of_mass=(0.01, 0.02, 0.05), inertia=(0.002,) * 3 + (0.0,) * 3)
HIDDEN = Payload(mass=1.0, center_of_mass=(-0.02, 0.0, 0.1))
MODEL = "C+rotors"


class Made:
    """A recording of the stand without friction and noise."""

    def __init__(self, robot: Robot, folder: Path, gravity: list[float], **plan: Any) -> None:
        wanted = {"friction": False, "noise": False, "seconds": 6} | plan
        wanted = {"trajectory": {"kind": "fourier", "period_s": 6, "harmonics": 8}} | wanted
        plan_of = SimulatedRecording.model_validate(wanted)
        arm, random = robot.mounted(gravity), np.random.default_rng(0)
        self.done: Experiment = perform(arm, plan_of, random)
        self.gravity, file = gravity, folder / "signals.parquet"
        sent = frames(self.done, CYCLE, None)
        told = sent.drop(columns=["sent", "kept"], errors="ignore")
        write_table(told.assign(segment=0, interpolated=False), file)
        self.signals = Signals.read(file)
        states = (self.done.motion[name][::EVERY] for name in ("q", "qd", "qdd"))
        self.motion = motion_of(sent["time"].to_numpy(), *states)

    def torques(self, arm: Robot, declared: Payload | None) -> RecordingTorques:
        """With the payload that the study declares."""
        known = {"signals": self.signals, "motion": self.motion, "gravity": self.gravity}
        recording = AlignedRecording(role="contact", untouched=None, **known)
        return compute_torques(recording, arm, {"currents": 2.0}, declared)

    @property
    def true_torque(self) -> np.ndarray:
        """What the motors gave, (N, 6) [Nm]."""
        return self.done.motion["motor_torque"][::EVERY]


def test_targets_are_compared_as_told_and_currents_as_carried(ur5: Robot, tmp_path: Path) -> None:
    """A wall-mounted arm whose controller was told of one payload, and that carries another too."""
    payloads = {"payload": TOLD.model_dump(), "undeclared_payload": HIDDEN.model_dump()}
    made, physical = Made(ur5, tmp_path, WALL, **payloads), TOLD.joined(HIDDEN)
    torques, premises = made.torques(ur5, physical)
    np.testing.assert_allclose(torques.target[MODEL], made.signals.target_moment, atol=1e-4)
    known = {"signals": made.signals, "motion": made.motion, "torques": torques}
    record = current_record(AlignedRecording(name="made", **known), ur5)
    assert record is not None
    np.testing.assert_allclose(record.torque, made.true_torque, atol=1e-6)
    assert record.inertial is None  # of efforts behind the gears alone
    assert np.abs(torques.payload_torque).max() > 3
    load = premises.load
    assert (load.source, load.payload, load.configured) == ("study", physical, TOLD)


@pytest.mark.parametrize(("told", "source"), [(TOLD, "rtde"), (None, "none")])
def test_what_the_channels_say_is_carried_where_the_study_is_silent(
    ur5: Robot, tmp_path: Path, told: Payload | None, source: str
) -> None:
    made = Made(ur5, tmp_path, TILTED, payload=told and told.model_dump(), seconds=2)
    torques, premises = made.torques(ur5, None)
    load = premises.load
    assert (load.source, load.payload, load.configured) == (source, told, told)
    np.testing.assert_array_equal(torques.payload_torque, 0)
    np.testing.assert_allclose(torques.measured[MODEL], made.true_torque, atol=1e-4)


def test_one_model_is_fitted_to_recordings_under_several_gravities(
    ur5: Robot, tmp_path: Path
) -> None:
    """Rotors and links of the bare arm, a payload or not; what explains one explains the others."""
    made = {
        "wall": Made(ur5, tmp_path / "wall", WALL, payload=TOLD.model_dump()),
        "tilted": Made(ur5, tmp_path / "tilted", TILTED),
    }
    found = identify_model(
        ur5,
        {name: own.signals for name, own in made.items()},
        {name: own.motion for name, own in made.items()},
        {name: own.gravity for name, own in made.items()},
        Butterworth(4, 10.0),
        Butterworth(4, 2.0),
    )
    assert found.rotors.value is not None
    np.testing.assert_allclose(
        found.rotors.value.inertia, ur5.models[MODEL].rotor_inertias, rtol=1e-3
    )
    write_text(found.arm, tmp_path / "arm.yaml")
    fitted = load_robot(tmp_path / "arm.yaml")
    assert fitted.gravity == ur5.gravity
    for (name, own), told in zip(made.items(), (TOLD, None), strict=True):
        torques, premises = own.torques(fitted, None)
        error = torques.target["identified"] - own.signals.target_moment
        assert np.abs(error).mean() < 0.02, name
        assert premises.load.configured == told
