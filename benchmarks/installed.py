"""Size of an installation in empty environments, as plain pip gives it: docs/data/installed.csv.

    python -m benchmarks.installed [--wheel <file>] [--python <command> ...] [--page] [--quick]

Makes an environment by each Python, of those from 3.11 on that are at hand, installs the wheel (by
default that of the clone), and counts packages but for pip, and the gigabytes (10^9 byte) that they
add on disk. Exit status 1 if the table that the documents quote differs by more than 5 %; `--page`
writes it instead, and keeps the rows of others. `--quick` installs none of the needed packages.
"""

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from benchmarks.harness.cells import DATA
from benchmarks.harness.markdown import markdown
from benchmarks.harness.options import options_of
from ur5lib.tables import write_csv

PROJECT = Path(__file__).parents[1]
TABLE = DATA / "installed.csv"
PYTHONS = "python3.11", "python3.12", "python3.13"
TOLERANCE = 0.05


class Installed(NamedTuple):
    """An installation; torch: which build pip took."""

    python: str
    torch: str
    packages: int
    gigabytes: float


def main() -> None:
    """Measure, and write or compare the table."""
    options = options_of(__doc__)
    options.add_argument("--wheel", type=Path, default=PROJECT, help="a wheel, or a clone")
    options.add_argument("--python", nargs="+", default=[*at_hand()], help="its commands")
    options.add_argument("--page", action="store_true", help="write docs/data/installed.csv")
    given = options.parse_args()
    arguments = ["--no-deps"] if given.quick else []
    rows = [installed(python, given.wheel, arguments) for python in given.python]
    print(markdown(Installed._fields, [[*map(str, row)] for row in rows]))
    table = pd.DataFrame(rows)
    known = pd.read_csv(TABLE, dtype={"python": str})
    if given.page:
        others = known[~known["python"].isin(table["python"])]
        write_csv(pd.concat([others, table]).sort_values("python"), TABLE)
    elif not given.quick and (told := differing(table, known)):
        sys.exit(f"docs/data/installed.csv has other numbers for {told}; write it: --page")


def at_hand() -> Iterator[str]:
    """Yield the commands of Pythons that start."""
    for name in PYTHONS:
        command = shutil.which(name)
        if command and not subprocess.run([command, "--version"], capture_output=True).returncode:
            yield command


def installed(python: str, wheel: Path, arguments: list[str]) -> Installed:
    """Return what an installation takes in an environment that is thrown away."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([python, "-m", "venv", folder], check=True)
        before = size(Path(folder))
        pip = [f"{folder}/bin/python", "-m", "pip", "--disable-pip-version-check"]
        subprocess.run([*pip, "install", "--quiet", *arguments, wheel], check=True)
        lines = subprocess.check_output([*pip, "list", "--format=freeze"], text=True).split()
        packages = dict(line.split("==") for line in lines if not line.startswith("pip=="))
        cuda = any(name.startswith("nvidia-") for name in packages)
        torch = f"{packages.get('torch', 'none').split('+')[0]}, {'CUDA' if cuda else 'CPU'}"
        [version] = (path.name.removeprefix("python") for path in Path(folder, "lib").iterdir())
        gigabytes = round((size(Path(folder)) - before) / 1e9, 1)
        return Installed(version, torch, len(packages), gigabytes)


def size(folder: Path) -> int:
    """Return the bytes that the files of a folder take on disk."""
    return sum(512 * path.lstat().st_blocks for path in folder.rglob("*"))


def differing(new: pd.DataFrame, old: pd.DataFrame) -> str:
    """Return the environments whose numbers differ by more than the tolerance, or are not told."""
    numbers = ["packages", "gigabytes"]
    both = new.merge(old, how="left", on=["python", "torch"], suffixes=("", "_told"))
    far = [(both[name] - both[f"{name}_told"]).abs() <= TOLERANCE * both[name] for name in numbers]
    return ", ".join(both.loc[~(far[0] & far[1]), "python"])


if __name__ == "__main__":
    main()
