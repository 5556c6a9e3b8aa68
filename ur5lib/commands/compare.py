"""Comparison of the numbers of two results, by topic: what changed by more than its error."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pandas as pd
from scipy.stats import norm

from ur5lib.finished import FinishedStudy
from ur5lib.tables import write_text
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

LEVEL = 0.05  # chance of any false change in a topic, and of a miss of a single interval
WORSE = 1.1  # ratio of two errors without interval from which they count as different
UNITS = {"torque_constant": "Nm/A", "viscous": "Nm s/rad", "load": ""}  # others: Nm
SEVERE = ["stop", "error", "warning"]
COLUMNS = ["study", "topic", "name", "before", "after", "differs", "changed"]


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


def compare_estimates(
    topic: str, rows: pd.DataFrame, names: Sequence[str], unit: Sequence[str]
) -> list[Comparison]:
    """Compare estimates by their 95 % intervals, as independent normal variables.

    rows: one pair of estimates each, with columns `value` and `half` (half of the interval's width)
    that have the suffixes `_a` (before) and `_b` (after); names, unit: of each row. An estimate has
    changed if the difference exceeds its interval, widened by Bonferroni's correction for the
    number of rows.
    """
    # `to_numpy(float)` also gives the right shape and type without rows.
    numbers = rows[["value_a", "value_b", "half_a", "half_b"]].to_numpy(float)
    difference = np.abs(numbers[:, 1] - numbers[:, 0])
    half = np.hypot(numbers[:, 2], numbers[:, 3])
    wider = norm.isf(LEVEL / 2 / max(len(rows), 1)) / norm.isf(LEVEL / 2)
    texts = [
        [*map(_with_error, rows[f"value_{side}"], rows[f"half_{side}"], unit)] for side in "ab"
    ]
    verdicts = ((difference > half).tolist(), (difference > wider * half).tolist())
    return [Comparison(topic, *row) for row in zip(names, *texts, *verdicts, strict=True)]


def _ratio(before: Array, after: Array) -> Array:
    """Return the ratio, at least 1, of the larger to the smaller error; 1 where both are zero."""
    low, high = np.minimum(before, after), np.maximum(before, after)
    ratio: Array = np.divide(high, low, out=np.full(len(low), np.inf), where=low > 0)
    return np.where(high == 0, 1.0, ratio)


def _with_error(value: float, half: float, unit: str) -> str:
    return f"{value:.4g} ± {half:.2g} {unit}".strip()


def compare(before: Path, after: Path) -> list[Comparison]:
    """Compare all numbers that the results of two studies, results/<study>, have in common.

    Raises InputError where a folder holds no results.
    """
    studies = FinishedStudy(before), FinishedStudy(after)
    return [one for topic in TOPICS.values() for one in topic(*studies)]


def friction(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare torque constants, offsets and friction that the data determine."""
    keys = ["robot", "joint", "parameter"]
    rows = _both(before, after, "friction", keys)
    rows = rows[(rows["determined_a"] == "yes") & (rows["determined_b"] == "yes")]
    for side in "ab":
        rows[f"half_{side}"] = (rows[f"high_{side}"] - rows[f"low_{side}"]) / 2
    names = [f"{r.robot}, joint {r.joint}, {_words(r.parameter)}" for r in rows.itertuples()]
    return compare_estimates(
        "friction", rows, names, [UNITS.get(name, "Nm") for name in rows["parameter"]]
    )


def model(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare base parameters that the data determine, and rotor inertias."""
    rows = _both(before, after, "parameters", ["robot", "parameter"])
    rows = rows[(rows["determined_a"] == "yes") & (rows["determined_b"] == "yes")]
    names = [f"{r.robot}, {r.parameter}" for r in rows.itertuples()]
    rotors = _both(before, after, "rotor_inertia", ["robot", "joint"])
    names += [f"{r.robot}, joint {r.joint}, rotor inertia" for r in rotors.itertuples()]
    units = [""] * len(rows) + ["kg m²"] * len(rotors)
    pairs = pd.concat([_halves(rows), _halves(rotors)], ignore_index=True)
    return compare_estimates("model", pairs, names, units)


def payload(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the undeclared masses on the flange."""
    rows = _both(before, after, "payload", ["recording"])
    rows = _halves(rows.rename(columns={"mass_a": "value_a", "mass_b": "value_b"}))
    return compare_estimates("payload", rows, [*rows["recording"]], ["kg"] * len(rows))


def currents(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the errors of predicted currents below 2 Hz."""
    rows = _both(before, after, "current_rmse", ["model", "recording", "joint"])
    rows = rows[rows["model"] == "fitted"]
    errors = rows["rmse_2hz_a"], rows["rmse_2hz_b"]
    changed = _ratio(*(side.to_numpy(float) for side in errors)) > WORSE  # they have no interval
    names = [f"{r.recording}, joint {r.joint}" for r in rows.itertuples()]
    return [
        Comparison("currents", name, f"{a:.3g} A", f"{b:.3g} A", bool(is_new), bool(is_new))
        for name, a, b, is_new in zip(names, *errors, changed, strict=True)
    ]


def force(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the errors of F^map in contact by their intervals over contacts."""
    keys = ["recording", "kind", "estimate", "during", "component"]
    rows = _both(before, after, "force_mae", keys)
    compared = (rows["kind"] == "compensated") & (rows["estimate"] == "Fmap")
    rows = rows[compared & (rows["during"] == "contact") & rows["component"].str.startswith("F")]
    for side in "ab":
        rows[f"value_{side}"] = rows[f"mae_{side}"]
        rows[f"half_{side}"] = (rows[f"mae_high_{side}"] - rows[f"mae_low_{side}"]) / 2
    names = [f"{r.recording}, {r.component}" for r in rows.itertuples()]
    return compare_estimates("force", rows, names, ["N"] * len(rows))


def data(before: FinishedStudy, after: FinishedStudy) -> list[Comparison]:
    """Compare the findings about the recordings' files, notes excepted."""
    counts = [_findings(study) for study in (before, after)]
    comparisons = []
    for key in sorted(counts[0].keys() | counts[1].keys()):
        old, new = (by_key.get(key, 0) for by_key in counts)
        comparisons.append(Comparison("data", key, str(old), str(new), old != new, old != new))
    return comparisons


TOPICS: dict[str, Callable[[FinishedStudy, FinishedStudy], list[Comparison]]] = {
    "data": data,
    "model": model,
    "friction": friction,
    "payload": payload,
    "currents": currents,
    "force": force,
}


def _both(
    before: FinishedStudy, after: FinishedStudy, table: str, keys: Sequence[str]
) -> pd.DataFrame:
    """Return the common rows of a table, its columns with the suffixes _a (before) and _b."""
    one, other = before.table(table), after.table(table)
    return one.merge(other, on=list(keys), suffixes=("_a", "_b"))


def _halves(rows: pd.DataFrame) -> pd.DataFrame:
    """Add half the width of the 95 % intervals, from `std_error`."""
    return rows.assign(**{f"half_{side}": NORMAL95 * rows[f"std_error_{side}"] for side in "ab"})


def _findings(study: FinishedStudy) -> dict[str, int]:
    rows = study.table("quality")
    rows = rows[np.isin(rows["severity"], SEVERE)]
    return {f"{r.recording}, {r.device}: {r.finding}": int(r.count) for r in rows.itertuples()}


def _words(name: str) -> str:
    return name.replace("_", " ")


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
