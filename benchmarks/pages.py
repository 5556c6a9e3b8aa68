"""Numbers, tables and pictures of README and docs, built anew by the commands that make them.

    python -m benchmarks.pages [<part> ...] [--all] [--quick]

Runs the command of each part, on studies that are built (`make studies`), puts the cells of
docs/data into prose (`benchmarks/harness/cells.py`), and writes commit and day of each part into
docs/data/stamps.csv. Without names, all parts that take minutes; `--all` takes those of hours, too.
A part that fails is left as it was, and named at the end. `--quick` only names the pages whose
prose has other numbers than docs/data.
"""

import subprocess
import sys
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from benchmarks.harness.cells import DATA, with_cells
from benchmarks.harness.options import options_of
from ur5lib.tables import write_csv, write_text

PROJECT = Path(__file__).parents[1]
STAMPS = DATA / "stamps.csv"
PAGES = [
    PROJECT / "README.md",
    PROJECT / "paper" / "paper.md",
    *sorted((PROJECT / "docs").glob("*.md")),
]
PYTHON = f"{sys.executable} -m"


class Part(NamedTuple):
    """What a command writes; hours: whether it takes hours of the processor."""

    pages: str
    command: str
    hours: bool = False


PARTS = {
    "settings": Part("docs/settings.md", "ur5lib settings > docs/settings.md"),
    "expected": Part("docs/expect.md", "benchmarks.expected --page"),
    "choice": Part("a table of docs/api.md", "benchmarks.choice --page"),
    "stand": Part("a table of docs/world.md", "benchmarks.stand_and_arms --page"),
    "published": Part("a part of docs/benchmark.md", "benchmarks.published_friction --page"),
    "torques": Part("a part of docs/benchmark.md", "benchmarks.torque_from_motion --page"),
    "motion": Part("a part of docs/benchmark.md", "benchmarks.motion_alone --page"),
    "grasps": Part("a part of docs/benchmark.md", "benchmarks.grasps --page"),
    "installed": Part("docs/data/installed.csv", "benchmarks.installed --page", hours=True),
    "leaderboard": Part("docs/benchmark.md", "benchmarks.leaderboard --page", hours=True),
    "paths": Part(
        "a table of docs/how_much.md",
        "benchmarks.paths thesis:ur5 ur10e:ur10e --page",
        hours=True,
    ),
    "constants": Part(
        "a table of docs/methods.md",
        "benchmarks.worth thesis:ur5 ur10e:ur10e --constants --quick --page",
        hours=True,
    ),
    "world": Part("docs/world.md", "benchmarks.world --seeds 1 --page", hours=True),
    "links": Part("a table of docs/world.md", "benchmarks.touched_links --page", hours=True),
    # these draw tables that those above have written
    "pictures": Part("docs/pictures, and what reports say", "benchmarks.pictures"),
    "notebook": Part("docs/notebook.ipynb", "tests.notebook ."),
}


def main() -> None:
    """Run the parts, and write what they made."""
    options = options_of(__doc__)
    options.add_argument("parts", nargs="*", choices=[*PARTS, []], help="names of parts")
    options.add_argument("--all", action="store_true", help="those that take hours, too")
    given = options.parse_args()
    names = given.parts or [name for name, part in PARTS.items() if given.all or not part.hours]
    left = [name for name in names if not given.quick and not built(name)]
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        if (new := with_cells(text)) != text:
            print(f"numbers in prose differ from docs/data: {page.name}")
            if not given.quick:
                write_text(new, page)
    if left:
        sys.exit(f"not built, and kept as they were: {', '.join(left)}")


def built(name: str) -> bool:
    """Run a part, stamp it, and return whether it succeeded; it says itself what it lacks."""
    print(f"python -m {PARTS[name].command}", flush=True)
    if subprocess.run(f"{PYTHON} {PARTS[name].command}", shell=True, cwd=PROJECT).returncode:
        return False
    write_csv(stamped(pd.read_csv(STAMPS, dtype=str), name), STAMPS)
    return True


def stamped(stamps: pd.DataFrame, name: str) -> pd.DataFrame:
    """Return the stamps with today's of a part, in the order of the parts."""
    part = PARTS[name]
    new = [name, part.pages, f"python -m {part.command}", commit(), f"{datetime.now(UTC):%Y-%m-%d}"]
    rows = {row[0]: row for row in stamps.to_numpy().tolist()} | {name: new}
    return pd.DataFrame(ordered(rows), columns=stamps.columns)


def ordered(rows: dict[str, list[str]]) -> Iterable[list[str]]:
    """Return the rows of parts, in the order of PARTS."""
    return [rows[name] for name in PARTS if name in rows]


def commit() -> str:
    """Return the commit, "+ changes" where files but documents differ from it."""
    git = ["git", "-C", str(PROJECT)]
    name = subprocess.check_output([*git, "rev-parse", "--short=8", "HEAD"], text=True).strip()
    asked = [*git, "status", "--porcelain", "--", ".", ":!docs", ":!README.md", ":!paper"]
    return f"{name} + changes" if subprocess.check_output(asked, text=True).strip() else name


if __name__ == "__main__":
    main()
