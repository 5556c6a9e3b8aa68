"""How fast the processor is now, and what steps and tests took beside those of another clone.

`python -m tests.clock` prints the processor time of 20 million additions, for which times of two
runs can be divided. `python -m tests.clock BEFORE AFTER` lists, of two clones with built studies or
tests that ran, the steps and the tests that take longest.
"""

import argparse
import json
import time
from pathlib import Path

import pandas as pd

from ur5lib.tables import read_csv

ADDITIONS = 20_000_000
LONGEST = 30  # tests that are listed


def reference() -> float:
    """Return the processor time of ADDITIONS additions in a loop [s]."""
    start, total = time.process_time(), 0
    for number in range(ADDITIONS):
        total += number
    return time.process_time() - start


def tests(clone: Path) -> pd.Series:
    """Return the processor time of each test of a clone's last run [s]."""
    kept = clone / ".pytest_cache" / "v" / "processor"
    return pd.Series(json.loads(kept.read_text()) if kept.exists() else {}, dtype=float)


def steps(clone: Path) -> pd.Series:
    """Return the processor time of each step of a clone's built studies [s], by study and step."""
    found = pd.Series(dtype=float)
    for path in sorted(clone.glob("results/*/tables/run_times.csv")):
        spent = read_csv(path).set_index("step")["cpu_s"]
        found = pd.concat([found, spent.rename(lambda step: f"{path.parts[-3]}/{step}")])  # noqa: B023
    return found


def beside(before: pd.Series, after: pd.Series) -> str:
    """Return what took longest in either of two runs, with the sums, as lines."""
    both = pd.DataFrame({"before": before, "after": after})
    longest = both.loc[both.max(axis="columns").nlargest(LONGEST).index]
    longest.loc["all"] = both.sum()
    return longest.round(2).to_string()


def main() -> None:
    options = argparse.ArgumentParser(prog="python -m tests.clock", description=__doc__)
    options.add_argument("clones", nargs="*", type=Path, metavar="CLONE", help="two of them")
    clones = options.parse_args().clones
    if len(clones) == 2:
        for told in (steps, tests):
            print(f"processor time of {told.__name__} [s]", beside(*map(told, clones)), sep="\n")
    else:
        print(f"{reference():.2f} s of processor for {ADDITIONS // 10**6} million additions")


if __name__ == "__main__":
    main()
