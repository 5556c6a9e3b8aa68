"""Cut-off and friction terms chosen by cross-validation: a table of docs/api.md.

    python -m benchmarks.choice [--folder raw/ur10e] [--page]

The search of that page on three paths of a UR10e (`ur5 fetch ur10e`): the error of currents on the
path left out, over that of a constant current, nothing low-passed, mean and standard deviation over
the paths. A fit that a stop sign forbids is refused. `--page` writes the table; `--quick` searches
among fewer.
"""

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sklearn.exceptions import FitFailedWarning
from sklearn.model_selection import GridSearchCV

import ur5lib
from benchmarks.harness.markdown import markdown
from benchmarks.harness.options import options_of
from ur5lib.tables import write_text

PAGE = Path(__file__).parents[1] / "docs" / "api.md"
PATHS = ["20_01_17-ptp_10_points", "20_02_12-50sec_12harm", "20_02_19_14harm50sec"]
CHOICES: dict[str, list[Any]] = {"cutoff_hz": [1.0, 2.0, 5.0], "terms": [(), ("velocity_root",)]}
HEAD = ["cut-off [Hz]", "terms", "NRMSE"]


def main() -> None:
    """Search, print and write."""
    options = options_of(__doc__)
    options.add_argument("--folder", type=Path, default=Path("raw/ur10e"))
    options.add_argument("--page", action="store_true", help="write docs/api.md as well")
    given = options.parse_args()
    runs = ur5lib.read([given.folder / f"ur-{path}.csv" for path in PATHS], "ur10e")
    choices = CHOICES | {"cutoff_hz": [1.0]} if given.quick else CHOICES
    text = markdown(HEAD, rows(searched(runs, choices)))
    print(text)
    if given.page:
        page = PAGE.read_text(encoding="utf-8")
        write_text(re.sub(rf"\| {re.escape(HEAD[0])} \|.*\n(\|.*\n)+", f"{text}\n", page), PAGE)


def searched(runs: ur5lib.Recordings, choices: dict[str, list[Any]]) -> GridSearchCV:
    """Return the search of the page, done on recordings."""
    search = GridSearchCV(ur5lib.Model(), choices, scoring=ur5lib.nrmse, cv=len(runs), refit=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FitFailedWarning)
        warnings.filterwarnings("ignore", "One or more of the test scores are non-finite")
        return search.fit(runs)


def rows(search: GridSearchCV) -> list[list[str]]:
    """Return a line for each choice; the best is bold."""
    found = search.cv_results_
    lines = []
    for k, choice in enumerate(found["params"]):
        mean, std = -found["mean_test_score"][k], found["std_test_score"][k]
        score = "refused" if mean != mean else f"{mean:.3f} ± {std:.3f}"
        score = f"**{score}**" if k == search.best_index_ else score
        lines.append([f"{choice['cutoff_hz']:g}", terms_in_words(choice["terms"]), score])
    return lines


def terms_in_words(terms: Sequence[str]) -> str:
    """Return the terms as a cell of the table."""
    return ", ".join(terms) or "none"


if __name__ == "__main__":
    main()
