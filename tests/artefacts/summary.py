"""The numbers expected on a report's first screen, computed from its tables in plain Python."""

import csv
import html
import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path
from statistics import mean, median
from typing import Any, NamedTuple

Row = dict[str, str]
ESTIMATES = ("Fmap", "least_squares", "observer", "repeat", "static", "Fu", "F", "F*")
MOST_WORDS = 180
FORCES = ("Fx", "Fy", "Fz")
FIXED = ["10 N", "probability of 95 %", "95 % interval", "95 % band", "(95 %:"]
SEVERITIES = ("stop", "error", "warning", "note")


class Study(NamedTuple):
    """A study's tables by name, the role of each recording, and the joints that move on it."""

    tables: dict[str, list[Row]]
    roles: dict[str, str]
    files: dict[str, str]

    def moving(self, recording: str) -> set[str]:
        (row,) = [row for row in self.tables["recordings"] if row["recording"] == recording]
        return {f"{float(joint):.0f}" for joint in row["moving_joints"].split()}

    def of_role(self, role: str) -> list[str]:
        return [name for name, other in self.roles.items() if other == role]

    def loads(self) -> list[Row]:
        return [row for row in self.tables["payload"] if row["taken"] == "yes"]

    def quiet(self) -> set[str]:
        """Validate recordings without an undeclared load."""
        return {*self.of_role("validate")} - {row["recording"] for row in self.loads()}


def check_summary(report: Path, study: dict[str, Any]) -> None:
    """Every number of every verdict and of every finding, in order; short sentences."""
    entries = study["recordings"]
    known = Study(
        {path.stem: read(path) for path in (report.parent / "tables").glob("*.csv")},
        {entry["name"]: entry["role"] for entry in entries},
        {entry["name"]: entry.get("file", "") for entry in entries},
    )
    text = html.unescape(report.read_text())
    (summary,) = re.findall(r"<h3>Findings</h3>\s*<ul>(.*?)</ul>", text, re.DOTALL)
    sentences = re.findall(r"<li>(.*?)</li>", summary, re.DOTALL)
    told = [numbers(sentence, known) for sentence in sentences]
    assert told == [*findings(known)]
    assert sum(len(sentence.split()) for sentence in sentences) <= MOST_WORDS
    assert max(map(len, told), default=0) <= 2
    cards = re.findall(r"<article class=\"verdict ([\w-]+)\">\s*<h3>(.*?) <.*?</h3>(.*?)</article>",
                       text, re.DOTALL)  # fmt: skip
    shown = {}
    for state, topic, card in cards:
        words = " ".join(re.findall(r"<p[^>]*>(.*?)</p>", card, re.DOTALL))
        shown[topic] = state, numbers(words, known)
    expected = verdicts(known)
    assert {topic: shown[topic] for topic in expected} == expected


def numbers(sentence: str, study: Study) -> list[str]:
    """A sentence's numbers, without the digits of names and of what is fixed."""
    names = [*study.roles, *filter(None, study.files.values())]
    for words in [*sorted(names, key=len, reverse=True), *FIXED]:
        sentence = sentence.replace(words, "")
    return re.findall(r"(?<![\w.,])\d[\d,]*(?:\.\d+)?", sentence)


# Verdicts


def verdicts(study: Study) -> dict[str, tuple[str, list[str]]]:
    """The state and the numbers of the verdicts that have some."""
    judged = {
        "Data quality": quality(study),
        "Link model": link_model(study),
        "Torque constants": torque_constants(study.tables["friction"]),
        "Friction and currents": currents(study),
        "Force in contact": force(study),
        "Motion": motion(study.tables["acceleration_mae"]),
    }
    return {topic: found for topic, found in judged.items() if found}


def state(error: float, zero: float, good: bool = True) -> str:
    if error >= zero:
        return "do-not-use"
    return "good" if error < zero / 2 and good else "usable"


def averages(rows: list[Row], key: str, value: str) -> dict[str, list[float]]:
    """Values by a key, in the order in which its values come."""
    groups: dict[str, list[float]] = defaultdict(list)
    for row in rows:
        groups[row[key]].append(float(row[value]))
    return groups


def worst(rows: list[Row], key: str, error: str, zero: str) -> tuple[str, list[float], float]:
    """The name of the largest error beside zero, its errors, and the mean error of zero."""
    errors, zeros = averages(rows, key, error), averages(rows, key, zero)
    acting = [name for name in errors if mean(zeros[name]) > 5e-5]
    name = max(acting, key=lambda name: mean(errors[name]) / mean(zeros[name]))
    return name, errors[name], mean(zeros[name])


def largest(rows: list[Row], name: str, error: str, zero: str, digits: int) -> list[str]:
    """The largest single error, its place if that is a number, and the error of zero there."""
    row = max(rows, key=lambda row: float(row[error]))
    place = [row[name]] if row[name].isdigit() else []
    return [shown(float(row[error]), digits), *place, shown(float(row[zero]), digits)]


def percent(errors: list[float], zero: float) -> str:
    return shown(100 * mean(errors) / zero, 0)


def spread(errors: list[float], zero: float, digits: int) -> list[str]:
    """An error, its range and number of recordings if several, and the error of zero."""
    ends = [shown(end, digits) for end in (min(errors), max(errors))]
    several = [*(ends if ends[0] != ends[1] else []), str(len(errors))] if errors[1:] else []
    return [shown(mean(errors), digits), *several, shown(zero, digits)]


def compared(study: Study) -> list[Row]:
    """Torque errors in motion, unseen if possible, at the first motion."""
    rows = [row for row in study.tables["torque_mae"] if row["mae"]]
    rows = [row for row in rows if study.moving(row["recording"])]
    rows = [row for row in rows if study.roles[row["recording"]] != "fit"] or rows
    return [row for row in rows if row["motion"] == rows[0]["motion"]]


def nearest(rows: list[Row]) -> tuple[list[str], int, int]:
    """The models that are closest most often, on how many joints, of how many that differ."""
    models = sorted({row["model"] for row in rows})
    errors = [averages([r for r in rows if r["model"] == m], "joint", "mae") for m in models]
    joints = [[mean(own[joint]) for own in errors] for joint in errors[0]]
    differ = [values for values in joints if max(values) - min(values) > 5e-5]
    wins = [sum(values[i] - min(values) <= 5e-5 for values in differ) for i in range(len(models))]
    best = [model for model, count in zip(models, wins, strict=True) if count == max(wins)]
    return best, max(wins), len(differ)


def quality(study: Study) -> tuple[str, list[str]]:
    """Of the most serious finding, on the recording of which it concerns most frames."""
    rows = study.tables["quality"]
    frames = {row["recording"]: int(row["frames"]) for row in study.tables["recordings"]}
    counts = Counter(row["severity"] for row in rows)
    told = [str(counts[name]) for name in SEVERITIES if counts[name]]
    serious = [row for row in rows if row["severity"] != "note"]
    if not serious:
        return "good", told
    bad = {row["recording"] for row in serious}
    groups: dict[tuple[str, ...], list[Row]] = defaultdict(list)
    for row in serious:
        groups[row["severity"], row["recording"], row["device"], row["finding"]].append(row)
    count = {key: sum(int(row["count"]) for row in part) for key, part in groups.items()}
    ranked = sorted(groups, key=lambda x: (SEVERITIES.index(x[0]), -count[x] / frames[x[1]]))
    first = ranked[0]
    about = [f"{count[first]:,}", f"{frames[first[1]]:,}"]
    if first[3] not in ("lost frames", "impossible frames"):
        about = numbers(groups[first][0]["detail"].partition("; ")[0], study)
    found = "do-not-use" if first[0] == "stop" else "usable"
    return found, [*about, *told, str(len(bad)), str(len(frames))]


def link_model(study: Study) -> tuple[str, list[str]] | None:
    if not (rows := compared(study)):
        return None
    (best, *_), _, _ = nearest(rows)
    own = [row for row in rows if row["model"] == best]
    joint, errors, zero = worst(own, "joint", "mae", "zero_mae")
    unseen = study.roles[rows[0]["recording"]] != "fit"
    told = [percent(errors, zero), joint, joint, *spread(errors, zero, 3)]
    told += largest(own, "joint", "mae", "zero_mae", 3)
    return state(mean(errors), zero, unseen), told


def listed(joints: list[str]) -> list[str]:
    """The numbers of “joints 1 to 6”, or of “joints 1, 2, 4”, commas included."""
    if len(joints) > 2 and int(joints[-1]) - int(joints[0]) == len(joints) - 1:
        return [joints[0], joints[-1]]
    return [f"{joint}," for joint in joints[:-1]] + joints[-1:]


def torque_constants(rows: list[Row]) -> tuple[str, list[str]] | None:
    """The constant that is the largest factor off the known one, on the joints named first."""
    rows = [row for row in rows if row["parameter"] == "torque_constant"]
    if not rows:
        return None
    factors = [math.exp(abs(math.log(float(row["value"]) / float(row["known"])))) for row in rows]
    row = rows[max(range(len(rows)), key=factors.__getitem__)]
    known = [row["joint"] for row in rows if row["determined"] == "yes"]
    refused = [row["joint"] for row in rows if row["contradicted"]]
    told = [*listed(known), *listed(refused), f"{row['joint']},"]
    told += [shown(float(row[name]), 2) for name in ("value", "std_error", "known", "known_std")]
    return "good" if len(known) == len(rows) and not refused else "usable", told


def currents(study: Study) -> tuple[str, list[str]] | None:
    rows = [
        row | {"zero": str(float(row["rmse_2hz"]) / math.sqrt(1 - float(row["r2"])))}
        for row in study.tables["current_rmse"]
        if row["model"] == "fitted"
        and row["recording"] in study.quiet()
        and row["joint"] in study.moving(row["recording"])
    ]
    if not rows:
        return None
    joint, errors, zero = worst(rows, "joint", "rmse_2hz", "zero")
    least = min(rows, key=lambda row: float(row["coverage95"]))
    held = float(least["coverage95"])
    told = [percent(errors, zero), joint, joint, *spread(errors, zero, 2)]
    told += largest(rows, "joint", "rmse_2hz", "zero", 2)
    told += [least["joint"], f"{100 * held:.0f}"]
    return state(mean(errors), zero, held >= 0.9), told


def motion(rows: list[Row]) -> tuple[str, list[str]] | None:
    rows = [row for row in rows if row["estimate"] == "encoders"]
    if not rows:
        return None
    component, errors, zero = worst(rows, "component", "mae", "zero_mae")
    along = [row for row in rows if row["component"] == component]
    told = [percent(errors, zero), *spread(errors, zero, 3)]
    return state(mean(errors), zero), told + largest(along, "component", "mae", "zero_mae", 3)


def force(study: Study) -> tuple[str, list[str]] | None:
    """Of the leading estimate, the largest error on recordings with contact that no fit has seen,
    the recording that is worst beside zero, and where the band holds least.
    """
    rows = [
        r for r in in_contact(study.tables["force_mae"]) if study.roles[r["recording"]] != "fit"
    ]
    rows = [row for row in rows if row["component"] in FORCES]
    if not rows:
        return None
    row = max(rows, key=lambda row: float(row["mae"]))
    mae, low, high, zero = (
        row[name] and f"{float(row[name]):.1f}"
        for name in ("mae", "mae_low", "mae_high", "mean_force")
    )
    errors, zeros = (averages(rows, "recording", name) for name in ("mae", "mean_force"))
    means = {name: (mean(errors[name]), mean(zeros[name])) for name in errors}
    part = max(means.values(), key=lambda pair: pair[0] / pair[1])
    bands = [float(row["coverage95"]) for row in rows if row["coverage95"]]
    told = [mae, zero, mae, *([low, high] if low else []), zero, *(f"{x:.1f}" for x in part)]
    told += [f"{100 * min(bands):.0f}" for _ in bands[:1]]
    good = (not bands or min(bands) >= 0.9) and bool(low) and row["estimate"] != "static"
    share = max(part[0] / part[1], float(row["mae"]) / float(row["mean_force"]))
    return state(share, 1.0, good), told


def in_contact(rows: list[Row]) -> list[Row]:
    """The errors of the leading estimate in contact."""
    rows = [row for row in rows if row["kind"] == "compensated" and row["during"] == "contact"]
    lead = next((name for name in ESTIMATES if any(r["estimate"] == name for r in rows)), "")
    return [row for row in rows if row["estimate"] == lead]


# Findings


def findings(study: Study) -> Iterator[list[str]]:
    """The numbers of each sentence."""
    force = study.tables["force_mae"]
    if (rows := compared(study)) and len({row["model"] for row in rows}) > 1:
        _, near, differ = nearest(rows)
        yield [str(near), str(differ)] if differ else []
    if printed := [row["status"] for row in study.tables.get("printed", [])]:
        yield [str(printed.count("equal")), str(len(printed))]
    for row in study.loads()[:4]:
        yield [f"{abs(float(row[name])):.2f}" for name in ("mass", "std_error")]
    yield from contacts(study)
    for row in [] if study.tables["friction"] else study.tables["sensed"][:4]:
        reads, share = float(row["largest_force_n"]), 100 * float(row["share_in_contact"])
        yield [f"{reads:.1f}", f"{share:.0f}"]
    yield from detected(study)
    yield from claimed(study)
    moments = [row for row in in_contact(force) if row["component"] not in FORCES]
    if {row["component"] for row in moments if row["determined"] == "yes"} < {
        row["component"] for row in moments
    }:
        yield []
    stated = [row["within95"] for row in study.tables.get("truth", []) if row["within95"]]
    if stated:
        yield from truths(len(stated), stated.count("yes"))


def truths(count: int, held: int) -> Iterator[list[str]]:
    """How many intervals hold the truth, how many should, and the chance where that is small."""
    chances = [math.comb(count, k) * 0.95**k * 0.05 ** (count - k) for k in range(count + 1)]
    chance = min(sum(chances[held:]), sum(chances[: held + 1]))
    yield [str(count), str(held)]
    expected = f"{0.95 * count:.0f}"
    yield [expected, shown(100 * chance, 1)] if chance < 0.025 else [expected]


def contacts(study: Study) -> Iterator[list[str]]:
    """Contacts by recording without a sensor, and loads taken up."""
    sensed = {row["recording"] for row in study.tables["force_mae"]}
    searched = {row["recording"] for row in study.tables["detection"]} - sensed
    found = [row for row in study.tables["contacts"] if row["estimate"] == "Fmap"]
    counts = Counter(row["recording"] for row in found if row["kind"] == "contact")
    for name in [name for name in study.of_role("contact") if name in searched][:4]:
        yield [str(counts[name])] if counts[name] else []
    for row in [row for row in found if row["kind"] == "load"][:4]:
        yield [f"{float(row[name]):.2f}" for name in ("load_mass", "load_mass_std")]


def detected(study: Study) -> Iterator[list[str]]:
    """Contacts found, false alarms, and the smallest push along the worst axis."""
    rows = [row for row in study.tables["detection"] if row["estimate"] == "Fmap"]
    if classes := [float(row["force_class_n"]) for row in rows if row["force_class_n"]]:
        least = [
            r for r in rows if r["force_class_n"] and float(r["force_class_n"]) == min(classes)
        ]
        yield [f"{sum(float(row[name]) for row in least):.0f}" for name in ("found", "contacts")]
    if quiet := [row for row in rows if row["recording"] in study.quiet()]:
        yield [f"{mean(float(row['alarms_per_min']) for row in quiet):.1f}"]
    loaded = {row["recording"] for row in study.loads()}
    columns = [f"smallest_force_95_{axis}" for axis in "xyz"]
    free = [row for row in rows if row["recording"] not in loaded]
    pushes = [row for row in free if any(map(row.get, columns))]
    if pushes and all(row[column] for row in pushes for column in columns):
        yield [f"{max(median(float(row[c]) for row in pushes) for c in columns):.0f}"]


def claimed(study: Study) -> Iterator[list[str]]:
    """Pushes of the thesis's recording that its threshold of 10 N along z misses."""
    printed = {row["recording"] for row in study.tables["force_mae"] if row["printed_mae"]}
    rows = [row for row in study.tables["fixed_threshold"] if row["component"] == "Fz"]
    if pushed := [row for row in rows if row["recording"] in printed and row["estimate"] == "F*"]:
        pushes, found = (sum(int(row[name]) for row in pushed) for name in ("pushes", "found"))
        assert found < pushes
        yield [str(pushes - found), str(pushes)]


def shown(value: float, digits: int = 3) -> str:
    """A value, or the bound that stands for a small one."""
    least = 10**-digits
    return f"{least if 0 < value < least / 2 else value:.{digits}f}"


def read(path: Path) -> list[Row]:
    with path.open(encoding="utf-8") as lines:
        return [*csv.DictReader(lines)]
