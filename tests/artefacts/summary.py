"""The numbers expected in a report's summary, computed from its tables in plain Python."""

import csv
import html
import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import mean, median
from typing import Any

Row = dict[str, str]
NEW = ("Fmap", "least_squares", "observer", "repeat")
ESTIMATES = (*NEW, "Fu", "F", "F*")


def check_summary(report: Path, study: dict[str, Any]) -> None:
    """Every number of every sentence of the summary, in order."""
    roles = {recording["name"]: recording["role"] for recording in study["recordings"]}
    tables = report.parent / "tables"
    text = html.unescape(report.read_text())
    (summary,) = re.findall(r"<ul>(?:(?!<ul>).)*?Findings about.*?</ul>", text, re.DOTALL)
    told = [
        re.findall(r"(?<![\w.])\d+(?:\.\d+)?", without_names(sentence, roles))
        for sentence in re.findall(r"<li>(.*?)</li>", summary, re.DOTALL)
    ]
    assert told == [*expected(tables, roles)]


def without_names(sentence: str, roles: dict[str, str]) -> str:
    """A sentence without the digits of names, of what is fixed, and of bounds' signs."""
    fixed = ["joints 1 to 6", "below 2 Hz", "95 % interval", "95 % bands", "probability of 95 %"]
    fixed += ["above 5 N"]
    for words in [*sorted(roles, key=len, reverse=True), *fixed]:
        sentence = sentence.replace(words, "")
    return sentence


def expected(tables: Path, roles: dict[str, str]) -> Iterator[list[str]]:
    """The numbers of each sentence."""
    torque, force = read(tables / "torque_mae.csv"), read(tables / "force_mae.csv")
    yield from best_model([row for row in torque if row["mae"]], roles)
    printed = [row for row in torque if row["printed"] and row["mae"]]
    if looped := [row for row in printed if row["motion"] == "closed_loop"]:
        gap = {abs(float(row["mae"]) - float(row["printed"])): row["joint"] for row in looped}
        yield [f"{max(gap):.3f}", gap[max(gap)]]
    if accelerations := read(tables / "acceleration_mae.csv"):
        yield acceleration(accelerations)
    currents = read(tables / "current_rmse.csv")
    payloads = read(tables / "payload.csv")
    loads = [row for row in payloads if row["taken"] == "yes"]
    free = {*roles} - {row["recording"] for row in loads}
    judged = [r for r in currents if r["recording"] in free and roles[r["recording"]] == "validate"]
    yield [
        f"{value:.2f}"
        for model in ("fitted", "i_target")
        for value in averages([r for r in judged if r["model"] == model], "joint", "rmse_2hz")
    ]
    for row in loads[:4]:
        yield [f"{abs(float(row[name])):.2f}" for name in ("mass", "std_error")]
    for figure in ("mae", "max"):
        if rows := [row for row in force if row[f"printed_{figure}"]]:
            yield [widest(rows, estimate, figure) for estimate in ("Fu", "F", "F*")]
    contacts = read(tables / "contacts.csv")
    detection = read(tables / "detection.csv")
    yield from forces(force, detection, contacts, free, roles)
    yield quality(read(tables / "quality.csv"))
    if (tables / "truth.csv").exists() and (stated := [
        row["within95"] for row in read(tables / "truth.csv") if row["within95"]
    ]):  # fmt: skip
        yield [str(len(stated)), str(stated.count("yes"))]


def best_model(rows: list[Row], roles: dict[str, str]) -> Iterator[list[str]]:
    rows = [row for row in rows if roles[row["recording"]] != "fit"] or rows
    rows = [row for row in rows if row["motion"] == rows[0]["motion"]]
    errors = {
        model: averages([row for row in rows if row["model"] == model], "joint", "mae")
        for model in sorted({row["model"] for row in rows})
    }
    joints = [*zip(*errors.values(), strict=True)]
    differ = [values for values in joints if max(values) - min(values) > 5e-5]
    near = [[value - min(values) <= 5e-5 for value in values] for values in differ]
    wins = Counter({model: sum(row[i] for row in near) for i, model in enumerate(errors)})
    winner = wins.most_common(1)[0][0]
    yield [str(wins[winner]), str(len(differ))]
    order = [winner, *(model for model in errors if model != winner)]
    zero = averages(rows, "joint", "zero_mae")
    yield [shown(value) for model in order for value in errors[model]] + [*map(shown, zero)]


def shown(value: float, digits: int = 3) -> str:
    """A value, or the bound that stands for a small one."""
    least = 10**-digits
    return f"{least if 0 < value < least / 2 else value:.{digits}f}"


def acceleration(rows: list[Row]) -> list[str]:
    rows = [row for row in rows if row["estimate"] == "encoders"]
    linear = [row for row in rows if row["component"] in ("x", "y", "z")]
    numbers = [f"{value:.3f}" for value in averages(linear, "component", "mae")]
    numbers.append(str(len({row["recording"] for row in rows})))
    return numbers + [f"{value:.3f}" for value in averages(linear, "component", "zero_mae")]


def forces(
    force: list[Row],
    detection: list[Row],
    found: list[Row],
    free: set[str],
    roles: dict[str, str],
) -> Iterator[list[str]]:
    rows = [r for r in force if r["kind"] == "compensated" and r["component"].startswith("F")]
    touched = [row for row in rows if row["during"] == "contact"]
    better = []
    for recording in dict.fromkeys(row["recording"] for row in touched):
        here = [row for row in rows if row["recording"] == recording]
        lead = next(name for name in ESTIMATES if any(r["estimate"] == name for r in here))
        contact = chosen(here, lead, "contact")
        mae, zero = (sum(float(row[name]) for row in contact) for name in ("mae", "mean_force"))
        better.append(mae < zero)
        if len(better) <= 4:
            yield in_contact(here, contact, lead)
    if len(better) > 4:
        yield [str(sum(better)), str(len(better))]
    if any(row["determined"] == "no" for row in moments(force)):
        told = {row["component"] for row in moments(force) if row["determined"] == "yes"}
        if len(told) < 3:
            yield []
    if held := bands(rows):
        yield held
    sensed = {row["recording"] for row in force}
    felt = [name for name, role in roles.items() if role == "contact" and name not in sensed]
    contacts = [row for row in found if row["kind"] == "contact"]
    yield from (told for name in felt[:4] if (told := largest(contacts, name)))
    loads = [row for row in found if row["kind"] == "load" and row["estimate"] == "Fmap"]
    for row in loads[:4]:
        numbers = (row["load_mass"], 2), (row["load_mass_std"], 2), (row["start_s"], 1)
        yield [f"{float(value):.{digits}f}" for value, digits in numbers]
    yield from detected([row for row in detection if row["estimate"] == "Fmap"], free, roles)


def chosen(rows: list[Row], estimate: str, during: str) -> list[Row]:
    return [row for row in rows if row["estimate"] == estimate and row["during"] == during]


def in_contact(rows: list[Row], contact: list[Row], lead: str) -> list[str]:
    """Errors and their intervals, mean force, bands, the baseline, and errors free of contact."""

    def values(part: list[Row], *names: str, digits: int = 1) -> list[str]:
        return [shown(float(row[name]), digits) for row in part for name in names]

    numbers = values(contact, "mae")
    if all(row["mae_low"] for row in contact):
        numbers += values(contact, "mae_low", "mae_high")
    numbers += values(contact, "mean_force")
    if all(row["coverage95"] for row in contact):
        numbers += [f"{100 * float(row['coverage95']):.0f}" for row in contact]
    if lead != "least_squares":
        numbers += values(chosen(rows, "least_squares", "contact"), "mae")
    return numbers + values(chosen(rows, lead, "free"), "mae", digits=2)


def moments(force: list[Row]) -> list[Row]:
    """Of the leading estimate, in contact."""
    rows = [r for r in force if r["kind"] == "compensated" and r["during"] == "contact"]
    lead = next((name for name in ESTIMATES if any(r["estimate"] == name for r in rows)), "")
    return [r for r in rows if r["estimate"] == lead and r["component"].startswith("n")]


def bands(rows: list[Row]) -> list[str]:
    """What the bands of each new estimate hold in contact, and free of it."""
    numbers = []
    for name in NEW:
        parts = [
            [float(row["coverage95"]) for row in chosen(rows, name, during)]
            for during in ("contact", "free")
        ]
        if all(parts):
            numbers += [f"{100 * mean(part):.0f}" for part in parts]
    return numbers


def detected(rows: list[Row], free: set[str], roles: dict[str, str]) -> Iterator[list[str]]:
    """Contacts found by their force, false alarms, and the smallest pushes."""
    classes: dict[str, list[Row]] = defaultdict(list)
    for row in rows:
        if row["force_class_n"]:
            classes[row["force_class_n"]].append(row)
    if classes:
        yield [
            number
            for force, part in sorted(classes.items(), key=lambda item: float(item[0]))
            for number in (
                *(f"{sum(float(row[name]) for row in part):.0f}" for name in ("found", "contacts")),
                f"{float(force):.0f}",
            )
        ]
    quiet = [r for r in rows if roles[r["recording"]] == "validate" and r["recording"] in free]
    if quiet:
        yield [f"{mean(float(row['alarms_per_min']) for row in quiet):.1f}"]
    columns = [f"smallest_force_95_{axis}" for axis in "xyz"]
    if pushes := [r for r in rows if r["recording"] in free and all(map(r.get, columns))]:
        yield [f"{median(float(row[c]) for row in pushes):.0f}" for c in columns]


def largest(found: list[Row], recording: str) -> list[str]:
    """How many contacts a recording holds by F̂ᵐᵃᵖ, and the largest force in them."""
    rows = [r for r in found if r["recording"] == recording and r["estimate"] == "Fmap"]
    if not rows:
        return []
    peak = max(rows, key=lambda row: sum(float(row[name]) ** 2 for name in ("Fx", "Fy", "Fz")))
    values = [peak[f"{name}{end}"] for name in ("Fx", "Fy", "Fz") for end in ("", "_std")]
    numbers = [f"{abs(float(value)):.1f}" for value in [*values, peak["peak_s"]]]
    return [str(len(rows)), *numbers]


def quality(rows: list[Row]) -> list[str]:
    counts = Counter(row["severity"] for row in rows)
    serious = Counter(row["finding"] for row in rows if row["severity"] != "note")
    numbers = [str(counts[name]) for name in ("error", "warning", "note") if counts[name]]
    return numbers + [str(count) for _, count in serious.most_common(4)]


def widest(rows: list[Row], estimate: str, figure: str) -> str:
    part = [row for row in rows if row["estimate"] == estimate]
    gaps = [abs(float(row[figure]) / float(row[f"printed_{figure}"]) - 1) for row in part]
    return f"{100 * max(gaps):.1f}"


def averages(rows: list[Row], key: str, value: str) -> list[float]:
    """Means by a key, in the order in which its values come."""
    groups: dict[str, list[float]] = defaultdict(list)
    for row in rows:
        groups[row[key]].append(float(row[value]))
    return [*map(mean, groups.values())]


def read(path: Path) -> list[Row]:
    with path.open(encoding="utf-8") as lines:
        return [*csv.DictReader(lines)]
