"""What more paths buy: errors of the force and of currents by how many paths are fitted.

    python -m benchmarks.paths [<study>[:<robot>] ...] [--page] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. DRAWS times, a path is left out
(with its day, as by `benchmarks.leave_out`), and none, one, two, ... of the others, in an order
drawn with a seed, are fitted: friction, residual model and threshold. Judged are, of each draw, the
same recordings: those with a force sensor, and drawn pushes (as of `benchmarks.worth`) on those of
the path left out and on other unseen ones without contact; of these, the currents' error, too, over
that of a constant current (NRMSE, of all joints and recordings together). `--page` writes the table
into docs/how_much.md.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import study_options
from benchmarks.leave_out import Fold, Recording, Study, refusal, unseen, without_each
from benchmarks.worth import arm_of, counts, is_judged
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.prediction import Prediction
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record

NUMBERS, DRAWS, SEED = (0, 1, 2, 3, 5, 7), 4, 0
FIGURES = ["error [N]", "in band", "score [N]", "found"]
KINDS = {"sensor": "by a sensor", "pushes": "drawn pushes"}
PAGE, TITLE = Path(__file__).parents[1] / "docs" / "how_much.md", "By number of paths"


def main() -> None:
    """Print a line for each arm and number of paths, and write them."""
    options = study_options(__doc__)
    options.set_defaults(studies=["demo"])
    options.add_argument("--page", action="store_true", help="write docs/how_much.md as well")
    given = options.parse_args()
    torch.set_num_threads(1)
    arms = {name: arm_of(name) for name in given.studies}
    rows = {name: pd.DataFrame(by_paths(arm, given.quick)) for name, arm in arms.items()}
    lines = [
        [load_robot(arm.arm).name, *line]
        for name, arm in arms.items()
        for line in table(rows[name])
    ]
    columns = [f"{KINDS[by]}: {name}" for by in KINDS for name in FIGURES]
    found = markdown(["arm", "paths", *columns, "error of currents"], lines)
    print(found)
    if given.page:
        write_page(replaced(read_page(PAGE), TITLE, found), PAGE)


def by_paths(study: Study, quick: bool) -> Iterator[dict[str, Any]]:
    """Yield the counts of each draw of paths."""
    for paths, fitted, tested in draws(study, quick):
        with tempfile.TemporaryDirectory() as folder:
            fold = Fold(study, fitted, Path(folder))
            if why := refusal(fold, tested):
                print(f"{paths} paths: {why}")
                continue
            prior = ContactPrior.of(fold.arm, study.settings.contact.force_n, ContactPlace())
            for counted in [*counts(fold, tested, prior), *currents(fold, tested)]:
                yield {"paths": paths} | counted


def draws(study: Study, quick: bool) -> Iterator[tuple[int, list[Recording], list[Recording]]]:
    """Yield how many paths are fitted, and the fitted and the judged recordings."""
    random, always = np.random.default_rng(SEED), unseen(study, study.fit)
    folds = without_each(study)
    chosen = [folds[k] for k in random.permutation(len(folds))[: 1 if quick else DRAWS]]
    most = min(len({own.path for own in others}) for _, others, _ in chosen)
    numbers = [*(number for number in NUMBERS if number < most), most]
    for _, others, left in chosen:
        tested = [own for own in [*always, *left] if is_judged(own)]
        paths = random.permutation(sorted({own.path for own in others}))
        for number in numbers[: 2 if quick else None]:
            yield number, [own for own in others if own.path in paths[:number]], tested


def currents(fold: Fold, tested: list[Recording]) -> Iterator[dict[str, Any]]:
    """Yield the error of each recording's currents, where nothing touches the arm."""
    for own in tested:
        scores = read_record(Prediction, fold.own(own, "currents.json")).scores
        if own.entry["role"] != "contact" and "fitted" in scores:
            rmse, zero = (
                np.nansum(getattr(scores["fitted"], name) ** 2)
                for name in ("rmse_lowpassed", "zero_rmse_lowpassed")
            )
            yield {"by": "currents", "off": float(rmse), "zero": float(zero)}


def table(rows: pd.DataFrame) -> Iterator[list[str]]:
    """Yield the cells of a line for each number of paths."""
    sums = rows.groupby(["paths", "by"], sort=False).sum()
    for paths in sorted(rows["paths"].unique()):
        told = [cell for by in KINDS for cell in in_contact(sums, paths, by)]
        yield [f"{paths}", *told, of_currents(sums, paths)]


def in_contact(sums: pd.DataFrame, paths: int, by: str) -> list[str]:
    """Return the cells of FIGURES, empty where nothing is touched."""
    if (paths, by) not in sums.index:
        return [""] * len(FIGURES)
    own = sums.loc[paths, by]
    rmse, inside = np.sqrt(own["square"] / own["samples"]), own["inside"] / own["samples"]
    score, found = own["score"] / own["samples"], own["found"] / own["contacts"]
    return [f"{rmse:.1f}", f"{inside:.2f}", f"{score:.0f}", f"{found:.0%}"]


def of_currents(sums: pd.DataFrame, paths: int) -> str:
    """Return the NRMSE of currents, empty where each recording is in contact."""
    if (paths, "currents") not in sums.index:
        return ""
    own = sums.loc[paths, "currents"]
    return f"{np.sqrt(own['off'] / own['zero']):.0%}"


if __name__ == "__main__":
    main()
