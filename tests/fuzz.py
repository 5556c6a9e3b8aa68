"""Random damage, as long as wanted, to what comes from outside: it is refused in words, or read.

`python -m tests.fuzz --seconds 600 --seed 1` tries what the files `fuzzed.py` beside the tests
prepare: `TARGETS`, by name, each a function that gets a folder and returns an attempt. An attempt
damages something by the dice it is given, in a folder of its own, and hands it to the library. It
raises InputError where that refuses; any other exception is a crash, more than ten seconds are a
hang. What the attempt of a name and number damages depends on the seed alone.
"""

import argparse
import importlib
import random
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from tests.command import time_limit
from ur5lib.errors import InputError

HERE = Path(__file__).parent
SECONDS = 10  # in which each attempt ends
OUTCOMES = ("refused", "accepted", "crashes", "hangs")
Attempt = Callable[[random.Random, Path], None]
Prepare = Callable[[Path], Attempt]


@dataclass
class Target:
    """What is damaged, and how often it ended in which way; spent: seconds on it."""

    name: str
    prepare: Prepare
    folder: Path
    spent: float = 0.0
    counts: Counter[str] = field(default_factory=Counter)

    @cached_property
    def attempt(self) -> Attempt:
        """Prepare what is damaged, at the first attempt."""
        whole = self.folder / self.name / "whole"
        whole.mkdir(parents=True)
        return self.prepare(whole)

    def try_once(self, seed: int) -> str:
        """Damage it once; return what went wrong, with the place of the damaged files, else ""."""
        attempt, begin, number = self.attempt, time.process_time(), self.counts.total()
        place, wrong = self.folder / self.name / str(number), ""
        place.mkdir()
        try:
            with time_limit(SECONDS), warnings.catch_warnings():
                warnings.simplefilter("ignore")
                attempt(random.Random(f"{seed} {self.name} {number}"), place)
            outcome = "accepted"
        except InputError:
            outcome = "refused"
        except TimeoutError:
            outcome, wrong = "hangs", traceback.format_exc()
        except Exception:
            outcome, wrong = "crashes", traceback.format_exc()
        self.counts[outcome] += 1
        self.spent += time.process_time() - begin
        if not wrong:
            shutil.rmtree(place)
            return ""
        return f"{self.name} {number} of seed {seed}, {place}:\n{wrong}"


def targets(folder: Path) -> list[Target]:
    """Return all that may be damaged; folder: for its files."""
    files = sorted(path.relative_to(HERE.parent) for path in HERE.rglob("fuzzed.py"))
    modules = (importlib.import_module(".".join(path.with_suffix("").parts)) for path in files)
    prepared = {name: way for module in modules for name, way in module.TARGETS.items()}
    return [Target(name, way, folder) for name, way in prepared.items()]


def fuzz(several: list[Target], seconds: float, seed: int) -> list[str]:
    """Damage targets, all for about as long; return what went wrong."""
    end, wrong = time.process_time() + seconds, list[str]()
    while time.process_time() < end:
        target = min(several, key=lambda one: one.spent)
        if fault := target.try_once(seed):
            print(fault, flush=True)
            wrong.append(fault)
    return wrong


def table(several: Iterable[Target]) -> str:
    """Return how often what was tried, and how it ended."""
    rows: list[tuple[str, ...]] = [("", "tried", *OUTCOMES)]
    for one in several:
        counts = (one.counts.total(), *(one.counts[outcome] for outcome in OUTCOMES))
        rows.append((one.name, *map(str, counts)))
    return "\n".join(
        f"{name:<14}" + "".join(f"{n:>10}" for n in numbers) for name, *numbers in rows
    )


def main() -> None:
    """Damage everything for some time; end with status 1 where something crashed or hung."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--seconds", type=float, default=600.0)
    options.add_argument("--seed", type=int, default=random.randrange(10_000))
    given = options.parse_args()
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    several = targets(folder)
    print(f"seed {given.seed}, {given.seconds:g} s", flush=True)
    wrong = fuzz(several, given.seconds, given.seed)
    print(table(several))
    if wrong:
        sys.exit(1)
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
