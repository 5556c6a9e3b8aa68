"""What to expect: the numbers of built studies by arm, sensor, paths and dates.

    python -m benchmarks.expected [<study> ...] [--page]

Prints a row for each study in results/, by default of all public recordings and the demo; `--page`
writes them into docs/expect.md. Without names, `--quick` takes those that are built.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import yaml

from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import built, study_options
from ur5lib.force.residual_model import few_paths
from ur5lib.records.friction import Friction
from ur5lib.tables import read_csv, read_record

RESULTS_FOLDER = Path("results")
PROJECT = Path(__file__).parents[1]
PAGE, TITLE = PROJECT / "docs" / "expect.md", "By arm"  # of the section
STUDIES = ["demo", "thesis", "ur10e", "ur3-cb", "ur10-bag", "kuka-kr300"]
PATHS_TITLE, PATHS = "By number of paths", (1, 2, 3, 5, 10)
CONTACT_N = 5  # force at the sensor from which on contacts are counted


class Row(NamedTuple):
    """A study's results on one arm, as the page shows them."""

    arm: str
    recorded: str
    sensor: str
    fitted: str
    force: str
    found: str
    band: str
    push: str
    constants: str
    currents: str


HEADS = Row(
    arm="arm",
    recorded="recorded",
    sensor="sensor",
    fitted="fitted to",
    force="force error in contact, of the mean force [N]: best to worst recording",
    found=f"contacts of {CONTACT_N} N found; none missed from",
    band="in 95 % band",
    push="trial push of 1 s found with 95 % along x, y, z [N]: best to worst motion",
    constants="constants that may be used, 95 % at most",
    currents="error of currents",
)


def main() -> None:
    """Print the rows, and write them."""
    options = study_options(__doc__)
    options.set_defaults(studies=STUDIES)
    options.add_argument("--page", action="store_true", help="write docs/expect.md as well")
    given = options.parse_args()
    folders = [RESULTS_FOLDER / name for name in given.studies]
    if given.quick and given.studies == STUDIES:
        folders = [folder for folder in folders if (folder / "results.json").exists()]
    rows = [row for folder in built(folders) for row in rows_of(folder)]
    found = markdown(HEADS, rows)
    print(found)
    if given.page:
        page = replaced(read_page(PAGE), TITLE, found)
        write_page(replaced(page, PATHS_TITLE, by_paths()), PAGE)


def by_paths() -> str:
    """Return the factor by which few paths widen a force's band, by their number."""
    factors = [f"{few_paths(paths):.1f}" for paths in PATHS]
    return markdown(
        ["paths of the fit", *map(str, PATHS)], [["a force's band is wider by", *factors]]
    )


def rows_of(folder: Path) -> Iterator[Row]:
    """Yield a row for each arm with a fit in a study."""
    study = yaml.safe_load((folder / "configuration.yaml").read_text())
    entries = pd.DataFrame(study["recordings"])
    tables = {path.stem: read_csv(path) for path in (folder / "tables").glob("*.csv")}
    for path in sorted((folder / "parameters").glob("*/friction.json")):
        friction, arm = read_record(Friction, path), path.parent.name
        own = {name: of_arm(rows, arm, entries) for name, rows in tables.items()}
        simulated = entries.get("simulate", pd.Series(dtype=object)).notna().any()
        yield Row(
            arm=arm + (", simulated" if simulated else ""),
            recorded="torques" if "torque" in friction.effort else "currents",
            sensor="force sensor" if len(own["sensed"]) else "none",
            fitted=", ".join(
                [counted(friction.paths, "path"), counted(dates(entries, friction), "date")]
            ),
            force=force_error(own["force_mae"]),
            found=contacts_found(verdicts(tables, "contacts", "")),
            band=band(own["force_mae"]),
            push=pushes(own["pushes"]),
            constants=constants(verdicts(tables, "constants", arm)),
            currents=currents(own["current_rmse"], entries),
        )


def of_arm(rows: pd.DataFrame, arm: str, entries: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of a table about an arm or its recordings."""
    if "robot" in rows:
        return rows[rows["robot"] == arm]
    names = entries.loc[entries["robot"] == arm, "name"] if "robot" in entries else entries["name"]
    return rows[rows["recording"].isin(names)] if "recording" in rows else rows


def dates(entries: pd.DataFrame, friction: Friction) -> int:
    """Return the number of dates of the fit's recordings, 1 if none is known."""
    if "date" not in entries:
        return 1
    fitted = entries["name"].isin(friction.from_)
    return max(1, entries.loc[fitted, "date"].nunique())


def counted(count: int, noun: str) -> str:
    """Return a number with its noun."""
    return f"{count} {noun}{'' if count == 1 else 's'}"


def force_error(rows: pd.DataFrame) -> str:
    """Return the least and largest error of a recording, mean over axes, beside the mean force."""
    own = in_contact(rows)
    if own.empty:
        return ""
    means = own.groupby("recording")[["mae", "mean_force"]].mean().sort_values("mae")
    return " to ".join(f"{row.mae:.1f} of {row.mean_force:.0f}" for row in ends(means))


def in_contact(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of F̂ᵐᵃᵖ's force in contact, beside the compensated sensor."""
    if rows.empty:
        return rows
    return rows[
        (rows["kind"] == "compensated")
        & (rows["during"] == "contact")
        & (rows["estimate"] == "Fmap")
        & rows["component"].str.startswith("F")
    ]


def ends(rows: pd.DataFrame) -> list:
    """Return the first and the last row, one if there is only one."""
    found = [*rows.itertuples()]
    return [found[0], found[-1]] if len(found) > 1 else found


def verdicts(tables: dict[str, pd.DataFrame], question: str, arm: str) -> pd.DataFrame:
    """Return the verdicts on a question about an arm, or the study."""
    rows = tables["verdicts"]
    return rows[(rows["question"] == question) & (rows["arm"].fillna("") == arm)]


def contacts_found(rows: pd.DataFrame) -> str:
    """Return the number of found contacts at the sensor, and the force above which all are."""
    if rows.empty:
        return ""
    first, from_ = rows.iloc[0], rows.dropna(subset="value")[:1]
    words = "".join(f", {row.value:.0f} N" for row in from_.itertuples())
    return f"{first['count']:.0f} of {first['of']:.0f}{words}"


def band(rows: pd.DataFrame) -> str:
    """Return the least and most share of readings in the band, by axis and recording."""
    shares = in_contact(rows)["coverage95"].dropna() if len(rows) else pd.Series(dtype=float)
    return f"{shares.min():.2f} to {shares.max():.2f}" if len(shares) else ""


def pushes(rows: pd.DataFrame) -> str:
    """Return the pushes along x, y, z found with 95 %, in the best and in the worst motion."""
    stated = rows.dropna(subset="value").sort_values("axis")
    whole = {motion: part for motion, part in stated.groupby("motion") if len(part) == len("xyz")}
    ordered = sorted(whole, key=lambda motion: float(whole[motion]["value"].max()))
    ends = dict.fromkeys([*ordered[:1], *ordered[-1:]])
    return " to ".join(f"{along_axes(whole[motion])} ({motion})" for motion in ends)


def along_axes(rows: pd.DataFrame) -> str:
    """Return the pushes along x, y, z; `>` and the largest trial if it was not found."""
    return ", ".join(
        f"{'> ' if bound == '>' else ''}{value:.0f}"
        for value, bound in rows[["value", "bound"]].to_numpy()
    )


def constants(rows: pd.DataFrame) -> str:
    """Return the number of joints with a usable constant, and the widest 95 % interval of one."""
    if rows["count"].isna().all():
        return ""
    first, widest = rows.iloc[0], rows[rows["quantity"].str.startswith("widest")]
    spread = "".join(f", ± {row.value:.0f} %" for row in widest.itertuples())
    return f"{first['count']:.0f} of {first['of']:.0f}{spread}"


def currents(rows: pd.DataFrame, entries: pd.DataFrame) -> str:
    """Return the NRMSE of recordings of the role `validate`, median and worst joint."""
    judged = entries.loc[entries["role"] == "validate", "name"]
    unseen = (rows["model"] == "fitted") & (rows["fitted"] == "no")
    own = rows[unseen & rows["recording"].isin(judged)].dropna(subset="r2")
    if own.empty:
        return ""
    by_joint = np.sqrt(1 - own.groupby("joint")["r2"].median().clip(upper=1))
    return f"{by_joint.median():.0%}, worst joint {by_joint.max():.0%}".replace("%", " %")


if __name__ == "__main__":
    main()
