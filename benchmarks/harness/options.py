"""Command-line options of benchmarks: seeds, or built studies."""

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

STUDIES = ["thesis", "ur10e"]


class Asked(NamedTuple):
    """Number of seeds; quick: whether the run only tests that the benchmark runs."""

    seeds: int
    quick: bool


def options_of(about: str) -> argparse.ArgumentParser:
    """Return the option that every benchmark has; about: of the benchmark."""
    options = argparse.ArgumentParser(description=about.splitlines()[0])
    options.add_argument("--quick", action="store_true", help="a part: only shows that it runs")
    return options


def asked(about: str, seeds: int, first: int = 0) -> Asked:
    """Return the options of the command line; about: help text; seeds: default number; first: first
    seed.
    """
    options = options_of(about)
    options.add_argument(
        "seeds", nargs="?", type=int, default=seeds, help=f"how many, from {first} on"
    )
    given = options.parse_args()
    return Asked(1 if given.quick else given.seeds, given.quick)


def arm_options(about: str) -> argparse.ArgumentParser:
    """Return the options of a benchmark of one arm of a built study; about: of the benchmark."""
    options = options_of(about)
    options.add_argument("study", nargs="?", default="demo", help="the name of a built study")
    options.add_argument("robot", nargs="?", default="ur5", help="one of its arms")
    return options


def study_options(about: str) -> argparse.ArgumentParser:
    """Return the options of a benchmark of built studies; about: of the benchmark."""
    options = options_of(about)
    options.add_argument("studies", nargs="*", default=STUDIES, help="names of built studies")
    return options


def built(folders: Iterable[Path]) -> list[Path]:
    """Return the results of studies, results/<study>; exit with a sentence if one is not built."""
    found = [*folders]
    for folder in found:
        if not (folder / "configuration.yaml").exists():
            sys.exit(f"{folder} is not built; run `snakemake` first, with `--configfile` its study")
    return found
