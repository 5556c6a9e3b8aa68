"""docs/benchmark.md, written anew: all estimators of the contact force on the same recordings.

    python -m benchmarks.leaderboard [<study> ...] [--page] [--quick] [--estimator <module:Class>]

Prints the tables of results/<study> as built, by default of `thesis` and `ur10e`, as `ur5
leaderboard` does, and writes results/leaderboard.csv; `--page` writes docs/benchmark.md, too, with
the table of `simulated_contacts` as that left it in results/, or as the page already has it.
`--estimator` adds one that is not among them; with it, or with estimators of the working folder,
the page is results/benchmark.md. Beside it lie its figure and its numbers. `--quick` takes four
estimators: it only shows that it runs.
"""

import re
import sys
from pathlib import Path

from benchmarks.harness import page
from benchmarks.harness.latency_figure import error_over_latency
from benchmarks.harness.markdown import read_page, wrapped, write_page
from benchmarks.harness.options import built, study_options
from benchmarks.harness.sections import detection_tables, simulated_section
from ur5lib.errors import InputError
from ur5lib.force.estimators import OWN
from ur5lib.report.figures.house_style import save
from ur5lib.tables import write_csv
from ur5rivals.board import RESULTS_FOLDER, TABLE_FILE, contenders, scored
from ur5rivals.estimators import all_estimators
from ur5rivals.estimators.ours import OURS
from ur5rivals.study import read_arms
from ur5rivals.tables import tables

QUICK = (OURS, "zero", "least squares", "momentum observer")
PAGE = Path(__file__).parents[1] / "docs" / "benchmark.md"
BESIDE = RESULTS_FOLDER / "benchmark.md"  # the page with estimators from outside the project


def main() -> None:
    """Learn, score, print and write."""
    options = study_options(__doc__)
    options.add_argument("--page", action="store_true", help="write docs/benchmark.md as well")
    options.add_argument("--estimator", help="package.module:Class, beside the rivals")
    given = options.parse_args()
    folders = built(RESULTS_FOLDER / name for name in given.studies)
    try:
        slow = {own.name for own in all_estimators()} - {*QUICK} if given.quick else {}
        chosen = [own for own in contenders(given.estimator) if own.name not in slow]
        arms = [arm for folder in folders for arm in read_arms(folder)]
        table = scored(arms, chosen)
    except InputError as error:
        sys.exit(str(error))
    write_csv(table, TABLE_FILE)
    print(tables(table))
    if given.page:
        simulated = simulated_section(RESULTS_FOLDER / "simulated_contacts.csv")
        further = {"simulated": simulated, "detections": detection_tables(folders)}
        text, names = page.page(table, arms, further), [*table["estimator"].unique()]
        text = wrapped(page.with_kept(text, read_page(PAGE), simulated is not None, names))
        place = BESIDE if given.estimator or OWN else PAGE
        write_page(
            re.sub(r"\]\((?=\w+\.md)", "](../docs/", text) if place == BESIDE else text, place
        )
        save(error_over_latency(table), place.parent / "pictures" / f"{place.stem}.svg")


if __name__ == "__main__":
    main()
