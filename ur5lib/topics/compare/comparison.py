"""Comparison of the numbers of two results, by topic: what changed by more than its error."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from os.path import isfile  # unlike pathlib's, of names that are too long, too
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
from scipy.stats import norm

from ur5lib.errors import InputError
from ur5lib.force.estimators import LEADING
from ur5lib.records.codes import Found
from ur5lib.records.friction import without_totals
from ur5lib.tables import intact, read_csv, write_text
from ur5lib.timeseries.metrics import NORMAL95

ERROR_CHANCE = 0.05  # of any false change in a topic; a single interval misses with it, too
CHANGED_RATIO = 1.1  # two errors without intervals count as different from this ratio on
PARAMETER_UNITS = {  # all others have the unit Nm
    **{"torque_constant": "Nm/A", "gain": "Nm/Nm", "viscous": "Nm s/rad", "load": ""}
}
WITH_DETERMINED = ["parameters", "friction"]  # tables with a column `determined`
COMPARED_SEVERITIES = ["stop", "error", "warning"]
StudyPair = tuple[Path, Path]  # folders of results before and after
PAIR_COLUMNS = ("value_a", "value_b", "half_a", "half_b")  # estimates, half of their intervals
CHANGE_COLUMNS = ["study", "topic", "name", "before", "after", "differs", "changed"]


@dataclass(frozen=True)
class Comparison:
    """One number in two results, and whether it has changed between them.

    topic, name: of the number; before, after: its values with errors, as text; differs: whether the
    difference exceeds its 95 % interval; changed: whether it also exceeds the interval widened for
    the number of comparisons in the topic.
    """

    topic: str
    name: str
    before: str
    after: str
    differs: bool
    changed: bool

    def sentence(self) -> str:
        """Return the name and both values as a sentence."""
        return f"{self.name}: {self.before} before, {self.after} now"


def compare(before: Path, after: Path) -> list[Comparison]:
    """Return the comparisons of all numbers that two studies have in common; before, after: their
    folders results/<study>.

    Raises InputError where a table is missing or damaged.
    """
    return [comparison for topic in TOPICS.values() for comparison in topic((before, after))]


def compare_estimates(
    topic: str, rows: pd.DataFrame, names: Sequence[str], unit: Sequence[str]
) -> Iterator[Comparison]:
    """Yield comparisons of estimates by their 95 % intervals, as independent normal variables.

    rows: one pair of estimates each, with columns `value` and `half` (half of the interval's width)
    that have the suffixes `_a` (before) and `_b` (after); names, unit: of each row. An estimate has
    changed if the difference exceeds its interval, widened by Bonferroni's correction for the
    number of rows.
    """
    # `to_numpy(float)` also gives the right shape and type without rows.
    value_a, value_b, half_a, half_b = rows[list(PAIR_COLUMNS)].to_numpy(float).T
    difference, half = np.abs(value_b - value_a), np.hypot(half_a, half_b)
    wider = norm.isf(ERROR_CHANCE / 2 / max(len(rows), 1)) / norm.isf(ERROR_CHANCE / 2)
    texts = (map(_with_error, rows[f"value_{side}"], rows[f"half_{side}"], unit) for side in "ab")
    verdicts = ((difference > half).tolist(), (difference > wider * half).tolist())
    for row in zip(names, *texts, *verdicts, strict=True):
        yield Comparison(topic, *row)


def _with_error(value: float, half: float, unit: str) -> str:
    return f"{value:.4g} ± {half:.2g} {unit}".strip()


def data(studies: StudyPair) -> Iterator[Comparison]:
    """Yield comparisons of the findings about the files of recordings that both have, without
    notes.
    """
    keys, counts = ["recording", "device", "finding", "severity"], list[dict[str, int]]()
    tables = [_read(study, "quality", keys, ["count"]) for study in studies]
    named = [{*_read(study, "recordings", ["recording"], [])["recording"]} for study in studies]
    for rows in tables:
        rows = rows.assign(code=rows.get("code", rows["finding"]))  # 1.0 has no codes
        severe = rows["severity"].isin(COMPARED_SEVERITIES)
        compared = rows[severe & rows["recording"].isin(named[0] & named[1])].itertuples()
        counts.append(
            {f"{r.recording}, {r.device}: {Found(r.code).words}": int(r.count) for r in compared}
        )
    for name in sorted(counts[0].keys() | counts[1].keys()):
        old, new = (by_name.get(name, 0) for by_name in counts)
        yield Comparison("data", name, str(old), str(new), old != new, old != new)


def model(studies: StudyPair) -> Iterator[Comparison]:
    """Yield comparisons of base parameters that the data determine, and of rotor inertias."""
    rows = _determined(_both(studies, "parameters", "robot", "parameter", more=["std_error"]))
    names = [f"{r.robot}, {r.parameter}" for r in rows.itertuples()]
    rotors = _both(studies, "rotor_inertia", "robot", "joint", more=["std_error"])
    names += [f"{r.robot}, joint {r.joint}, rotor inertia" for r in rotors.itertuples()]
    units = [""] * len(rows) + ["kg m²"] * len(rotors)
    pairs = pd.concat([_by_std_error(rows), _by_std_error(rotors)], ignore_index=True)
    return compare_estimates("model", pairs, names, units)


def friction(studies: StudyPair) -> Iterator[Comparison]:
    """Yield comparisons of torque constants, offsets and friction that the data determine."""
    rows = _determined(
        _both(studies, "friction", "robot", "joint", "parameter", more=["low", "high"])
    )
    rows = without_totals(rows)
    names = [
        f"{r.robot}, joint {r.joint}, {r.parameter.replace('_', ' ')}" for r in rows.itertuples()
    ]
    units = [PARAMETER_UNITS.get(name, "Nm") for name in rows["parameter"]]
    return compare_estimates("friction", _by_interval(rows, "low", "high"), names, units)


def payload(studies: StudyPair) -> Iterator[Comparison]:
    """Yield comparisons of the undeclared masses on the flange."""
    rows = _by_std_error(_both(studies, "payload", "recording", value="mass", more=["std_error"]))
    return compare_estimates("payload", rows, [*rows["recording"]], ["kg"] * len(rows))


def currents(studies: StudyPair) -> Iterator[Comparison]:
    """Yield comparisons of the errors of predicted currents, low-passed, which have no interval."""
    rows = _both(studies, "current_rmse", "model", "recording", "joint", value="rmse_lowpassed")
    for row in rows[rows["model"] == "fitted"].itertuples():
        low, high = sorted((row.value_a, row.value_b))
        changed = bool(high > CHANGED_RATIO * low)
        before, after = (f"{error:.3g} A" for error in (row.value_a, row.value_b))
        name = f"{row.recording}, joint {row.joint}"
        yield Comparison("currents", name, before, after, changed, changed)


def force(studies: StudyPair) -> Iterator[Comparison]:
    """Yield comparisons of the leading estimate's errors in contact, by their intervals over
    contacts.
    """
    keys = "recording", "kind", "estimate", "during", "component"
    rows = _both(studies, "force_mae", *keys, value="mae", more=["mae_low", "mae_high"])
    compared = (rows["kind"] == "compensated") & (rows["estimate"] == LEADING)
    rows = rows[compared & (rows["during"] == "contact") & rows["component"].str.startswith("F")]
    names = [f"{r.recording}, {r.component}" for r in rows.itertuples()]
    rows = _by_interval(rows, "mae_low", "mae_high")
    return compare_estimates("force", rows, names, ["N"] * len(rows))


# Results built before 0.2.0 have these names of columns; an update can be compared with them.
OLDER_NAMES = {"rmse_lowpassed": "rmse_2hz"}
TOPICS: dict[str, Callable[[StudyPair], Iterator[Comparison]]] = {
    "data": data,
    "model": model,
    "friction": friction,
    "payload": payload,
    "currents": currents,
    "force": force,
}


def _both(
    studies: StudyPair, table: str, *keys: str, value: str = "value", more: Sequence[str] = ()
) -> pd.DataFrame:
    """Return the rows that a table has in both studies, with the columns of the one before as
    <name>_a and of the one after as <name>_b; keys: columns that identify a row.

    value: the column of what is compared, which becomes `value_a` and `value_b`; more: other
    columns of numbers. Raises as `_read`.
    """
    before, after = (_read(study, table, keys, [value, *more]) for study in studies)
    before, after = (rows.rename(columns={value: "value"}) for rows in (before, after))
    return before.merge(after, on=[*keys], suffixes=("_a", "_b"))


def _read(study: Path, table: str, keys: Sequence[str], numbers: Sequence[str]) -> pd.DataFrame:
    """Return a table. Raises InputError if it or a column is missing, or a cell has the wrong
    type.
    """
    path = study / "tables" / f"{table}.csv"
    if not isfile(path):
        raise InputError(
            f"{study} has no table {table!r}; `ur5 run` its study, and name the folder "
            "results/<study>"
        )
    rows = read_csv(path).rename(columns={old: new for new, old in OLDER_NAMES.items()})
    with intact(path):
        for name in [*keys, *numbers, *["determined"] * (table in WITH_DETERMINED)]:
            if name not in rows:
                raise ValueError(f"it has no column {name}")
        for name in {*numbers, "joint"} & {*rows}:
            rows[name].astype(float)
        if "determined" in rows and not rows["determined"].isin(["yes", "no"]).all():
            raise ValueError("determined is neither yes nor no")
    return rows


def _determined(rows: pd.DataFrame) -> pd.DataFrame:
    return rows[(rows["determined_a"] == "yes") & (rows["determined_b"] == "yes")]


def _by_std_error(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows with the column `half`, half the width of the 95 % intervals, from
    `std_error`.
    """
    return rows.assign(**{f"half_{side}": NORMAL95 * rows[f"std_error_{side}"] for side in "ab"})


def _by_interval(rows: pd.DataFrame, low: str, high: str) -> pd.DataFrame:
    """Return rows with the column `half`, half the width of the 95 % intervals, from the columns of
    their ends.
    """
    width = {side: rows[f"{high}_{side}"] - rows[f"{low}_{side}"] for side in "ab"}
    return rows.assign(half_a=width["a"] / 2, half_b=width["b"] / 2)


def lines(comparisons: Sequence[Comparison]) -> Iterator[str]:
    """Yield lines of text: for each topic the number of comparisons, then each change."""
    for topic in TOPICS:
        in_topic = [comparison for comparison in comparisons if comparison.topic == topic]
        if not in_topic:
            yield f"{topic}: nothing to compare"
            continue
        differ = sum(comparison.differs for comparison in in_topic)
        changed = [comparison for comparison in in_topic if comparison.changed]
        count = len(in_topic)
        yield f"{topic}: {count} compared, {differ} beyond their error, {len(changed)} changed"
        yield from (f"  {comparison.sentence()}" for comparison in changed)


def rows(study: str, comparisons: Sequence[Comparison]) -> Iterator[dict[str, str]]:
    """Yield each comparison as a row of changes.csv; study: name of the study compared with."""
    in_words = {True: "yes", False: "no"}
    for comparison in comparisons:
        cells = vars(comparison).items()
        yield {"study": study} | {name: in_words.get(value, value) for name, value in cells}


def write_junit(comparisons: Sequence[Comparison], path: Path) -> None:
    """Write JUnit XML with one test case per comparison, which fails if the number has changed."""
    suites = ElementTree.Element("testsuites")
    for topic in TOPICS:
        in_topic = [comparison for comparison in comparisons if comparison.topic == topic]
        failures = str(sum(comparison.changed for comparison in in_topic))
        counts = {"tests": str(len(in_topic)), "failures": failures}
        suite = ElementTree.SubElement(suites, "testsuite", {"name": topic} | counts)
        for comparison in in_topic:
            case = ElementTree.SubElement(suite, "testcase", classname=topic, name=comparison.name)
            if comparison.changed:
                ElementTree.SubElement(case, "failure", message=comparison.sentence())
    write_text(ElementTree.tostring(suites, encoding="unicode", xml_declaration=True), path)
