"""Steps that compute torques do so under a recording's gravity, with what its arm carries."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.made_records import motion_of
from tests.scripts.conftest import script
from ur5lib.identification.current_samples import current_record
from ur5lib.lab.stand.controller_channels import frames
from ur5lib.lab.stand.plan import SimulatedRecording
from ur5lib.lab.stand.rig import Experiment, perform
from ur5lib.records.dynamics import Torques
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot, load_robot, robot_path
from ur5lib.tables import read_json, write_table

CYCLE, EVERY = 0.008, 8
WALL, TILTED = [0.0, -9.81, 0.0], [4.905, 0.0, -8.4957]
TOLD = Payload(mass=1.5, center_of_mass=(0.01, 0.02, 0.05), inertia=(0.002,) * 3 + (0.0,) * 3)
HIDDEN = Payload(mass=1.0, center_of_mass=(-0.02, 0.0, 0.1))
MODEL, ARM = "C+rotors", robot_path("ur5")


class Made:
    """A recording of the stand without friction and noise, as the tables of the workflow."""

    def __init__(self, robot: Robot, folder: Path, gravity: list[float], **plan: Any) -> None:
        wanted = {"friction": False, "noise": False, "seconds": 6} | plan
        wanted = {"trajectory": {"kind": "fourier", "period_s": 6, "harmonics": 8}} | wanted
        plan_of = SimulatedRecording.model_validate(wanted)
        arm, random = robot.mounted(gravity), np.random.default_rng(0)
        self.done: Experiment = perform(arm, plan_of, random)
        self.gravity, motion = gravity, self.done.motion
        sent = frames(self.done, CYCLE, None)
        told = sent.drop(columns=["sent", "kept"], errors="ignore")
        self.files = {name: f"{folder}/{name}.parquet" for name in ("signals", "motion")}
        write_table(told.assign(segment=0, interpolated=False), self.files["signals"])
        states = (motion[name][::EVERY] for name in ("q", "qd", "qdd"))
        self.motion = motion_of(sent["time"].to_numpy(), *states)
        self.motion.write(self.files["motion"])
        self.signals = Signals.read(self.files["signals"])


def torques_of(
    made: Made, folder: Path, payload: Payload | None, arm: Any = ARM
) -> tuple[Torques, Any]:
    """What compute_torques makes where the study declares a payload."""
    input = SimpleNamespace(arm=arm, **made.files)
    output = SimpleNamespace(torques=f"{folder}/torques.parquet", summary=f"{folder}/torques.json")
    declared = payload.model_dump_json() if payload else ""
    params = SimpleNamespace(gravity=made.gravity, payload=declared)
    script("compute_torques").compute_torques(input, output, params)
    return Torques.read(output.torques), read_json(output.summary)


def test_targets_are_compared_as_told_and_currents_as_carried(ur5: Robot, tmp_path: Path) -> None:
    """A wall-mounted arm whose controller was told of one payload, and that carries another too."""
    payloads = {"payload": TOLD.model_dump(), "undeclared_payload": HIDDEN.model_dump()}
    made, physical = Made(ur5, tmp_path, WALL, **payloads), TOLD.joined(HIDDEN)
    torques, summary = torques_of(made, tmp_path, physical)
    signals, motion = made.signals, made.motion
    np.testing.assert_allclose(torques.target[MODEL], signals.target_moment, atol=1e-4)
    record = current_record("", signals, motion, torques, MODEL)
    assert record is not None
    given = made.done.motion["motor_torque"][::EVERY]
    np.testing.assert_allclose(record.torque, given, atol=1e-6)
    assert np.abs(torques.payload_torque).max() > 3
    assert summary["source"] == "study"
    assert Payload(**summary["payload"]) == physical
    assert Payload(**summary["configured"]) == TOLD


@pytest.mark.parametrize(("told", "source"), [(TOLD, "rtde"), (None, "none")])
def test_what_the_channels_say_is_carried_where_the_study_is_silent(
    ur5: Robot, tmp_path: Path, told: Payload | None, source: str
) -> None:
    made = Made(ur5, tmp_path, TILTED, payload=told and told.model_dump(), seconds=2)
    torques, summary = torques_of(made, tmp_path, None)
    assert summary["source"] == source
    assert summary["payload"] == summary["configured"] == read_back(told)
    np.testing.assert_array_equal(torques.payload_torque, 0)
    given = made.done.motion["motor_torque"][::EVERY]
    np.testing.assert_allclose(torques.measured[MODEL], given, atol=1e-4)


def read_back(payload: Payload | None) -> Any:
    """As JSON has it."""
    return payload and {
        name: [*value] if isinstance(value, tuple) else value for name, value in payload
    }


def test_one_model_is_fitted_to_recordings_under_several_gravities(
    ur5: Robot, tmp_path: Path
) -> None:
    """Rotors and links of the bare arm, a payload or not; what explains one explains the others."""
    made = [
        Made(ur5, tmp_path, gravity, **plan)
        for tmp_path, gravity, plan in (
            (tmp_path / "wall", WALL, {"payload": TOLD.model_dump()}),
            (tmp_path / "tilted", TILTED, {}),
        )
    ]
    input = SimpleNamespace(
        arm=ARM,
        signals=[own.files["signals"] for own in made],
        motion=[own.files["motion"] for own in made],
        rotors=f"{tmp_path}/rotors.json",
    )
    params = SimpleNamespace(
        recordings=["wall", "tilted"], gravities=[WALL, TILTED], order=4, cutoff_hz=10.0
    )
    output = SimpleNamespace(
        rotors=input.rotors,
        arm=f"{tmp_path}/arm.yaml",
        urdf=f"{tmp_path}/arm.urdf",
        summary=f"{tmp_path}/identification.json",
    )
    script("fit_rotor_inertia").fit_rotor_inertia(input, output, params)
    inertia = read_json(output.rotors)["value"]["inertia"]
    np.testing.assert_allclose(inertia, ur5.models[MODEL].rotor_inertias, rtol=1e-3)
    script("identify_model").identify_model(input, output, params)
    fitted = load_robot(output.arm)
    assert fitted.gravity == ur5.gravity
    for own, told in zip(made, (TOLD, None), strict=True):
        torques, summary = torques_of(own, tmp_path, None, output.arm)
        error = torques.target["identified"] - own.signals.target_moment
        assert np.abs(error).mean() < 0.02
        assert (summary["configured"] is None) == (told is None)
