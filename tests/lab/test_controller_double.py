"""The double of a controller is real enough for ur_rtde's own clients, and for our recorder."""

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.entries import read_recording
from ur5lab.doubles.controller_double import ControllerDouble, Ports
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.recorder.arm_motion import ArmMotion, MotionError
from ur5lab.recorder.arm_state import identify, read_state
from ur5lab.recorder.device import DeviceLost
from ur5lab.recorder.realtime_arm import RealtimeArm
from ur5lab.recorder.rtde_arm import RtdeArm
from ur5lab.rtde_variables import columns
from ur5lib.errors import InputError
from ur5lib.stand.plan import POSTURE, Push, SimulatedRecording, Standstill
from ur5lib.timeseries.arrays import Array

for module in ("rtde_receive", "rtde_control", "dashboard_client"):
    pytest.importorskip(module, reason="ur_rtde is not installed: pip install '.[record]'")

HERE = "127.0.0.1"
PATIENCE = 30.0  # s, for a loaded machine
STILL = Standstill(kind="standstill")
SILENT = SimulatedRecording(trajectory=STILL, noise=False, payload={"mass": 1.5})
AWAY = np.add(POSTURE, [0.2, -0.1, 0.1, 0.2, 0.0, 0.3])

pytestmark = [
    pytest.mark.slow,
    pytest.mark.real_time,
    pytest.mark.usefixtures("controller_ports"),
]


@pytest.fixture(scope="module")
def ur5e(controller_ports: None) -> Iterator[ControllerDouble]:
    with ControllerDouble("ur5e", plan=SILENT) as controller:
        yield controller


@pytest.fixture
def motion(ur5e: ControllerDouble) -> Iterator[ArmMotion]:
    with ArmMotion(HERE) as motion:
        yield motion


def wait_for(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.05)


def recorded(device: RtdeArm, count: int) -> tuple[Array, Array, int]:
    """Times of arrival, samples, and how many were lost, of at least `count` samples."""
    got: list[Any] = []
    while sum(len(samples.values) for samples in got) < count:
        got.append(device.read())
    received = np.concatenate([samples.received for samples in got])
    values = np.concatenate([samples.values for samples in got])
    return received, values, sum(samples.lost for samples in got)


def column(device: RtdeArm, values: Array, name: str) -> Array:
    found = [device.columns.index(part) for part in columns(name)]
    return values[:, found[0] : found[-1] + 1]


# Recording by RTDE


@pytest.mark.parametrize("rate", [500, 125])
def test_every_package_is_recorded_with_what_is_true(ur5e: ControllerDouble, rate: int) -> None:
    device = RtdeArm(HERE, rate)
    told = device.identity
    received, values, lost = recorded(device, rate)
    device.close()
    assert (told.rate_hz, told.firmware) == (rate, "5.11.1.108318")
    assert lost == 0
    stamps = column(device, values, "timestamp")[:, 0]
    np.testing.assert_allclose(np.diff(stamps), 1 / rate, rtol=0, atol=1e-9)
    host = np.asarray(ur5e.clock.host(stamps))
    assert (received > host).all()
    for name, part in (("actual_q", "q"), ("actual_qd", "qd")):
        true = ur5e.truth.part(part, host)
        np.testing.assert_allclose(column(device, values, name), true, rtol=0, atol=1e-9)
    assert column(device, values, "payload")[0] == 1.5
    assert column(device, values, "robot_mode")[0] == 7


@pytest.mark.thorough
def test_ur_rtde_sees_what_we_record_to_the_bit(ur5e: ControllerDouble, tmp_path: Path) -> None:
    """Its recorder samples by its own clock: some rows twice, some never, each as we have it."""
    own = tmp_path / "ur_rtde.csv"
    names = ["timestamp", "actual_q", "target_q", "actual_current", "joint_temperatures"]
    program = f"""\
import time, rtde_receive
robot = rtde_receive.RTDEReceiveInterface("{HERE}")
robot.startFileRecording("{own}", {names})
time.sleep(1)
robot.stopFileRecording()
"""
    device = RtdeArm(HERE)
    recorder = subprocess.Popen([sys.executable, "-c", program])
    got = []
    while recorder.poll() is None:
        got.append(device.read().values)
    device.close()
    assert recorder.returncode == 0
    values = np.concatenate(got)
    ours = np.hstack([column(device, values, name) for name in names])
    rows = {f"{row[0]:.6f}": ",".join(f"{number:.6f}" for number in row) for row in ours}
    header, *lines = own.read_text().splitlines()
    assert header.split(",") == [part for name in names for part in columns(name)]
    whole = [line for line in lines if line.count(",") == header.count(",")]
    same = [line == rows[line.split(",")[0]] for line in whole]
    assert len(set(whole)) > 100
    assert np.mean(same) > 0.95  # the others mix two packages: its columns are read one by one


@pytest.mark.thorough
def test_outputs_that_a_controller_lacks_are_left_out(controller_ports: None) -> None:
    with ControllerDouble("ur5", ports=Ports.free()) as controller:
        device = RtdeArm(HERE, port=controller.setup.ports.rtde)
        told = device.identity
        recorded(device, 10)
        device.close()
    assert told.rate_hz == 125
    lacking = ["actual_current_as_torque", "ft_raw_wrench", "wrench_calc_from_currents"]
    lacking += ["target_gravity", "target_base_acceleration"]
    lacking += ["collision_detection_ratio", "joint_position_deviation_ratio"]
    assert told.missing == lacking
    assert not {f"{name}_0" for name in lacking} & {*device.columns}


@pytest.mark.thorough
def test_lost_packages_are_counted_and_the_newest_outputs_recorded(controller_ports: None) -> None:
    """Of an e-Series arm whose flange is pulled: the wrench from currents, environment on arm."""
    pull = Push(kind="push", link=6, start_s=0.0, seconds=8.0, force=(0.0, 30.0, 0.0))
    plan = SimulatedRecording(trajectory=STILL, noise=False, friction=False, contacts=[pull])
    options = {
        "software": (5, 26, 0, 0),
        "faults": TransmissionFaults(late=0.05, split=0.2, lost=0.1),
    }
    with ControllerDouble("ur5e", plan=plan, ports=Ports.free(), **options) as controller:
        device = RtdeArm(HERE, port=controller.setup.ports.rtde)
        _, values, lost = recorded(device, 1500)
        device.close()
        stamps = column(device, values, "timestamp")[:, 0]
        true = controller.truth.part("wrench", np.asarray(controller.clock.host(stamps)))
    assert lost == round((stamps[-1] - stamps[0]) / 0.002) + 1 - len(stamps)
    assert 75 < lost < 300
    assert device.identity.missing == []
    assert np.abs(true[:, 1]).max() > 20
    stated = column(device, values, "wrench_calc_from_currents")
    np.testing.assert_allclose(stated[500:], true[500:], rtol=0, atol=2.0)  # delayed by 30 ms
    assert column(device, values, "target_gravity")[0] == pytest.approx([0, 0, 9.82], abs=0.02)


# The realtime port


def test_the_realtime_port_is_recorded_to_the_bit(ur5e: ControllerDouble, tmp_path: Path) -> None:
    plain, device = socket.create_connection((HERE, 30003)), RealtimeArm(HERE)
    told = device.identity
    assert (told.message_bytes, told.rate_hz) == (1220, 500)
    lines, messages = [], 0
    while messages < 500:
        packets = device.read()
        messages += packets.messages
        assert packets.lost == 0
        lines += [
            f"{when:.6f},{data.hex()}"
            for when, data in zip(packets.received, packets.packets, strict=True)
        ]
    device.close()
    ours = b"".join(bytes.fromhex(line.split(",")[1]) for line in lines)
    dumped = plain.recv(len(ours), socket.MSG_WAITALL)
    plain.close()
    shift = dumped.index(ours[:1220])  # the plain socket was connected earlier
    assert dumped[shift:] == ours[: len(dumped) - shift]
    (tmp_path / "capture.csv").write_text("received_s,payload_hex\n" + "\n".join(lines) + "\n")
    entry = {"format": "realtime-stream", "folder": str(tmp_path), "file": "capture.csv"}
    table = read_recording(entry).robot.table
    assert len(table) in (messages, messages + 1)
    np.testing.assert_allclose(np.diff(table["time"]), 0.002, atol=1e-9)
    np.testing.assert_allclose(table.filter(like="actual_q_"), [POSTURE] * len(table), atol=1e-3)
    assert (table["payload"] == 1.5).all()


# The clients of ur_rtde


def test_the_dashboard_answers(ur5e: ControllerDouble) -> None:
    import dashboard_client

    dashboard = dashboard_client.DashboardClient(HERE)
    dashboard.connect()
    assert dashboard.robotmode() == "Robotmode: RUNNING"
    assert dashboard.safetymode() == "Safetymode: NORMAL"
    assert dashboard.polyscopeVersion() == "5.11.1.108318"
    assert dashboard.isInRemoteControl()
    dashboard.loadURP("study.urp")
    dashboard.play()
    wait_for(dashboard.running)
    dashboard.stop()
    assert dashboard.programState() == "STOPPED study.urp"
    dashboard.powerOff()
    assert dashboard.robotmode() == "Robotmode: POWER_OFF"
    dashboard.powerOn()
    dashboard.brakeRelease()
    assert dashboard.robotmode() == "Robotmode: RUNNING"
    dashboard.disconnect()
    assert identify(HERE) == {
        "model": "UR5",
        "firmware": "5.11.1.108318",
        "serial_number": "20260000001",
    }


@pytest.mark.thorough
def test_its_control_interface_moves_the_arm(ur5e: ControllerDouble) -> None:
    import rtde_control

    control = rtde_control.RTDEControlInterface(HERE)
    assert control.moveJ(AWAY.tolist(), 1.5, 3.0)
    np.testing.assert_allclose(read_state(HERE).q, AWAY, atol=2e-3)
    assert control.isJointsWithinSafetyLimits(AWAY.tolist())
    assert not control.isJointsWithinSafetyLimits([7.0] * 6)
    wait_for(lambda: bool(control.getStepTime() == 0.002))  # it answers with the next package
    assert control.setPayload(2.0, [0.0, 0.0, 0.05])
    np.testing.assert_allclose(control.getTCPOffset(), 0)
    assert control.speedJ([0.1, 0, 0, 0, 0, 0], 1.0)
    wait_for(lambda: read_state(HERE).qd[0] > 0.09)
    assert control.speedStop()
    path = [[*POSTURE, 1.0, 2.0, 0.0], [*AWAY, 1.0, 2.0, 0.0], [*POSTURE, 1.0, 2.0, 0.0]]
    assert control.moveJ(path)
    np.testing.assert_allclose(read_state(HERE).q, POSTURE, atol=2e-3)
    assert not control.moveL([0.3, 0.3, 0.3, 0, 0, 0])  # not emulated: its program ends
    control.disconnect()


@pytest.mark.thorough
def test_plain_urscript_moves_the_arm(ur5e: ControllerDouble) -> None:
    program = f"""\
def there_and_back():
  textmsg("moving")
  movej({AWAY.tolist()}, a=3.0, v=1.5)
  sleep(0.1)
  movej({list(POSTURE)}, 3.0, 1.5)
end
"""
    with socket.create_connection((HERE, 30002)) as port:
        port.sendall(program.encode())
        wait_for(lambda: bool(np.allclose(read_state(HERE).q, AWAY, atol=5e-3)))
        wait_for(lambda: not read_state(HERE).program_runs)
        np.testing.assert_allclose(read_state(HERE).q, POSTURE, atol=2e-3)
        port.sendall(f"movej({AWAY.tolist()}, a=1.4, v=1.05)\n".encode())
        wait_for(lambda: abs(read_state(HERE).qd[0]) > 0.05)
        port.sendall(b"stopj(5)\n")
        wait_for(lambda: not read_state(HERE).program_runs)
        assert np.abs(read_state(HERE).qd).max() < 0.01


# Motion of the recorder


def test_the_arm_follows_a_streamed_trajectory(ur5e: ControllerDouble, motion: ArmMotion) -> None:
    motion.move_through(np.array([POSTURE]), 1.5, 3.0)
    time_s = np.arange(0, 2, 0.002)
    wave = 0.1 * (1 - np.cos(np.pi * time_s))
    started = time.monotonic()
    motion.stream(POSTURE + wave[:, None] * [1, 0, 0, 0, 0, 1], 500.0)
    when = started + np.linspace(0, 2.4, 500)
    moved = ur5e.truth.part("q", when) - POSTURE
    assert 0.18 < moved[:, 0].max() < 0.21
    assert np.abs(moved[:, 1:5]).max() < 0.01
    np.testing.assert_allclose(moved[-1], 0, atol=5e-3)


@pytest.mark.thorough
@pytest.mark.parametrize("streams", [False, True])
def test_a_motion_is_stopped_from_another_thread(motion: ArmMotion, streams: bool) -> None:
    assert motion.move_through(np.array([POSTURE]), 1.5, 3.0)
    threading.Timer(0.5, motion.stop).start()
    if streams:
        assert not motion.stream(np.linspace(POSTURE, AWAY, 5000), 500.0)
    else:
        assert not motion.move_through(np.array([AWAY]), 0.05, 0.1)
    wait_for(lambda: bool(np.abs(read_state(HERE).qd).max() < 0.002))
    assert 0 < read_state(HERE).q[0] - POSTURE[0] < 0.15
    assert not motion.move_through(np.array([AWAY]), 1.0, 2.0)


def test_the_arm_stops_when_the_program_that_moves_it_is_killed(ur5e: ControllerDouble) -> None:
    program = f"""\
import numpy as np
from ur5lab.recorder.arm_motion import ArmMotion
with ArmMotion("{HERE}") as motion:
    motion.move_through(np.array([{list(POSTURE)}]), 1.0, 2.0)
    motion.move_through(np.array([[1.5, *{list(POSTURE)[1:]}]]), 0.1, 0.5)
"""
    mover = subprocess.Popen([sys.executable, "-c", program])
    wait_for(lambda: read_state(HERE).qd[0] > 0.08)
    mover.kill()
    mover.wait()
    wait_for(lambda: not read_state(HERE).program_runs)
    wait_for(lambda: bool(np.abs(read_state(HERE).qd).max() < 0.002))
    assert read_state(HERE).q[0] < 1.2


@pytest.mark.thorough
def test_its_control_interface_knows_freedrive(ur5e: ControllerDouble) -> None:
    import rtde_control

    control = rtde_control.RTDEControlInterface(HERE)
    assert control.freedriveMode()
    assert control.getFreedriveStatus() == 0
    assert control.endFreedriveMode()
    assert control.teachMode()
    assert control.endTeachMode()
    assert read_state(HERE).ready
    assert not control.freedriveMode([1, 0, 0, 0, 0, 0])  # not emulated: its program ends
    control.disconnect()


# Faults


@pytest.mark.thorough
def test_a_protective_stop_is_seen(ur5e: ControllerDouble, motion: ArmMotion) -> None:
    ur5e.ask("stop")
    wait_for(lambda: read_state(HERE).safety_mode == "protective stop")
    assert not read_state(HERE).ready
    with pytest.raises(MotionError, match="safety mode protective stop, program stopped"):
        motion.move_through(np.array([AWAY]), 1.0, 2.0)
    import dashboard_client

    dashboard = dashboard_client.DashboardClient(HERE)
    dashboard.connect()
    dashboard.unlockProtectiveStop()
    dashboard.disconnect()
    wait_for(lambda: read_state(HERE).ready)
    motion.move_through(np.array([POSTURE]), 1.0, 2.0)


@pytest.mark.thorough
def test_a_push_is_in_the_truth(ur5e: ControllerDouble) -> None:
    start = ur5e.ask("time") + 0.2
    ur5e.ask("touch", Push(kind="push", force=(0.0, 20.0, 0.0), start_s=start, seconds=1.0))
    middle = float(ur5e.clock.host(ur5e.setup.clock.offset_s + start + 0.5))
    wait_for(lambda: ur5e.truth.latest() > middle + 0.1)
    np.testing.assert_allclose(ur5e.truth.part("wrench", middle)[:3], [0, 20, 0], atol=0.1)
    felt = ur5e.truth.part("force_sensor", np.array([middle - 0.6, middle]))
    assert np.linalg.norm(felt[1, :3] - felt[0, :3]) == pytest.approx(20, abs=0.5)
    assert np.linalg.norm(ur5e.truth.part("imu", middle)[:3]) == pytest.approx(9.81, abs=0.1)


@pytest.mark.thorough
@pytest.mark.parametrize("make", [RtdeArm, RealtimeArm])
def test_a_controller_that_dies_is_lost_and_may_come_back(
    ur5e: ControllerDouble, make: type[RtdeArm] | type[RealtimeArm]
) -> None:
    device = make(HERE)
    device.read()
    ur5e.ask("die")
    with pytest.raises(DeviceLost, match=r"127\.0\.0\.1"):
        read_until_lost(device)
    device.close()
    with pytest.raises(InputError, match=r"answers.* at 127\.0\.0\.1, port \d+ .*switched on"):
        make(HERE)
    ur5e.ask("come back")
    device = make(HERE)
    device.read()
    device.close()


@pytest.mark.thorough
@pytest.mark.parametrize("make", [RtdeArm, RealtimeArm])
def test_a_silent_controller_is_lost(
    ur5e: ControllerDouble, make: type[RtdeArm] | type[RealtimeArm]
) -> None:
    device = make(HERE)
    ur5e.ask("freeze", True)
    with pytest.raises(DeviceLost, match="has sent nothing for 1 s"):
        read_until_lost(device)
    ur5e.ask("freeze", False)
    device.close()


def read_until_lost(device: RtdeArm | RealtimeArm) -> None:
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        device.read()


@pytest.mark.thorough
def test_a_motion_ends_when_its_controller_dies(ur5e: ControllerDouble) -> None:
    with ArmMotion(HERE) as motion:
        threading.Timer(0.5, ur5e.ask, ["die"]).start()
        with pytest.raises(MotionError, match=r"127\.0\.0\.1"):
            motion.move_through(np.array([AWAY, POSTURE] * 10), 0.2, 0.5)
    ur5e.ask("come back")


@pytest.mark.thorough
def test_a_taken_port_is_said(ur5e: ControllerDouble) -> None:
    with (
        pytest.raises(InputError, match=r"port 30004 of 127\.0\.0\.1 is taken"),
        ControllerDouble("ur5e"),
    ):
        pass
