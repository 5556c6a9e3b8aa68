"""The documents' pictures over time: results of a step on a recording of a built study."""

import re
import textwrap
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.harness.table_pictures import BLUE, GREEN, GREY, ORANGE
from ur5lib import load
from ur5lib.finished import StudyFiles
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces, SensorWrenches
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.report.figures.house_style import BAND_STYLE, Drawing, house_style
from ur5lib.report.figures.recording_figures import packet_figure
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import causal_lowpass, zero_phase_lowpass
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.topics.thresholds.torque_thresholds import thresholds_of

MEASURED: Any = {"color": "black", "linewidth": 0.9}
DOCUMENTS = Path(__file__).parents[2] / "docs"
SLOW = 4, 2.0  # order and cut-off [Hz] of the currents' low-pass, as the default of a study
LEVEL = 2  # a line with this many points is level, and sets no limits
Span = tuple[float, float]  # s


def shown(axis: Axes, span: Span, label: str) -> None:
    """Limit an axis to a span of time and to the values in it, and label it."""
    axis.set_xlim(*span)
    drawn = [np.asarray([line.get_xdata(), line.get_ydata()], dtype=float) for line in axis.lines]
    values = np.concatenate(
        [y[(x >= span[0]) & (x <= span[1])] for x, y in drawn if len(x) > LEVEL]
    )
    low, high = np.nanmin(values), np.nanmax(values)
    axis.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
    axis.set(xlabel="time [s]", ylabel=label)


def record(folder: Path, kind: Any, recording: str, name: str = "") -> Any:
    """Return a record of a recording of a built study."""
    return load(folder).record(kind, recording, name)


def packets(folder: Path, recording: str) -> Drawing:
    """Draw the times of received frames of a recording, and the lost frames."""
    return packet_figure(record(folder, Signals, recording))


def start_stamps_against_joints(folder: Path, recording: str, span: Span) -> Drawing:
    """Draw an IMU's angular rate by start stamps and as aligned, and the rate from the joints."""
    place = folder / "recordings" / recording
    kinematics = record(folder, Kinematics, recording)
    signals, motion = record(folder, Signals, recording), record(folder, Motion, recording)
    rate = np.einsum("nij,nj->ni", kinematics.jacobian[:, 3:], motion.qd)
    turned = np.einsum("nji,nj->ni", kinematics.rotation, rate)[:, 0]
    raw = pd.read_parquet(place / "imu.parquet", columns=["time", "imu_gx"])
    with house_style(2.8) as (figure, ((axis,),)):
        axis.plot(signals.time, turned, **MEASURED, label="by the joints")
        axis.plot(
            raw["time"], raw["imu_gx"], color=ORANGE, linewidth=1, label="gyroscope, by its stamps"
        )
        axis.plot(
            signals.time, signals.gyroscope[:, 0], color=BLUE, linewidth=1, label="as aligned"
        )
        shown(axis, span, "angular rate about x [rad/s]")
        figure.legend(loc="outside upper center", frameon=False, ncols=3)
    return Drawing(figure, raw)


def low_passes(folder: Path, recording: str, span: Span, joint: int = 2) -> Drawing:
    """Draw a current as recorded, low-passed forwards, and forwards and backwards."""
    signals = record(folder, Signals, recording)
    current, rate = signals.actual_current[:, joint - 1], 1 / signals.period
    with house_style(2.8) as (figure, ((axis,),)):
        axis.plot(signals.time, current, color="#C4C4C4", linewidth=0.8, label="as recorded")
        slow = causal_lowpass(current, rate, *SLOW)
        axis.plot(signals.time, slow, color=ORANGE, label="forwards, as printed: late")
        slow = zero_phase_lowpass(current, rate, *SLOW)
        axis.plot(signals.time, slow, color=BLUE, label="forwards and backwards")
        shown(axis, span, f"current of joint {joint} [A]")
        axis.legend(frameon=False, loc="best")
    return Drawing(figure, pd.DataFrame({"time [s]": signals.time, "current [A]": current}))


def accelerations(folder: Path, recording: str, span: Span, joint: int = 3) -> Drawing:
    """Draw a simulated joint's acceleration: differences, the smoother with its band, the truth."""
    motion, signals = record(folder, Motion, recording), record(folder, Signals, recording)
    truth = pd.read_parquet(folder / "truth" / f"{recording}.parquet")
    own, std = motion.qdd[:, joint - 1], NORMAL95 * motion.qdd_std[:, joint - 1]
    slopes = np.gradient(signals.actual_qd[:, joint - 1], signals.time)
    with house_style(3.0) as (figure, ((axis,),)):
        axis.plot(
            signals.time, slopes, color="#C4C4C4", linewidth=0.8, label="differences of velocities"
        )
        axis.fill_between(motion.time, own - std, own + std, **BAND_STYLE, label="95 %")
        axis.plot(motion.time, own, color=GREEN, label="Kalman smoother")
        axis.plot(
            truth["time"], truth[f"qdd_{joint - 1}"], **MEASURED, dashes=(4, 2), label="truth"
        )
        shown(axis, span, f"acceleration of joint {joint} [rad/s²]")
        axis.legend(frameon=False, ncols=2)
    return Drawing(figure, pd.DataFrame({"time [s]": motion.time, "smoother [rad/s²]": own}))


def gate(folder: Path, recording: str, span: Span, joint: int = 2) -> Drawing:
    """Draw external torque, log-odds of contact with their threshold, and found contacts."""
    currents, forces = record(folder, Currents, recording), record(folder, Forces, recording)
    sensor = record(folder, SensorWrenches, recording, "sensor")
    contacts = pd.read_csv(folder / "tables" / "contacts.csv")
    found = contacts[(contacts["recording"] == recording) & (contacts["estimate"] == "Fmap")]
    with house_style(4.2, 3, sharex=True) as (figure, panels):
        torque, odds, size = panels[:, 0]
        torque.plot(
            forces.time,
            currents.external_torque[:, joint - 1],
            color=BLUE,
            linewidth=0.9,
            label="external torque",
        )
        torque.plot(forces.time, forces.background[:, joint - 1], color=ORANGE, label="background")
        odds.plot(forces.time, forces.log_odds["Fmap"], color=BLUE)
        odds.axhline(alarm_threshold(folder, recording), color=ORANGE, dashes=(4, 2))
        size.plot(forces.time, norm(sensor.wrench["compensated"]), **MEASURED, label="force sensor")
        size.plot(forces.time, norm(forces.wrench["Fmap"]), color=GREEN, label="MAP estimate")
        for start, end in found[["start_s", "end_s"]].to_numpy():
            for axis in (torque, odds, size):
                axis.axvspan(start, end, color=GREEN, alpha=0.12, linewidth=0)
        shown(torque, span, f"τ of joint {joint} [Nm]")
        shown(odds, span, "log-odds")
        shown(size, span, "force [N]")
        for axis in (torque, odds):
            axis.set_xlabel("")
        figure.legend(loc="outside upper center", frameon=False, ncols=4)
    return Drawing(figure, found)


def alarm_threshold(folder: Path, recording: str) -> float:
    """Return the log-odds above which the MAP estimate raises an alarm."""
    rows = pd.read_csv(folder / "tables" / "detection.csv").query("recording == @recording")
    threshold: float = rows.loc[rows["estimate"] == "Fmap", "threshold"].iloc[0]
    return threshold


def norm(wrench: Array) -> Array:
    """Return |F| (N,) [N] of wrenches (N, 6)."""
    size: Array = np.linalg.norm(wrench[:, :3], axis=1)
    return size


def live_force(folder: Path, recording: str, span: Span) -> Drawing:
    """Draw the live estimate of the force, with its state, and the sensor's force."""
    live = pd.read_parquet(folder / "recordings" / recording / "live_forces.parquet")
    sensor = record(folder, SensorWrenches, recording, "sensor")
    size = np.linalg.norm(live[["live_Fx", "live_Fy", "live_Fz"]], axis=1)
    states = {"contact": (live["contact"], GREEN), "unknown": (~live["known"], GREY)}
    with house_style(2.8) as (figure, ((axis,),)):
        axis.plot(sensor.time, norm(sensor.wrench["compensated"]), **MEASURED, label="force sensor")
        axis.plot(live["time"], size, color=BLUE, label="stated live")
        shown(axis, span, "size of the force [N]")
        low, high = axis.get_ylim()
        for name, (where, colour) in states.items():
            axis.fill_between(
                live["time"],
                low,
                high,
                where=where,
                color=colour,
                alpha=0.15,
                linewidth=0,
                label=name,
            )
        figure.legend(loc="outside upper center", frameon=False, ncols=4)
    return Drawing(figure, live)


def tare(folder: Path, plain: str, tared: str) -> Drawing:
    """Draw a slow press at rest: without and with an untouched span, and the sensor."""
    kinds = {"without": plain, "with an untouched span": tared}
    with house_style(2.8, 1, 2, sharey=True) as (figure, (panels,)):
        for axis, (name, recording) in zip(panels, kinds.items(), strict=True):
            forces, sensor = (
                record(folder, Forces, recording),
                record(folder, SensorWrenches, recording, "sensor"),
            )
            axis.plot(
                sensor.time, sensor.wrench["compensated"][:, 2], **MEASURED, label="force sensor"
            )
            value, half = forces.wrench["Fmap"][:, 2], NORMAL95 * forces.std["Fmap"][:, 2]
            axis.fill_between(forces.time, value - half, value + half, **BAND_STYLE, label="95 %")
            axis.plot(forces.time, value, color=GREEN, label="MAP estimate")
            axis.set(title=name, xlabel="time [s]")
        panels[0].set_ylabel("force along z [N]")
        panels[0].legend(frameon=False)
    return Drawing(figure, pd.DataFrame({"recording": [*kinds.values()]}))


def sensor_bias(folder: Path, recording: str) -> Drawing:
    """Draw a force sensor's reading, raw and without bias and the tool's weight."""
    sensor = record(folder, SensorWrenches, recording, "sensor")
    readings = {
        "as read, in the sensor's axes": record(folder, Signals, recording).force_sensor,
        "without bias and tool, in the base's axes": sensor.wrench["compensated"],
    }
    with house_style(2.8, 1, 2) as (figure, (panels,)):
        for axis, (title, reading) in zip(panels, readings.items(), strict=True):
            for values, name, colour in zip(
                reading[:, :3].T, "xyz", (BLUE, ORANGE, GREEN), strict=True
            ):
                axis.plot(sensor.time, values, color=colour, linewidth=0.9, label=f"F{name}")
            axis.axhline(0, color="black", linewidth=0.6)
            axis.set(title=title, xlabel="time [s]")
        panels[0].set_ylabel("force [N]")
        panels[1].legend(frameon=False, ncols=3)
    return Drawing(figure, pd.DataFrame({"recording": [recording]}))


def first_motion(folder: Path, recording: str, span: Span, joints: tuple[int, ...]) -> Drawing:
    """Draw currents from before the first motion on, as measured and as predicted with the band."""
    signals, currents = record(folder, Signals, recording), record(folder, Currents, recording)
    motion = record(folder, Motion, recording)
    with house_style(2.8, 1, len(joints)) as (figure, (panels,)):
        for axis, joint in zip(panels, joints, strict=True):
            own = currents.predicted[:, joint - 1]
            half = currents.band[:, joint - 1]
            axis.fill_between(signals.time, own - half, own + half, **BAND_STYLE, label="95 %")
            axis.plot(signals.time, signals.effort[:, joint - 1], **MEASURED, label="measured")
            axis.plot(signals.time, own, color=GREEN, label="predicted")
            begins = np.flatnonzero(
                np.ptp(motion.q[:, joint - 1]) * 1e-3
                < np.abs(motion.q[:, joint - 1] - motion.q[0, joint - 1])
            )
            axis.axvline(motion.time[begins[0]], color=GREY, linewidth=0.8, dashes=(4, 2))
            shown(axis, span, f"current of joint {joint} [A]")
        panels[0].legend(frameon=False)
    return Drawing(figure, pd.DataFrame({"time [s]": signals.time}))


def thresholds(folder: Path, robot: str) -> Drawing:
    """Draw the torque thresholds of contact, by joint and speed."""
    rows = pd.DataFrame(thresholds_of(StudyFiles(folder), robot).in_json()["by_speed"])
    speeds = dict(zip(("at rest", "slow", "fast"), (ORANGE, GREEN, BLUE), strict=True))
    with house_style(2.8) as (figure, ((axis,),)):
        for place, (name, colour) in enumerate(speeds.items()):
            own = rows.groupby("joint").nth(place)
            at = own["joint"] + 0.26 * (place - 1)
            axis.bar(at, own["upper"], 0.24, color=colour, alpha=0.4)
            axis.bar(at, own["lower"], 0.24, color=colour, label=name)
        axis.set(xlabel="joint", ylabel="external torque [Nm]")
        axis.legend(frameon=False)
    return Drawing(figure, rows)


def friction_alone(folder: Path, robot: str, joint: int) -> Drawing:
    """Return the drawing of `model.plot("friction", joint=...)`."""
    return Drawing(load(folder).model(robot).plot("friction", joint=joint), pd.DataFrame())


def of_a_paper(folder: Path, recording: str) -> Drawing:
    """Draw the same as the ten lines of docs/api.md for a recording of a study."""
    page = (DOCUMENTS / "api.md").read_text().partition("### A figure for a paper")[2]
    [lines] = re.findall(r"^ {4}import matplotlib(?:.*\n)+?(?=\n\S)", page, re.MULTILINE)
    code = textwrap.dedent(lines).replace('"mine"', repr(str(folder)))
    code = code.replace('"pushed"', repr(recording))
    known: dict[str, Any] = {}
    exec(re.sub(r"\n.*savefig.*", "", code), known)
    return Drawing(known["figure"], pd.DataFrame())
