"""Correctly declared logs: of real arms with files here, and drawn ones of simulated arms."""

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml

from benchmarks.harness.abb_like import MadeUpArm, write_files
from benchmarks.serial_arms import with_motors
from ur5lib.checks.checked import Checked
from ur5lib.checks.devices import checked_intake
from ur5lib.recordings.entries import ENTRY, Files
from ur5lib.recordings.intake import read_and_repair
from ur5lib.records.carried import carried
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot, load_robot, robot_of, robot_path
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.stand.layout import ROBOT_FILES
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.study.reading import parse_study

PROJECT = Path(__file__).parents[2]
MAX_GAP, CUTOFF = 0.1, 2.0  # s, Hz
STUDIES = {  # of the workflow, and the folder of their files among the reference data
    "thesis": "thesis",
    "ur10e": "ur10e",
    "ur3-cb": "ur3-cb",
    "ur10-bag": "ur10-bag",
    "ur5e-rtde": "ur5e",
    "ur5e-demonstrations": "ur5e",
    "kuka-kr300": "kuka-kr300/benchmark-10hz",
}
MOST = 22  # recordings of a study, evenly chosen
# Arms of seven joints: offsets [m] and angles between axes [degrees], masses of links [kg].
XMATE = (0.3415, 0, 0.394, 0, 0.366, 0, 0.2503), (-90, 90, -90, 90, -90, 90, 0)
MED = (0.34, 0, 0.4, 0, 0.4, 0, 0.126), (-90, 90, 90, -90, -90, 90, 0)
MASSES = (4.0, 4.0, 3.0, 3.0, 2.0, 1.5, 0.5)
MEASURED = ["actual_q", "actual_qd", "actual_torque"]
SIMULATED_ARMS = {  # names of described arms by kind; what else is simulated is drawn
    "UR": ("ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e", "ur16e", "ur20"),
}
WRONG, WRONG_CENTER = 0.4, 0.05  # errors of each link: log mass; centre of mass [m]
BEND, SWAY = 0.5, 0.5  # rad; posture of an arm of seven joints; variation between postures


Made = tuple[str, Robot, dict[str, Any]]  # a log's name, arm and entry


class RightLog(NamedTuple):
    """A log and its correct declarations; arm: limits are set without this arm's logs."""

    arm: str
    name: str
    checked: Checked


def real_logs(shared: Path) -> Iterator[RightLog]:
    """Yield the logs of real arms with files here; shared: the reference data."""
    for study, folder in STUDIES.items():
        if (shared / folder).is_dir():
            yield from of_study(study, shared / folder)
    for makes in (of_baxter, of_cobots, of_staubli, of_kuka, of_ur5, of_sensing_arms, of_lwr):
        for name, arm, entry in makes(shared):
            yield RightLog(arm.name, name, checked(entry, arm))


def of_study(study: str, folder: Path) -> Iterator[RightLog]:
    """Yield the logs of a study of the workflow; folder: of its files."""
    text = (PROJECT / f"workflow/studies/{study}.yaml").read_text()
    raw = yaml.safe_load(text.replace(f"raw/{study}", str(folder.resolve())))
    raw.pop("reference", None)
    recordings = parse_study(raw, study).recordings
    for own in recordings[:: -(-len(recordings) // MOST)]:
        arm = own.arm.description().mounted(own.known_gravity())
        yield RightLog(own.arm.known_as, own.name, checked(own, arm, own.known_payload(), own.role))


def checked(
    entry: Mapping[str, Any] | Files, arm: Robot, payload: Payload | None = None, role: str = "fit"
) -> Checked:
    """Return a log as `ur5 check` takes it; arm: under its gravity."""
    files = entry if isinstance(entry, Files) else ENTRY.validate_python(entry)
    table = checked_intake(read_and_repair(files, arm, MAX_GAP), arm).robot
    load = carried(payload, Signals.from_table(table))
    return Checked(table, arm, load.configured, load.payload, role == "fit", cutoff=CUTOFF)


def of_baxter(shared: Path) -> Iterator[Made]:
    """Yield a Baxter's logs, with known and with unknown links."""
    if (folder := shared / "baxter").is_dir():
        baxter, _ = robot_from_urdf(folder / "baxter.urdf", tip="left_wrist")
        for file, arm in product(("Random", "square"), (baxter, unknown(baxter))):
            columns = of_joints(7, *MEASURED)
            entry = table(folder / f"{file}_ang_vel_torq.csv", columns, rate=100)
            yield f"baxter {file}, links {arm.links}", arm, entry


def of_cobots(shared: Path) -> Iterator[Made]:
    """Yield logs of arms with unknown links; the sign of joint 3's torque is wrong in the files."""
    mended = {"actual_torque": [1, 1, -1, 1, 1, 1]}
    files = {
        "shelec": ("shelec-cobot/shelec.urdf", "shelec-cobot/traj1_6ms.csv"),
        "case 21": ("cases/21_arm.urdf", "cases/21_turned_torque_of_joint_3.csv.gz"),
    }
    for name, (urdf, log) in files.items():
        if (shared / urdf).is_file():
            arm, _ = robot_from_urdf(shared / urdf)
            yield name, arm, table(shared / log, ["time", *MEASURED], units=mended)


def of_staubli(shared: Path) -> Iterator[Made]:
    """Yield a TX40's log, with known and with unknown links."""
    if (folder := shared / "staubli-tx40").is_dir():
        tx40, _ = robot_from_urdf(folder / "tx40_mdh_modified.urdf")
        for arm in (tx40, unknown(tx40)):
            columns = ["time", "actual_q", "actual_torque"]
            entry = table(folder / "joint_space_1khz.csv", columns)
            yield f"tx40, links {arm.links}", arm, entry


def of_kuka(shared: Path) -> Iterator[Made]:
    """Yield a KR300's three motions of ten seconds."""
    if (folder := shared / "kuka-kr300/raw-4ms").is_dir():
        kr300 = load_robot(robot_path("kuka-kr300"))
        for file in "ABC":
            entry = table(folder / f"{file}.csv", ["time", *MEASURED, *["-"] * 9])
            yield f"kr300 raw {file}", kr300, entry


def of_ur5(shared: Path) -> Iterator[Made]:
    """Yield a UR5's log with smoothed currents."""
    file = shared / "ur5-threedigits/ContactlessDataset1.csv"
    if file.is_file():
        channels = ["actual_q", "actual_qd", "actual_current", "target_current", *["-"] * 12]
        yield "ur5 threedigits", load_robot(robot_path("ur5")), table(file, channels, rate=43)


def of_sensing_arms(shared: Path) -> Iterator[Made]:
    """Yield logs of seven-joint arms with torque sensors; one has torques of opposite sign."""
    if (folder := shared / "seven-joints").is_dir():
        names = dict(zip(MEASURED, ("ang", "vel", "torque"), strict=True))
        arrays = {name: f"excit_{short}_record.txt" for name, short in names.items()}
        rokae = {"folder": str(folder / "rokae-xmate7"), "format": "channel-files"}
        arm = unknown(of_seven("rokae", *XMATE))
        yield "rokae", arm, rokae | {"channels": arrays, "rate": 1000}
        columns = [*of_joints(7, "actual_q", "actual_torque"), *["-"] * 7]
        file, opposite = folder / "kuka-lbr-med/measurements.csv", {"actual_torque": "opposite"}
        entry = table(file, columns, rate=100, units=opposite)
        yield "lbr-med", unknown(of_seven("lbr-med", *MED)), entry


def of_lwr(shared: Path) -> Iterator[Made]:
    """Yield a KUKA LWR's runs, with known and with unknown links."""
    if (folder := shared / "lwr4-flobaroid").is_dir():
        lwr, _ = robot_from_urdf(folder / "kuka_lwr4.urdf")
        names = dict(zip(MEASURED, ("positions", "velocities", "torques"), strict=True))
        kind = {"format": "npz", "folder": str(folder), "time": "epoch_s"}
        for file, arm in product(sorted(folder.glob("*.npz")), (lwr, unknown(lwr))):
            entry = kind | {"file": file.name, "channels": {"time": "times", **names}}
            yield f"lwr {file.stem}, links {arm.links}", arm, entry


def table(path: Path, columns: list[str], **keys: Any) -> dict[str, Any]:
    """Return the entry of a delimited table."""
    kind = {"format": "table-csv", "folder": str(path.parent), "file": path.name}
    return {**kind, "columns": columns, **keys}


def of_joints(count: int, *channels: str) -> list[str]:
    """Return the columns of channels of an arm with `count` joints."""
    return [f"{name}_{joint}" for name in channels for joint in range(count)]


def unknown(arm: Robot) -> Robot:
    """Return an arm with unknown links."""
    return arm.model_copy(update={"links": "unknown"})


def of_seven(name: str, offsets: tuple[float, ...], turns: tuple[int, ...]) -> Robot:
    """Return an arm with torque sensors in its seven joints; its links are guesses."""
    axes = zip(offsets, np.deg2rad(turns), strict=True)
    motor = {"position_max": 3.1, "velocity_max": 3.0, "torque_max": 200.0}
    centers = [[0.0, 0.0, -length / 2] for length in offsets]
    sizes = [[0.03, 0.03, 0.01, 0.0, 0.0, 0.0]] * len(offsets)
    links = {"description": "", "centers_of_mass": centers, "inertias": sizes}
    return robot_of(
        {
            "name": name,
            "gravity": (0, 0, -9.81),
            "denavit_hartenberg": [{"a": 0.0, "d": d, "alpha": turn} for d, turn in axes],
            "joints": ["any"] * len(offsets),
            "effort": "torque",
            "motors": {"any": motor},
            "masses": MASSES,
            "models": {"guess": links},
            "chosen_model": "guess",
        }
    )


def simulated_logs(seeds: int) -> Iterator[RightLog]:
    """Yield drawn logs of simulated arms, one of each kind for each seed."""
    for seed in range(seeds):
        with tempfile.TemporaryDirectory() as folder:
            names = SIMULATED_ARMS["UR"]
            seven = of_seven("seven", *(XMATE if seed % 2 else MED))
            arms = {
                "UR": load_robot(robot_path(names[seed % len(names)])),
                "torque sensors": seven,
                "seven joints": with_motors(seven),
            }
            for kind, arm in arms.items():
                yield RightLog(kind, f"{kind} {seed}", on_the_stand(arm, seed, Path(folder, kind)))
            yield RightLog("big gears", f"big gears {seed}", big_gears(seed, Path(folder)))


def on_the_stand(arm: Robot, seed: int, folder: Path) -> Checked:
    """Return a log of an arm on the virtual test stand: a motion, and its speed, by the seed."""
    random = np.random.default_rng(seed)
    bent = [0.5, -1.6, 1.6, -1.5, 1.5, 0.3] if arm.is_ur() else BEND * (-1.0) ** np.arange(7)
    posture = [*(np.array(bent) + random.uniform(-SWAY, SWAY, len(bent)))]
    motion = {"kind": "fourier", "draw": seed, "posture": posture, "period_s": 15, "harmonics": 8}
    motion |= {"limit_share": random.uniform(0.1, 0.7), "amplitude_rad": random.uniform(0.3, 0.9)}
    plan = {"trajectory": motion, "seed": seed, "seconds": random.choice([10.0, 20.0, 40.0])}
    simulate(arm, SimulatedRecording.model_validate(plan), "rtde-csv", folder, folder / "truth")
    kind = {"format": "rtde-csv", "file": ROBOT_FILES["rtde-csv"], "folder": str(folder)}
    log = checked(kind, arm)
    kept = [name for name in log.robot if not name.startswith(("target_", "actual_TCP"))]
    return replace(log, robot=log.robot[kept])  # without targets, which show most


def big_gears(seed: int, folder: Path) -> Checked:
    """Return a log of motor torques of a made-up industrial arm with unknown links."""
    made = MadeUpArm(seed)
    write_files(made, seed, folder, {"log": (1 + seed % 2, 0.03)})
    described = robot_from_urdf(folder / "arm.urdf")[0].model_dump(mode="json", exclude_none=True)
    columns = ["time", "actual_q", "actual_torque"]
    entry = {"format": "table-csv", "folder": str(folder), "file": "log.csv", "columns": columns}
    return checked(entry, robot_of(made.as_described(described)))


def wrongly_described(log: Checked) -> Iterator[Checked]:
    """Yield a log with a description of wrong links, as in a URDF made for pictures.

    Placeholders are declared as known, known links are changed. No logs of UR arms, as all are
    described.
    """
    if log.arm.has_ur_motors():
        return
    arm, random = log.arm, np.random.default_rng(len(log.robot))
    if arm.links == "unknown":
        yield replace(log, arm=arm.model_copy(update={"links": "known"}))
        return
    masses = np.array(arm.masses) * np.exp(WRONG * random.normal(size=len(arm.joints)))
    own = arm.models[arm.chosen_model]
    shift = WRONG_CENTER * random.normal(size=(len(arm.joints), 3))
    centers = (np.array(own.centers_of_mass) + shift).tolist()
    changes = {"masses": None, "centers_of_mass": [*map(tuple, centers)]}
    models = {arm.chosen_model: own.model_copy(update=changes)}
    wrong = {"masses": tuple(masses.tolist()), "models": models}
    yield replace(log, arm=arm.model_copy(update=wrong))
