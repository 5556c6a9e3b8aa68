"""What import makes of many files, beside what is true: `python -m tests.importing.net` writes it.

A row of imports.csv is what one block of columns was taken for, and how surely; `truth` is written
by hand, or known of forms that are made here from right logs. It has names of files and cells
alone, never their numbers. Files that are not here keep their rows.
"""

import gzip
import re
import shutil
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np
import pandas as pd

from tests.conftest import PROJECT
from tests.importing.test_import_random_forms import ends_a_doubt, outcome
from ur5lib.commands.described import describe_urdf
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.importing.identity import UNDESCRIBED_ARM
from ur5lib.importing.parted_runs import runs_of
from ur5lib.records.account import NOTHING
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import write_text

SHARED = PROJECT.parent / "shared"
NET = Path(__file__).parent / "imports.csv"
KEYS, CELLS = ["file", "told", "block"], ["taken_for", "sure"]
HEAD = [*KEYS, *CELLS, "truth"]
RANDOM_FORMS = 60
URDFS = {  # of arms that are described for the files of a folder, with the tip of their chain
    "baxter": ("baxter/baxter.urdf", "left_wrist"),
    "lwr4": ("lwr4-flobaroid/kuka_lwr4.urdf", None),
    "tx40": ("staubli-tx40/tx40_mdh_modified.urdf", None),
    "shelec": ("shelec-cobot/shelec.urdf", None),
    "arm7": ("cases/12_arm7.urdf", None),
    "arm21": ("cases/21_arm.urdf", None),
}
UNKNOWN, OF_FORM = "unknown", "right"
TORQUE_NAMES = "actual_current_as_torque", "actual_torque"  # one meaning, by what an arm measures
ARMS = {  # files, by pattern, and the arms with which each is imported; "" for none
    "thesis/Movement_No*/csv_files/log_*_actual.csv": (),
    "ur10e/*.csv": ("ur10e", ""),
    "ur3-cb/*.bag": ("ur3", ""),
    "ur3-cb/*.csv": ("ur3", ""),
    "ur3-warming/*.csv": ("ur3",),
    "ur10-bag/*.db3": ("ur10", ""),
    "ur10-picknplace/*.mat": ("ur10", ""),
    "ur10-shovel/*.csv": ("ur10", ""),
    "ur5-threedigits/*.csv": ("ur5", ""),
    "ur5e/*.csv": ("ur5e", ""),
    "ur5e/*.h5": ("ur5e", ""),
    "kuka-kr300/raw-4ms/*.csv": ("kuka-kr300", ""),
    "kuka-kr300/benchmark-10hz/val-*.csv": ("kuka-kr300", ""),
    "baxter/*.csv": ("baxter", ""),
    "lwr4-flobaroid/*.npz": ("lwr4", ""),
    "staubli-tx40/*.csv": ("tx40", ""),
    "shelec-cobot/*.csv": ("shelec", ""),
    "seven-joints/rokae-xmate7": ("",),
    "seven-joints/kuka-lbr-med/measurements.csv": ("",),
    "lwa4p-autokoopman/measurement_*": ("",),
    "cases/12_nameless_columns.csv.gz": ("arm7", ""),
    "cases/21_turned*.csv.gz": ("arm21", ""),
    "cases/15_*": ("",),
    "cases/16_*": ("",),
    "cases/22_*": ("ur10", ""),
    "cases/[01]*": ("ur5e", ""),
    "cases-6/*.*": ("ur5e", ""),
    "cases-7/25-krc-trace/*": ("kuka-kr300", ""),
    "cases-7/*/*": ("ur5e", ""),
}
NO_RECORDINGS = re.compile(r"\.(md|urdf|yaml|m)$|PROVENANCE|LICENSE|metadata|base_push")


class Import(NamedTuple):
    """Files that are imported together, and what is told of them; truth: by channel."""

    file: str
    told: UserStatement
    path: Path
    truth: Mapping[str, str] = {}


def shared_imports(folder: Path) -> Iterator[Import]:
    """Yield the imports of the reference data; each file is of the first pattern that has it."""
    seen = set[Path]()
    for pattern, arms in ARMS.items():
        for path in sorted({*folder.glob(pattern)} - seen):
            seen.add(path)
            if not NO_RECORDINGS.search(path.name):
                for arm in arms:
                    yield Import(str(path.relative_to(folder)), UserStatement(arm), path)
    for run in sorted(folder.glob("thesis/*/csv_files")):
        yield Import(str(run.relative_to(folder)), UserStatement("ur5"), run)


def made_imports(folder: Path, to: Path) -> Iterator[Import]:
    """Yield forms of right logs of a UR10e, whose truth is known: units, names, signs."""
    for log in ("20_01_31-unload", "20_02_12-40sec_12harm"):
        if (path := folder / f"ur10e/ur-{log}.csv").is_file():
            table = pd.read_csv(path, header=None).to_numpy()[:3000]
            yield from _forms(log, table[:, 0], table[:, 1:7], table[:, 7:13], table[:, 13:19], to)


def _forms(
    log: str, stamps: np.ndarray, q: np.ndarray, qd: np.ndarray, amperes: np.ndarray, to: Path
) -> Iterator[Import]:
    arm = load_robot(robot_path("ur10e"))
    torque = amperes * np.array(arm.maker_torque_constants())
    rated = np.array([arm.motor(joint).torque_max for joint in arm.joint_numbers])
    free = torque - gravity_torque(arm, arm.chosen_model, q)
    kinds = {  # the numbers, what they are, and how they are named
        "A": (amperes, "actual_current", "joint_current"),
        "mA": (1e3 * amperes, "actual_current [mA]", "joint_current"),
        "Nm": (torque, "actual_current_as_torque", "joint_torque"),
        "less gravity": (free, "actual_torque_less_gravity", "joint_torque"),
        "one factor": (0.37 * amperes, UNKNOWN, "joint_current"),
        "per cent": (100 * torque / rated, UNKNOWN, "joint_torque"),
        "turned": (-amperes, "actual_current [opposite]", "joint_current"),
    }
    for kind, (rows, truth, quantity) in kinds.items():
        for name in (quantity, "effort", ""):
            path = to / f"{log} {kind} {name or 'nameless'}.csv"
            names = [
                f"{n}_{k}" for n in ("joint_position", "joint_velocity", name) for k in range(6)
            ]
            table = pd.DataFrame(np.column_stack([stamps, q, qd, rows]), columns=["time", *names])
            table.to_csv(path, index=False, header=bool(name))
            told = f"{name}_0 … {name}_5" if name else "column 14 … column 19"
            for stated in ("ur10e", ""):
                known = {told: truth, "robot": arm.name}
                yield Import(f"made/{path.name}", UserStatement(stated), path, known)


def unpacked(path: Path) -> Path:
    """Return a file or folder; one with packed bags is unpacked here, as its README says."""
    inside = [file for file in path.rglob("*.gz") if path.is_dir()]
    if not inside and not path.name.endswith(".yaml.gz"):
        return path
    here = Path(path.name.removesuffix(".gz"))
    if path.is_dir():
        shutil.copytree(path, here)
    for packed in inside or [path]:
        plain = here / packed.name.removesuffix(".gz") if inside else here
        plain.write_bytes(gzip.decompress(packed.read_bytes()))
    return here


def cells_of(one: Import) -> Iterator[dict[str, str]]:
    """Yield the rows of an import: of each recording what its blocks were taken for."""
    head = {"file": one.file, "told": one.told.robot, "truth": ""}
    if one.told.robot in URDFS:
        urdf, tip = URDFS[one.told.robot]
        describe_urdf(SHARED / urdf, None, tip, one.told.robot)
    try:
        imported = import_files(runs_of([unpacked(one.path)]), one.told)
    except InputError:
        yield head | {"block": "refused", "taken_for": "", "sure": ""}
        return
    except Exception as error:  # it is in the table until it is mended
        yield head | {"block": "crash", "taken_for": type(error).__name__, "sure": ""}
        return
    for row in imported[0].account:
        taken = re.sub(r"\d+\.\d{3,}", lambda it: f"{float(it[0]):.3g}", row.taken_for)
        for block in row.subject.split(", ") if taken == NOTHING else [row.subject]:
            sure = row.confidence if ends_a_doubt(row) else "check without an end"
            cells = {"block": block, "taken_for": taken, "sure": sure}
            if row.confidence != "evidence":
                yield head | cells | {"truth": one.truth.get(block, "")}


def random_cells(seeds: Iterable[int]) -> Iterator[dict[str, str]]:
    """Yield a row for each log of random form: how its import ended."""
    for seed in seeds:
        with TemporaryDirectory() as folder, chdir(folder):
            made = outcome(seed, Path(folder))
        head = {"file": f"random form {seed}", "told": "", "block": "import", "sure": ""}
        yield head | {"taken_for": made.result, "truth": OF_FORM}


def drawn(folder: Path = SHARED, every: int = 1) -> pd.DataFrame:
    """Return the rows of all imports that can be drawn here, or of every so many."""
    rows = list[dict[str, str]]()
    with TemporaryDirectory() as made:
        for one in [*shared_imports(folder), *made_imports(folder, Path(made))][::every]:
            with TemporaryDirectory() as place, chdir(place):
                rows += cells_of(one)
    rows += random_cells(range(0, RANDOM_FORMS, every))
    return pd.DataFrame(rows, columns=HEAD)


def read() -> pd.DataFrame:
    """Return the table."""
    return pd.read_csv(NET, dtype=str, keep_default_na=False)


def changed(now: pd.DataFrame, before: pd.DataFrame) -> list[str]:
    """Return the cells of imports drawn now that differ from those before, a line each; files that
    were not there before are left out.
    """
    cells = [frame.set_index(KEYS)[CELLS].apply(tuple, axis=1).to_dict() for frame in (before, now)]
    known, drawn_now = ({key[:2] for key in own} for own in cells)
    keys = dict.fromkeys(key for own in cells for key in own if key[:2] in drawn_now & known)
    pairs = {key: [own.get(key, ()) for own in cells] for key in keys}
    said = {key: " -> ".join(" ".join(cell) or "no row" for cell in pairs[key]) for key in keys}
    return [
        f"{', '.join(filter(None, key))}: {said[key]}" for key in keys if len({*pairs[key]}) > 1
    ]


def with_truths(now: pd.DataFrame, before: pd.DataFrame) -> pd.DataFrame:
    """Return what is drawn now with the truths that are written, and rows of files not here."""
    truths = before.set_index(KEYS)["truth"].to_dict()
    keys = map(tuple, now[KEYS].to_numpy())
    own = [own or truths.get(key, "") for key, own in zip(keys, now["truth"], strict=True)]
    rest = before[~before["file"].isin(now["file"])]
    return pd.concat([now.assign(truth=own), rest]).drop_duplicates(KEYS)


def state(taken_for: str, sure: str, truth: str) -> str:
    """Return how a cell compares with the truth, "" where that is not known."""
    if truth in ("", OF_FORM):
        return truth and f"random form {taken_for}"
    taken_for, truth = (one.replace(*TORQUE_NAMES) for one in (taken_for, truth))
    if taken_for == truth or (truth == UNKNOWN and UNKNOWN in taken_for):
        return "right"
    if UNKNOWN in taken_for:
        return "kept in an unknown unit"
    if taken_for == UNDESCRIBED_ARM:
        return "arm not named"
    if taken_for == NOTHING:
        return "left out"
    return "wrong, to be checked" if sure == "check" else f"wrong, {sure}"


def counted(table: pd.DataFrame) -> Counter[str]:
    """Return how many cells with a truth are right, left out, or wrong, by how sure they are."""
    rows = table[["taken_for", "sure", "truth"]].itertuples(index=False)
    return Counter(filter(None, (state(*row) for row in rows)))


def main() -> None:
    """Print the changed cells and the counts, and write the table."""
    before, started = read(), time.process_time()
    now = drawn()
    print("\n".join(changed(now, before)))
    after = with_truths(now, before)
    for name, count in sorted(counted(after).items(), key=lambda one: -one[1]):
        print(f"{count:5} {name} (before: {counted(before)[name]})")
    write_text(after.to_csv(index=False, lineterminator="\n"), NET)
    imports = len(now[["file", "told"]].drop_duplicates())
    print(f"{imports} imports in {time.process_time() - started:.0f} s of processor time")


if __name__ == "__main__":
    main()
