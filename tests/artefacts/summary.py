"""States and numbers expected on a report's first screen, computed from its tables."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pytest
from scipy.stats import binom

from ur5lib.tables import read_csv, read_json

ESTIMATES = (
    *("Fmap", "least_squares", "observer", "repeat", "static", "controller_currents"),
    *("Fu", "F", "F*"),
)
MOST_WORDS = 180
FORCES = ["Fx", "Fy", "Fz"]
SEVERITIES = ["stop", "error", "warning", "note"]
SMALL = 5e-5  # Nm or A, below which nothing acts and no models differ
Rounded = tuple[float, int]  # a number, and the decimals with which it is shown


class Number(NamedTuple):
    """A number of a verdict: where it is, and the error of an estimate of zero there."""

    value: float
    place: str
    baseline: float = np.nan


class Verdict(NamedTuple):
    """What a verdict must state; share: of zero's error, in per cent, with which it begins."""

    state: str
    numbers: list[Number]
    share: float = np.nan


class Study(NamedTuple):
    """A study's tables by name, and the role of each recording."""

    tables: dict[str, pd.DataFrame]
    roles: pd.Series

    def moving(self) -> dict[str, list[int]]:
        """The joints that move on each recording."""
        rows = self.tables["recordings"].set_index("recording")["moving_joints"].dropna()
        return {
            name: [int(float(joint)) for joint in str(own).split()] for name, own in rows.items()
        }

    def loads(self) -> pd.DataFrame:
        payload = self.tables["payload"]
        return payload[payload["taken"] == "yes"]

    def quiet(self) -> pd.Index:
        """Recordings to validate on that carry no undeclared load."""
        return self.roles.index[self.roles == "validate"].difference(self.loads()["recording"])


def check_summary(report: Path, study: dict[str, Any]) -> None:
    """Every verdict's state, numbers and places, and every finding's numbers in order."""
    roles = pd.Series({own["name"]: own["role"] for own in study["recordings"]})
    tables = {path.stem: read_csv(path) for path in (report.parent / "tables").glob("*.csv")}
    known, told = Study(tables, roles), read_json(report.parent / "results.json")
    (listed,) = (own["sentences"] for own in told["lists"] if own["heading"] == "Findings")
    shown = [[own["value"] for own in stated(sentence)] for sentence in listed]
    for numbers, expected in zip(shown, findings(known), strict=True):
        assert len(numbers) == len(expected) <= 2
        for number, (value, digits) in zip(numbers, expected, strict=True):
            assert number == pytest.approx(value, abs=0.501 * 10**-digits)
    assert sum(len(own["text"].split()) for own in listed) <= MOST_WORDS
    cards = {own["topic"]: own for own in told["verdicts"]}
    for topic, judge in VERDICTS.items():
        if verdict := judge(known):
            check_verdict(cards[topic], verdict)
    check_quality(cards["Data quality"], known)


def stated(sentence: dict[str, Any]) -> Iterator[dict[str, float]]:
    """A sentence's numbers, errors among them."""
    for number in sentence["numbers"]:
        yield {"value": number["value"]}
        if number["std_error"] is not None:
            yield {"value": number["std_error"]}


def check_verdict(card: dict[str, Any], expected: Verdict) -> None:
    assert card["state"] == expected.state
    shown = [Number(own["value"], own["place"], own["baseline"]) for own in card["numbers"]]
    assert [own.place for own in shown] == [own.place for own in expected.numbers]
    for own, right in zip(shown, expected.numbers, strict=True):
        assert own.value == pytest.approx(right.value, rel=1e-5)
        assert own.baseline is None or own.baseline == pytest.approx(right.baseline, rel=1e-5)
    if np.isfinite(expected.share):
        assert card["sentence"]["numbers"][0]["value"] == pytest.approx(expected.share, abs=0.501)


def check_quality(card: dict[str, Any], study: Study) -> None:
    """How many findings of each severity, and on how many recordings there are serious ones."""
    rows = study.tables["quality"]
    counts = rows["severity"].value_counts().reindex(SEVERITIES, fill_value=0)
    assert [own["value"] for own in card["numbers"]] == [*counts]
    serious = rows[rows["severity"] != "note"]
    by_severity = "do not use" if counts["stop"] else "usable" if len(serious) else "good"
    assert card["state"] == by_severity
    places = [serious["recording"].nunique(), len(study.tables["recordings"])]
    expected = [*counts[counts > 0], *(places if len(serious) else [])]
    assert [own["value"] for own in stated(card["evidence"])] == expected


# Verdicts


def state(error: float, zero: float, good: bool = True) -> str:
    if error >= zero:
        return "do not use"
    return "good" if error < zero / 2 and good else "usable"


def largest(rows: pd.DataFrame, prefix: str, key: str, error: str, zero: str) -> Number:
    """The largest single error."""
    row = rows.loc[rows[error].idxmax()]
    return Number(row[error], f"{prefix}{row[key]} on {row['recording']}", row[zero])


def worst(rows: pd.DataFrame, key: str, error: str, zero: str) -> tuple[Any, float, float]:
    """Where the mean error is largest beside that of zero, and both."""
    means = rows.groupby(key, sort=False)[[error, zero]].mean()
    acting = means[means[zero] > SMALL]
    name = (acting[error] / acting[zero]).idxmax()
    return name, *acting.loc[name, [error, zero]]


def compared(study: Study) -> pd.DataFrame:
    """Torque errors in motion, unseen if possible, at the first motion."""
    rows = study.tables["torque_mae"].dropna(subset="mae")
    rows = rows[rows["recording"].isin([*study.moving()])]
    unseen = rows[rows["recording"].map(study.roles) != "fit"]
    rows = unseen if len(unseen) else rows
    return rows[rows["motion"] == rows["motion"].iloc[0]] if len(rows) else rows


def nearest(rows: pd.DataFrame) -> tuple[str, int, int]:
    """The model that is closest most often, on how many joints, of how many that differ."""
    means = rows.pivot_table("mae", "joint", "model")
    differ = means[means.max(axis=1) - means.min(axis=1) > SMALL]
    wins = differ.sub(differ.min(axis=1), axis=0).le(SMALL).sum()
    return str(wins.idxmax()), int(wins.max()), len(differ)


def link_model(study: Study) -> Verdict | None:
    if (rows := compared(study)).empty:
        return None
    own = rows[rows["model"] == nearest(rows)[0]]
    joint, error, zero = worst(own, "joint", "mae", "zero_mae")
    most = largest(own, "joint ", "joint", "mae", "zero_mae")
    unseen = study.roles[own["recording"].iloc[0]] != "fit"
    numbers = [Number(error, f"joint {joint}", zero), most]
    return Verdict(state(error, zero, unseen), numbers, 100 * error / zero)


def torque_constants(study: Study) -> Verdict | None:
    """The constant that is the largest factor off the known one."""
    rows = study.tables["friction"]
    rows = rows[rows["parameter"] == "torque_constant"]
    if rows.empty:
        return None
    row = rows.loc[np.log(rows["value"] / rows["known"]).abs().idxmax()]
    known = (rows["determined"] == "yes").all() and rows["contradicted"].isna().all()
    number = Number(row["value"], f"joint {row['joint']}", row["known"])
    return Verdict("good" if known else "usable", [number])


def currents(study: Study) -> Verdict | None:
    rows, moving = study.tables["current_rmse"], study.moving()
    rows = rows[(rows["model"] == "fitted") & rows["recording"].isin(study.quiet())]
    moves = [own.joint in moving.get(own.recording, []) for own in rows.itertuples()]
    rows = rows[np.array(moves, bool)]
    if rows.empty:
        return None
    rows = rows.assign(zero=rows["rmse_2hz"] / np.sqrt(1 - rows["r2"]))
    joint, error, zero = worst(rows, "joint", "rmse_2hz", "zero")
    least = rows.loc[rows["coverage95"].idxmin()]
    numbers = [
        Number(error, f"joint {joint}", zero),
        largest(rows, "joint ", "joint", "rmse_2hz", "zero"),
        Number(100 * least["coverage95"], f"joint {least['joint']} on {least['recording']}"),
    ]
    return Verdict(state(error, zero, least["coverage95"] >= 0.9), numbers, 100 * error / zero)


def motion(study: Study) -> Verdict | None:
    rows = study.tables["acceleration_mae"]
    rows = rows[rows["estimate"] == "encoders"]
    if rows.empty:
        return None
    component, error, zero = worst(rows, "component", "mae", "zero_mae")
    along = rows[rows["component"] == component]
    most = largest(along, "", "component", "mae", "zero_mae")
    return Verdict(state(error, zero), [Number(error, component, zero), most], 100 * error / zero)


def force(study: Study) -> Verdict | None:
    """Of the leading estimate, the largest error on recordings with contact that no fit has seen,
    the recording that is worst beside zero, and where the band holds least.
    """
    rows = in_contact(study.tables["force_mae"])
    unseen = rows["recording"].map(study.roles) != "fit"
    rows = rows[unseen & rows["component"].isin(FORCES)]
    if rows.empty:
        return None
    most = rows.loc[rows["mae"].idxmax()]
    name, error, zero = worst(rows, "recording", "mae", "mean_force")
    numbers = [
        Number(most["mae"], place(most), most["mean_force"]),
        Number(error, f"{name}, mean over x, y, z, in contact", zero),
    ]
    bands = rows["coverage95"].dropna()
    if len(bands):
        least = rows.loc[bands.idxmin()]
        numbers.append(Number(100 * least["coverage95"], place(least)))
    held = bands.empty or bands.min() >= 0.9
    good = held and pd.notna(most["mae_low"]) and most["estimate"] != "static"
    share = max(error / zero, most["mae"] / most["mean_force"])
    return Verdict(state(share, 1.0, good), numbers)


def place(row: pd.Series) -> str:
    return f"{row['recording']}, along {row['component'][1]}, in contact"


def in_contact(rows: pd.DataFrame) -> pd.DataFrame:
    """The errors of the leading estimate in contact."""
    rows = rows[(rows["kind"] == "compensated") & (rows["during"] == "contact")]
    lead = next((name for name in ESTIMATES if name in {*rows["estimate"]}), None)
    return rows[rows["estimate"] == lead]


VERDICTS = {
    "Link model": link_model,
    "Torque constants": torque_constants,
    "Friction and currents": currents,
    "Force in contact": force,
    "Motion": motion,
}


# Findings


def findings(study: Study) -> Iterator[list[Rounded]]:
    """The numbers of each sentence."""
    tables = study.tables
    if len(rows := compared(study)) and {*rows["model"]} > {rows["model"].iloc[0]}:
        _, near, differ = nearest(rows)
        yield [(near, 0), (differ, 0)] if differ else []
    if "printed" in tables and len(printed := tables["printed"]["status"]):
        yield [((printed == "equal").sum(), 0), (len(printed), 0)]
    for row in study.loads()[:4].itertuples():
        yield [(abs(row.mass), 2), (row.std_error, 2)]
    yield from contacts(study)
    if tables["friction"].empty:
        for row in tables["sensed"][:4].itertuples():
            yield [(row.largest_force_n, 1), (100 * row.share_in_contact, 0)]
    yield from detected(study)
    yield from claimed(study)
    moments = in_contact(tables["force_mae"])
    moments = moments[~moments["component"].isin(FORCES)]
    if (moments["determined"] == "yes").groupby(moments["component"]).any().eq(False).any():
        yield []
    if "truth" in tables and len(within := tables["truth"]["within95"].dropna()):
        yield from truths(len(within), int((within == "yes").sum()))


def truths(count: int, held: int) -> Iterator[list[Rounded]]:
    """How many intervals hold the truth, how many should, and the chance where that is small."""
    by_chance = binom(count, 0.95)
    chance = min(by_chance.sf(held - 1), by_chance.cdf(held))
    yield [(count, 0), (held, 0)]
    yield [(0.95 * count, 0), *([(100 * chance, 1)] if chance < 0.025 else [])]


def contacts(study: Study) -> Iterator[list[Rounded]]:
    """Contacts by recording without a sensor, and loads taken up."""
    searched = {*study.tables["detection"]["recording"]} - {*study.tables["force_mae"]["recording"]}
    found = study.tables["contacts"]
    found = found[found["estimate"] == "Fmap"]
    counts = found.loc[found["kind"] == "contact", "recording"].value_counts()
    touched = study.roles.index[study.roles == "contact"]
    for name in touched[touched.isin(searched)][:4]:
        yield [(counts[name], 0)] if name in counts else []
    for row in found[found["kind"] == "load"][:4].itertuples():
        yield [(row.load_mass, 2), (row.load_mass_std, 2)]


def detected(study: Study) -> Iterator[list[Rounded]]:
    """Contacts found, false alarms, and the smallest push along the worst axis."""
    rows = study.tables["detection"]
    rows = rows[rows["estimate"] == "Fmap"]
    least = rows[rows["force_class_n"] == rows["force_class_n"].min()]
    if len(least):
        yield [(least[name].sum(), 0) for name in ("found", "contacts")]
    quiet = rows[rows["recording"].isin(study.quiet())]
    if len(quiet):
        yield [(quiet["alarms_per_min"].mean(), 1)]
    free = rows[~rows["recording"].isin(study.loads()["recording"])]
    pushes = free[[f"smallest_force_95_{axis}" for axis in "xyz"]].dropna(how="all")
    if len(pushes) and pushes.notna().all(axis=None):
        yield [(pushes.median().max(), 0)]


def claimed(study: Study) -> Iterator[list[Rounded]]:
    """Pushes of the thesis's recording that its threshold of 10 N along z misses."""
    errors, rows = study.tables["force_mae"], study.tables["fixed_threshold"]
    printed = errors.loc[errors["printed_mae"].notna(), "recording"]
    own = rows["recording"].isin(printed) & (rows["estimate"] == "F*") & (rows["component"] == "Fz")
    if own.any():
        pushes, found = rows.loc[own, ["pushes", "found"]].sum()
        assert found < pushes
        yield [(pushes - found, 0), (pushes, 0)]
