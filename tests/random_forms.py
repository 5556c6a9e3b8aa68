"""Logs of random form: arm, names, units, clock, layout, file, and what is beside the motion."""

import gzip
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

from tests.importing.test_import_cases import driven, motion, pushes
from tests.robots.test_from_urdf import made_up, saved
from tests.stored_files import write_bag
from ur5lib.commands.described import describe_urdf
from ur5lib.importing.contents import UserStatement
from ur5lib.robots.description import Robot, load_robot, robot_names, robot_path
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.timeseries.arrays import Array

SEVEN, SERVOS = "seven", "servos"  # made up: a described arm that senses torque, one without
UR_JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
MOTORS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
BY_NAME = (2, 1, 0, 3, 4, 5)  # UR's joints in the order of their names
NAMES = {  # of a joint's column of q, qd, a current, a torque, the target of q
    "rtde": (
        *("actual_q_{k}", "actual_qd_{k}", "actual_current_{k}"),
        *("actual_current_as_torque_{k}", "target_q_{k}"),
    ),
    "numbered": ("q{n}", "dq{n}", "i{n}", "tau{n}", "q_ref{n}"),
    "ros": (
        *("{joint}_position", "{joint}_velocity", "{joint}_current", "{joint}_effort"),
        "{joint}_position_command",
    ),
    "rostopic": (
        *("field.position{k}", "field.velocity{k}", "field.current{k}", "field.effort{k}"),
        "field.desired.positions{k}",
    ),
    "plotjuggler": (
        *("/joint_states/{joint}/position", "/joint_states/{joint}/velocity"),
        *("/joint_states/{joint}/current", "/joint_states/{joint}/effort"),
        "/controller/desired/positions[{k}]",
    ),
    "libfranka": ("q[{k}]", "dq[{k}]", "current[{k}]", "tau_J[{k}]", "q_d[{k}]"),
    "kinova": (
        *("actuator_{n}_position", "actuator_{n}_velocity", "actuator_{n}_current_motor"),
        *("actuator_{n}_torque", "actuator_{n}_command_position"),
    ),
    "doosan": (
        *("actual_joint_position_{k}", "actual_joint_velocity_{k}", "motor_current_{k}"),
        *("actual_joint_torque_{k}", "target_joint_position_{k}"),
    ),
    "matlab": ("q_{n}", "qDot_{n}", "current_{n}", "tau_{n}", "qDes_{n}"),
    "polling": ("q_{k}", "qd_{k}", "i_{k}", "torque_{k}", "tq_{k}"),
    "panel": ("J{n} Position", "J{n} Speed", "J{n} Current", "J{n} Torque", "J{n} Setpoint"),
    "lerobot": ("{joint}.pos", "{joint}.vel", "{joint}.current", "{joint}.torque", "{joint}.goal"),
    "bare": ("joint{n}", "joint{n}_speed", "joint{n}_amps", "joint{n}_torque", "joint{n}_goal"),
    "axes": ("A{n}", "A{n} Speed", "A{n} Current", "A{n} Torque", "A{n} Setpoint"),
    "none": ("", "", "", "", ""),
}
CLOCKS = (
    *("s", "s", "ms", "us", "ns epoch", "epoch", "whole seconds", "packets", "dates"),
    *("row numbers", "none", "two clocks", "last"),
)
KINDS = (
    *("csv", "csv", "csv", "csv", "csv.gz", "tsv", "txt", "parquet", "lists", "npz", "mat", "h5"),
    *("bag", "db3", "mcap", "folder"),
)
TEXTS = {"csv": ",", "csv.gz": ",", "tsv": "\t", "txt": " "}
WRENCHES = {  # names of force and moment, along x, y, z
    "ft_fx": ("ft_f{}", "ft_t{}"),
    "Fx": ("F{}", "T{}"),
    "force_x": ("force_{}", "torque_{}"),
    "wrench_force_x": ("wrench_force_{}", "wrench_torque_{}"),
    "wrench.force.x": ("/wrench/wrench.force.{}", "/wrench/wrench.torque.{}"),
}
IN_AMPERES = ("A", "mA", "counts", "rectified")
EXTRAS = (
    *("gripper", "mode", "text", "constant", "frozen torques", "denormal efforts", "external"),
    *("gravity", "accelerations", "temperatures", "target", "pose", "twice", "unnamed"),
)


@dataclass
class RandomLog:
    """A log as it is written, and what is true of it.

    form: what was drawn; quantities: names of the columns of each; channels: (N, k) in SI units, in
    the arm's order, by RTDE's names; table: the file's columns; effort: what was measured, (N, k)
    [A, Nm], in whatever unit the file has it, None where it has none or sizes alone.
    """

    form: dict[str, str]
    arm: Robot | None
    time: Array
    told: UserStatement
    channels: dict[str, Array] = field(default_factory=dict)
    quantities: dict[str, list[str]] = field(default_factory=dict)
    table: dict[str, Any] = field(default_factory=dict)
    path: Path = Path()
    pushed: bool = False
    effort: Array | None = None

    def add(self, quantity: str, names: list[str], rows: Array) -> None:
        """Add columns of a quantity, (N, k) as the file has them; each name once."""
        names = [name or f"nameless {len(self.table) + k}" for k, name in enumerate(names)]
        if not {*names} & {*self.table}:
            self.quantities[quantity] = names
            self.table |= dict(zip(names, np.asarray(rows).T, strict=True))


def drawn(seed: int, folder: Path) -> RandomLog:
    """A log of random form in a folder, in which its arm is described where none is known."""
    random = np.random.default_rng(seed)
    form = _form(random)
    arm = _arm(form["arm"], folder, random)
    rate = float(random.choice([25.0, 43.5, 100.0, 125.0]))
    time = np.arange(0, 15, 1 / rate)
    name = form["arm"] if arm is None else arm.name
    stated = arm is not None and (form["names"] == "none" or random.random() < 0.7)
    has_clock = form["clock"] not in ("none", "row numbers")
    told_rate = None if has_clock or random.random() < 0.5 else rate
    log = RandomLog(form, arm, time, UserStatement(name if stated else "", rate=told_rate))
    form |= {"told": "arm" if stated else "nothing"}
    _add_motion(log, random)
    for extra in form["extras"].split(", "):
        if extra:
            EXTRA_COLUMNS[extra](log, random)
    _add_wrench(log, random)
    _arrange(log, random)
    _add_clock(log, rate, random)
    log.path = WRITERS[form["kind"]](log, folder / f"run{seed}", random)
    return log


def _form(random: np.random.Generator) -> dict[str, str]:
    def one(*options: str) -> str:
        return str(random.choice(options))

    arm = one(*["ur"] * 7, SEVEN, SEVEN, SERVOS)
    by_motor = arm == SERVOS
    numbered = [*NAMES][:1] + [name for name in NAMES if "{joint}" not in NAMES[name][0]]
    names = "lerobot" if by_motor else one(*(NAMES if arm == "ur" else numbered[1:]))
    if arm == "ur" and names == "lerobot":
        names = "ros"
    kind = one(*(KINDS[:12] if by_motor or names in ("none", "plotjuggler") else KINDS))
    if kind in ("bag", "db3", "mcap", "folder"):
        names = one("named bag", "named bag", "nameless bag") if arm == "ur" else "nameless bag"
    if names == "none":
        kind = one("csv", "csv.gz", "tsv")
    is_text, is_bag = kind in TEXTS, "bag" in names
    of_ur = ("A", "A", "mA", "counts", "Nm", "permille", "percent", "motors")
    efforts = ("Nm", "Nm", "none") if arm == SEVEN else of_ur
    effort = "load" if by_motor else one(*efforts, *([] if arm == SEVEN else ["rectified"]))
    layouts = ["blocks"] * 3 + (["by joint", "sparse", "cells", "transposed"] if is_text else [])
    layout = one("blocks", "by joint") if by_motor or not is_text else one(*layouts)
    layout = "blocks" if names == "none" and layout != "transposed" else layout
    count = int(random.integers(0, 4))
    return {
        "arm": arm, "names": names, "kind": kind, "effort": effort,
        "layout": "blocks" if kind not in TEXTS and kind != "parquet" else layout,
        "header": one("plain", "title", "comments", "units", "unit row") if is_text else "plain",
        "angle": "rad" if is_bag else ("deg" if by_motor else one("rad", "rad", "deg")),
        "wrap": one("", "", "", "360", "pi") if arm == "ur" else "",
        "sign": one("as usual", "as usual", "as usual", "opposite", "one turned"),
        "order": one("base to wrist", "base to wrist", "by name") if arm == "ur" else "",
        "clock": one("s", "epoch") if is_bag else one(*CLOCKS),
        "velocities": one("yes", "yes", "yes", "no"),
        "wrench": one(*[""] * 3, *WRENCHES) if arm == "ur" and not is_bag else "",
        "axes": one("flange", "flange", "base"), "touched": one("pushed", "free"),
        "extras": "" if is_bag else ", ".join(random.choice(EXTRAS, count, replace=False)),
    }  # fmt: skip


def _arm(kind: str, folder: Path, random: np.random.Generator) -> Robot | None:
    if kind == SERVOS:
        return None
    if kind == SEVEN:
        describe_urdf(saved(made_up(7), folder), None, None, SEVEN)
        return load_robot(str(folder / "robots" / f"{SEVEN}.yaml"))
    urs = [name for name in robot_names() if name.startswith("ur")]
    return load_robot(robot_path(str(random.choice(urs))))


@cache
def _joint_names(count: int) -> tuple[str, ...]:
    return {6: UR_JOINTS, 5: MOTORS}.get(count, tuple(f"joint{k + 1}" for k in range(count)))


def _add_motion(log: RandomLog, random: np.random.Generator) -> None:
    """Positions, velocities, and efforts with which they agree."""
    form, count = log.form, {SEVEN: 7, SERVOS: 5}.get(log.form["arm"], 6)
    q, qd, qdd = _motion(log, count, random)
    log.pushed = bool(form["wrench"]) and form["touched"] == "pushed"
    wrench = pushes(log.time, random) if log.pushed else 0.02 * random.normal(size=(len(q), 6))
    efforts = _efforts(log, q, qd, qdd, wrench if log.pushed else None, random)
    log.channels = {"actual_q": q} | ({"actual_qd": qd} if form["velocities"] == "yes" else {})
    log.channels |= {"qdd": qdd, "wrench": wrench}
    turn = np.array(
        [-1.0 if form["sign"] == "one turned" and k == 2 else 1.0 for k in range(count)]
    )
    sign = -1.0 if form["sign"] == "opposite" else turn
    unit = 180 / np.pi if form["angle"] == "deg" else 1.0
    whole = 2 * np.pi
    wrapped = {"360": q % whole, "pi": (q + np.pi) % whole - np.pi}.get(form["wrap"], q)
    _add_joints(log, "q", unit * wrapped)
    if form["velocities"] == "yes":
        _add_joints(log, "qd", unit * qd)
    if form["effort"] == "load":
        log.add("load", [f"{motor}.load" for motor in MOTORS], 100 * qd)
    elif form["effort"] != "none":
        amperes, torque, most = efforts
        in_file = {
            "A": amperes, "mA": 1e3 * amperes, "counts": amperes / 2.69e-3, "Nm": torque,
            "permille": 1e3 * torque / most, "percent": 100 * torque / most,
            "motors": torque / 101, "rectified": np.abs(amperes) * sign,
        }[form["effort"]]  # fmt: skip
        in_amperes = form["effort"] in IN_AMPERES
        _add_joints(log, "i" if in_amperes else "tau", sign * in_file)
        if form["effort"] != "rectified":
            log.effort = amperes if in_amperes else torque
        if form["effort"] in ("A", "mA"):
            log.channels["actual_current"] = amperes
        elif form["effort"] == "Nm":
            its = "actual_current_as_torque" if form["arm"] == "ur" else "actual_torque"
            log.channels[its] = torque


def _motion(log: RandomLog, count: int, random: np.random.Generator) -> tuple[Array, Array, Array]:
    if log.form["arm"] == "ur" and log.arm:
        q, qd, qdd = motion(log.arm, log.time, random)
        if log.form["wrap"]:  # some joints swing about the place where the angle leaps
            q = q + np.where(random.random(6) < 0.5, np.pi, 0.0) * (log.form["wrap"] == "pi")
        return q, qd, qdd
    rates = random.uniform(0.5, 2.0, (2, count))
    phase, size = random.uniform(0, 6, (2, count)), random.uniform(0.1, 0.6, (2, count))
    angle = log.time[:, None, None] * rates + phase
    parts = size * np.sin(angle), size * rates * np.cos(angle), -size * rates**2 * np.sin(angle)
    q, qd, qdd = (part.sum(axis=1) for part in parts)
    return q + random.normal(0, 1e-5, q.shape), qd + random.normal(0, 1e-3, q.shape), qdd


def _efforts(
    log: RandomLog, q: Array, qd: Array, qdd: Array, wrench: Array | None, random: Any
) -> tuple[Array, Array, Array]:
    """Currents [A], torques [Nm] of the joints, and the largest torques."""
    if log.arm is None:
        return qd, qd, np.ones(5)
    if log.form["arm"] == SEVEN:
        sensed = gravity_torque(log.arm, log.arm.chosen_model, q) + 0.05 * qdd
        return sensed, sensed + 0.02 * random.normal(size=q.shape), np.full(7, 50.0)
    made = driven(log.arm, q, qd, qdd, wrench, random)
    most = np.array([log.arm.motor(joint).torque_max for joint in log.arm.joint_numbers])
    return made["actual_current"], made["actual_current_as_torque"], most


def _add_joints(log: RandomLog, quantity: str, rows: Array) -> None:
    """Add a column for each joint, in the order and under the names of the form."""
    form, count = log.form, rows.shape[1]
    order = BY_NAME if form["order"] == "by name" and count == 6 else range(count)
    place = ("q", "qd", "i", "tau", "target").index(quantity)
    pattern = NAMES.get(form["names"], ("position", "velocity", "effort", "effort", "target"))[
        place
    ]
    unit = {"q": form["angle"], "qd": f"{form['angle']}/s", "target": form["angle"]}.get(
        quantity, {"A": "A", "mA": "mA", "Nm": "Nm", "percent": "%"}.get(form["effort"], "")
    )
    tail = f" [{unit}]" if form["header"] == "units" and unit and pattern else ""
    joints = _joint_names(count)
    names = [pattern.format(k=k, n=k + 1, joint=joints[j]) for k, j in enumerate(order)]
    one_name = len({*names}) == 1 and bool(pattern)
    names = [f"{pattern}_{k}" for k in range(count)] if one_name else names
    log.add(quantity, [f"{name}{tail}" if name else "" for name in names], rows[:, [*order]])
    if "{joint}" in pattern and quantity in log.quantities:  # the account has the arm's order
        its = log.quantities[quantity]
        log.quantities[quantity] = [its[[*order].index(joint)] for joint in range(count)]


def _name(log: RandomLog, name: str) -> str:
    return "" if log.form["names"] == "none" else name


def _gripper(log: RandomLog, random: np.random.Generator) -> None:
    name = "gripper.pos" if log.form["names"] == "lerobot" else "gripper_position"
    log.add("gripper", [_name(log, name)], np.clip(0.5 + np.sin(log.time), 0, 1)[:, None])


def _mode(log: RandomLog, random: np.random.Generator) -> None:
    log.add("mode", [_name(log, "robot_mode")], np.where(log.time > 5, 7.0, 5.0)[:, None])


def _text(log: RandomLog, random: np.random.Generator) -> None:
    if log.form["kind"] in TEXTS and log.form["layout"] == "blocks" and _name(log, "x"):
        log.add("text", ["program_state"], np.full((len(log.time), 1), "RUNNING"))


def _constant(log: RandomLog, random: np.random.Generator) -> None:
    log.add("constant", [_name(log, "speed_scaling")], np.ones((len(log.time), 1)))


def _frozen(log: RandomLog, random: np.random.Generator) -> None:
    wide = np.tile(np.arange(1.0, 1 + log.channels["actual_q"].shape[1]), (len(log.time), 1))
    log.add("frozen", [_name(log, f"motor_torque_{k}") for k in range(wide.shape[1])], wide)


def _denormal(log: RandomLog, random: np.random.Generator) -> None:
    rows = np.full_like(log.channels["actual_q"], -5.4e-310)
    log.add("denormal", [_name(log, f"effort_{k}") for k in range(rows.shape[1])], rows)


def _external(log: RandomLog, random: np.random.Generator) -> None:
    rows = 0.3 * random.normal(size=log.channels["actual_q"].shape).cumsum(axis=0) / 10
    log.add("external", [_name(log, f"external_torque_{k}") for k in range(rows.shape[1])], rows)


def _gravity(log: RandomLog, random: np.random.Generator) -> None:
    if log.arm:
        rows = gravity_torque(log.arm, log.arm.chosen_model, log.channels["actual_q"])
        log.add("gravity", [_name(log, f"gravity_torque_{k}") for k in range(rows.shape[1])], rows)


def _accelerations(log: RandomLog, random: np.random.Generator) -> None:
    rows = log.channels["qdd"]
    name = "qDDot" if log.form["names"] == "matlab" else "joint_acceleration"
    log.add("qdd", [_name(log, f"{name}_{k}") for k in range(rows.shape[1])], rows)


def _temperatures(log: RandomLog, random: np.random.Generator) -> None:
    rows = 30 + np.outer(log.time, np.linspace(0.01, 0.02, log.channels["actual_q"].shape[1]))
    log.add("temperatures", [_name(log, f"joint_temp_{k}") for k in range(rows.shape[1])], rows)
    if log.quantities.get("temperatures"):
        log.channels["joint_temperatures"] = rows


def _target(log: RandomLog, random: np.random.Generator) -> None:
    unit = 180 / np.pi if log.form["angle"] == "deg" else 1.0
    log.channels["target_q"] = log.channels["actual_q"] + 1e-3
    if not log.form["wrap"]:
        _add_joints(log, "target", unit * log.channels["target_q"])


def _pose(log: RandomLog, random: np.random.Generator) -> None:
    if log.form["arm"] == "ur" and log.arm:
        flange = link_frames(log.arm, log.channels["actual_q"])[1][:, -1]
        rows = np.hstack([flange, np.zeros_like(flange)])
        name = "tcp" if log.form["names"] == "polling" else "actual_TCP_pose"
        log.add("pose", [_name(log, f"{name}_{k}") for k in range(6)], rows)
        log.channels["actual_TCP_pose"] = rows


def _twice(log: RandomLog, random: np.random.Generator) -> None:
    log.form["twice"] = "yes" if log.form["kind"] in TEXTS and _name(log, "x") else ""


def _unnamed(log: RandomLog, random: np.random.Generator) -> None:
    marked = log.form["kind"] in TEXTS and log.form["kind"] != "txt"
    log.form["unnamed"] = "yes" if marked and _name(log, "x") else ""


EXTRA_COLUMNS: Mapping[str, Callable[[RandomLog, np.random.Generator], None]] = dict(
    zip(
        EXTRAS,
        (
            *(_gripper, _mode, _text, _constant, _frozen, _denormal, _external, _gravity),
            *(_accelerations, _temperatures, _target, _pose, _twice, _unnamed),
        ),
        strict=True,
    )
)


def _add_wrench(log: RandomLog, random: np.random.Generator) -> None:
    """The wrench of the surroundings on the arm, in the flange's or the base's axes."""
    if not log.form["wrench"] or log.arm is None:
        return
    wrench = -log.channels["wrench"]
    if log.form["axes"] == "flange":
        rotation = link_frames(log.arm, log.channels["actual_q"])[0][:, -1]
        wrench = np.einsum("nji,nkj->nki", rotation, wrench.reshape(-1, 2, 3)).reshape(-1, 6)
        log.channels["ft_f"], log.channels["ft_t"] = wrench[:, :3], wrench[:, 3:]
    else:
        on_arm = 1.0 if log.arm.wrist_sensor else -1.0
        log.channels["actual_TCP_force"] = on_arm * wrench
    names = [part.format(axis) for part in WRENCHES[log.form["wrench"]] for axis in "xyz"]
    log.add("wrench", [_name(log, name) for name in names], wrench)


def _arrange(log: RandomLog, random: np.random.Generator) -> None:
    """Order the columns by joint, or shuffle the quantities."""
    blocks = [*log.quantities.values()]
    if log.form["names"] == "none":
        blocks = [names for names in blocks if len(names) == len(log.quantities["q"])]
    order = random.permutation(len(blocks))
    if log.form["layout"] == "by joint":
        wide = [names for names in blocks if len(names) == len(log.quantities["q"])]
        rest = [names for names in blocks if len(names) != len(log.quantities["q"])]
        blocks = [[name for joint in zip(*wide, strict=True) for name in joint], *rest]
        order = np.arange(len(blocks))
    kept = {name: log.table[name] for k in order for name in blocks[k]}
    log.quantities = {q: names for q, names in log.quantities.items() if {*names} <= {*kept}}
    log.table = kept


def _add_clock(log: RandomLog, rate: float, random: np.random.Generator) -> None:
    clock, time = log.form["clock"], log.time
    name = {"libfranka": "time", "plotjuggler": "__time", "lerobot": "timestamp"}.get(
        log.form["names"], str(random.choice(["time", "t", "timestamp", "Time", "stamp"]))
    )
    per_packet = 10
    count = -(-len(time) // per_packet)
    packets = np.repeat(time[::per_packet], per_packet) + 1e-5 * np.tile(np.arange(10), count)
    stamps: Any = {
        "ms": 1e3 * time, "us": 1e6 * time, "ns epoch": np.round(1e9 * (1.7e9 + time)),
        "epoch": 1.7e9 + time, "whole seconds": np.floor(1.7e9 + time),
        "packets": packets[: len(time)],
        "dates": pd.to_datetime((1.7e9 + time) * 1e9).strftime("%Y-%m-%d %H:%M:%S.%f").to_numpy(),
    }.get(clock, time)  # fmt: skip
    if clock == "ns epoch":
        stamps = stamps.astype(np.int64)
    if clock == "dates" and log.form["kind"] not in TEXTS:
        stamps = 1.7e9 + time
    if clock == "row numbers":
        name, stamps = "ID", np.arange(len(time))
    if clock == "none":
        return
    own = {name: stamps}
    if clock == "two clocks":
        own |= {"host_time": 1.7e9 + time + 0.3 / rate * random.random(len(time)).cumsum() ** 0.5}
    log.table = log.table | own if clock == "last" else own | log.table
    log.quantities |= {f"clock {name}": [name] for name in own}


# Files


def _frame(log: RandomLog) -> pd.DataFrame:
    return pd.DataFrame({name: np.asarray(column) for name, column in log.table.items()})


def _write_text(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    """A delimited table with its header, as the layout has it."""
    form, mark = log.form, TEXTS[log.form["kind"]]
    frame, names = _frame(log), [*log.table]
    if form["kind"] == "csv" and random.random() < 0.3:
        mark = ";"
    if any(mark in n for n in names) or "dates" in form["clock"] or "cells" in form["layout"]:
        mark = ";"
    if form["layout"] == "sparse":
        frame = _sparse(log, frame)
    elif form["layout"] == "cells":
        frame = _in_cells(log, frame)
    path = path.with_name(f"{path.name}.{form['kind']}")
    header = form["names"] != "none"
    if form["layout"] == "transposed":
        frame.T.to_csv(path, sep=mark, index=header, header=False)
        return path
    first = {"title": "Log of robot 7, cell 3\n\n", "comments": "# a log\n# of a robot\n"}
    text = first.get(form["header"], "") if header else ""
    titles = [*frame.columns]
    if form.get("twice") and form["layout"] == "blocks":
        frame = pd.concat([frame, frame[titles[-1:]]], axis=1)
        titles.append(titles[-1])
    if form["header"] == "unit row" and header and form["layout"] == "blocks":
        units = mark.join("-" for _ in titles)
        lines = frame.to_csv(sep=mark, index=False, header=False)
        body = mark.join(titles) + "\n" + units + "\n" + lines
    else:
        decimal = "," if mark == ";" and random.random() < 0.3 else "."
        index = bool(form.get("unnamed"))
        body = frame.to_csv(
            sep=mark, index=index, header=titles if header else False, decimal=decimal
        )
    data = (text + body).encode()
    if form["kind"] == "csv.gz":
        data = gzip.compress(data)
    path.write_bytes(data)
    return path


def _sparse(log: RandomLog, frame: pd.DataFrame) -> pd.DataFrame:
    """Each quantity in rows of its own, as PlotJuggler exports topics."""
    clocks = [names[0] for q, names in log.quantities.items() if q.startswith("clock")]
    parts = [names for q, names in log.quantities.items() if not q.startswith("clock")]
    if len(clocks) != 1 or log.form["clock"] not in ("s", "epoch", "last"):
        return frame
    rows = []
    for k, names in enumerate(parts):
        part = frame[[*clocks, *names]].copy()
        part[clocks[0]] = part[clocks[0]] + 1e-4 * k
        rows.append(part)
    return pd.concat(rows).sort_values(clocks[0])[[*frame.columns]]


def _in_cells(log: RandomLog, frame: pd.DataFrame) -> pd.DataFrame:
    """Each quantity of joints as a list in one cell."""
    cells = dict[str, Any]()
    for quantity, names in log.quantities.items():
        if len(names) > 1:
            stem = _stem(log, quantity)
            cells[stem] = [str([float(v) for v in row]) for row in frame[names].to_numpy()]
            log.quantities[quantity] = [f"{stem}_{k}" for k in range(len(names))]
        else:
            cells[names[0]] = frame[names[0]]
    return pd.DataFrame(cells)


def _stem(log: RandomLog, quantity: str) -> str:
    """The name of a quantity as an array has it."""
    its = {
        "rtde": ("actual_q", "actual_qd", "actual_current", "actual_current_as_torque", "target_q"),
        "matlab": ("q", "qDot", "current", "tau", "qDes"),
        "libfranka": ("q", "dq", "current", "tau_J", "q_d"),
        "doosan": (
            *("actual_joint_position", "actual_joint_velocity", "motor_current"),
            *("actual_joint_torque", "target_joint_position"),
        ),
        "polling": ("q", "qd", "i", "torque", "tq"),
        "lerobot": ("observation.state", "observation.velocity", "current", "torque", "action")
        if log.form["kind"] == "lists"
        else ("position", "velocity", "current", "torque", "action"),
    }.get(log.form["names"], ("position", "velocity", "current", "effort", "target_position"))
    places = ("q", "qd", "i", "tau", "target")
    others = {"external": "external_torque", "gravity": "gravity_torque", "qdd": "qDDot"}
    others |= {"frozen": "motor_torque", "denormal": "joint_effort", "wrench": "wrench"}
    others |= {"temperatures": "joint_temperatures", "pose": "actual_TCP_pose", "load": "load"}
    return its[places.index(quantity)] if quantity in places else others.get(quantity, quantity)


def _arrays(log: RandomLog) -> dict[str, Array]:
    arrays = dict[str, Array]()
    for quantity, names in [*log.quantities.items()]:
        values = np.stack([np.asarray(log.table[name]) for name in names], axis=1)
        name = names[0] if len(names) == 1 else _stem(log, quantity)
        arrays[name] = values[:, 0] if len(names) == 1 else values
        log.quantities[quantity] = [name]
    return arrays


def _write_parquet(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    _frame(log).to_parquet(path.with_suffix(".parquet"))
    return path.with_suffix(".parquet")


def _write_lists(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    lists = {name: [*values] for name, values in _arrays(log).items()}
    pq.write_table(pa.table(lists), path.with_suffix(".parquet"))
    return path.with_suffix(".parquet")


def _write_npz(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    np.savez(path.with_suffix(".npz"), **_arrays(log))
    return path.with_suffix(".npz")


def _write_mat(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    def plain(name: str) -> str:
        return name.replace(".", "_").replace("/", "_").strip("_")

    arrays = {plain(name): values for name, values in _arrays(log).items()}
    log.quantities = {q: [*map(plain, names)] for q, names in log.quantities.items()}
    scipy.io.savemat(path.with_suffix(".mat"), arrays)
    return path.with_suffix(".mat")


def _write_h5(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    with h5py.File(path.with_suffix(".h5"), "w") as file:
        for name, values in _arrays(log).items():
            file[f"state/{name.strip('/')}"] = values
    log.quantities = {
        quantity: [f"state/{name.strip('/')}" for name in names]
        for quantity, names in log.quantities.items()
    }
    return path.with_suffix(".h5")


def _write_bag(log: RandomLog, path: Path, random: np.random.Generator) -> Path:
    """Messages of joints with or without names, in the order of the columns."""
    kind, named = log.form["kind"], log.form["names"] == "named bag"
    table = {q: np.stack([log.table[n] for n in names], 1) for q, names in log.quantities.items()}
    channels = {"actual_q": table["q"]} | ({"actual_qd": table["qd"]} if "qd" in table else {})
    effort = next((table[q] for q in ("i", "tau") if q in table), None)
    channels |= {} if effort is None else {"effort": effort}
    joints = _joint_names(table["q"].shape[1])
    order = BY_NAME if log.form["order"] == "by name" and len(joints) == 6 else range(len(joints))
    names = [f"{joints[k]}_joint" for k in order] if named else []
    start = 1.7e9 if log.form["clock"] == "epoch" else 0.0
    ending = {"bag": ".bag", "mcap": ".mcap"}.get(kind, ".db3")
    file = path.with_suffix(ending)
    write_bag(file, start + log.time, channels, names)
    log.quantities = {"q": ["/joint_states/position"]}
    if kind != "folder":
        return file
    path.mkdir()
    file.rename(path / file.name)
    return path


WRITERS: Mapping[str, Callable[[RandomLog, Path, np.random.Generator], Path]] = (
    dict.fromkeys(TEXTS, _write_text)
    | dict.fromkeys(("bag", "db3", "mcap", "folder"), _write_bag)
    | {"parquet": _write_parquet, "lists": _write_lists, "npz": _write_npz}
    | {"mat": _write_mat, "h5": _write_h5}
)
