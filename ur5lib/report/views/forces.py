"""Contact forces compared with the force sensor, their bands, and detected contacts."""

import math
from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.force.contact_link import likely_links
from ur5lib.pipeline.estimators import ESTIMATES, GATED, NEW, PUBLISHED
from ur5lib.report.cells import extremes, fixed, interval, number, numbered, signed, with_error
from ur5lib.report.document import UNDETERMINED, Cell
from ur5lib.report.results import NOTHING, Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say
from ur5lib.report.tables.forces import LINKS
from ur5lib.report.views.currents import loaded

UNITS = {"F": "N", "n": "Nm"}
BANDS = (50, 80, 95)  # %
DURING = {"contact": "in contact", "free": "free", "all": "whole run"}
PUSHES = [f"smallest_force_95_{axis}" for axis in "xyz"]


def compared(results: Results) -> list[str]:
    """Return recordings with printed errors, with a force sensor, then others with contact."""
    drawn = {*searched(results)["recording"]}
    touched = [name for name in results.with_role("contact") if name in drawn]
    beside = [*results.tables["force_mae"]["recording"], *results.tables["sensed"]["recording"]]
    return results.shown([*printed(results), *beside, *touched])


def searched(results: Results) -> pd.DataFrame:
    """Return the detections by the estimates of this study, without published ones."""
    rows = results.tables["detection"]
    return rows[rows["estimate"].isin(GATED)]


def printed(results: Results) -> list[str]:
    """Return the recordings with printed errors."""
    return results.printed("force_mae", "printed_mae")


def published(results: Results) -> Iterator[Sentence]:
    """Explain the published estimates, if they are compared."""
    if {"F", "F*"} & {*results.tables["force_mae"]["estimate"]}:
        yield say("force.published")


def headline(results: Results) -> Body:
    """Return the leading estimate in contact, the mean force there, and the free errors."""
    rows = leading(results.rows("force_mae", kind="compensated"))
    forces = rows[rows["component"].str.startswith("F")]
    free = forces[forces["during"] == "free"].set_index(["recording", "component"])

    def when_free(row: Any, figure: str) -> float:
        return float(free[figure].get((row.recording, row.component), math.nan))

    columns: dict[str, Column] = {
        "recording": "recording",
        "component": lambda row: _component(row.component),
        "mean force": lambda row: number(row.mean_force, 1),
        "error (95 %)": with_interval,
        "slope": lambda row: number(row.slope, 2),
        "in 95 % band [%]": lambda row: number(100 * row.coverage95, 0),
        "band's score": lambda row: number(row.interval_score95, 0),
        "zero's score": lambda row: number(row.zero_interval_score95, 0),
        "free: error": lambda row: number(when_free(row, "mae"), 2),
        "free: in band [%]": lambda row: number(100 * when_free(row, "coverage95"), 0),
    }
    return tabulated(forces[forces["during"] == "contact"].itertuples(), columns)


VARIANTS = {  # the variants of the ablation, and their names in the report
    "whole": "F̂ᵐᵃᵖ",
    "contacts by the sensor": "contacts from the sensor instead of the gate",
    "no background": "background not subtracted",
    "usual contact": "prior force of a typical contact, not estimated for each",
    "no load friction": "gears without losses",
    "friction of the fit": "friction as strong as in the fit",
    "least_squares": "no prior (least squares)",
    "repeat": "residual of other runs subtracted (repeat-aware)",
}


def ablation(results: Results) -> Body:
    """Return the errors in contact along x, y, z by variant of F̂ᵐᵃᵖ (row) and recording."""
    rows = results.tables["ablation"]
    recordings = [*dict.fromkeys(rows["recording"])]
    errors = rows.set_index(["variant", "recording", "component"])["mae"].to_dict()
    body = [
        [
            Cell(label),
            *(Cell(_forces(errors, variant, name)) for name in recordings),
        ]
        for variant, label in VARIANTS.items()
        if variant in {*rows["variant"]}
    ]
    return Body(["variant", *recordings], body)


def _forces(errors: dict[tuple[str, str, str], float], variant: str, recording: str) -> str:
    """Return errors in x, y, z [N]; a dash where the variant was not computed."""
    values = [errors.get((variant, recording, f"F{axis}")) for axis in "xyz"]
    return ", ".join("–" if value is None else fixed(value, 1) for value in values)


def with_interval(row: Any) -> str:
    """Return an error in contact, with its 95 % interval where contacts were resampled."""
    mae = fixed(row.mae, 1)
    return mae if math.isnan(row.mae_low) else f"{mae} ({interval(row.mae_low, row.mae_high, 1)})"


def leading(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the leading estimate: the first in the report's order."""
    available = {*rows["estimate"]}
    first = next((name for name in [*NEW, *PUBLISHED] if name in available), None)
    return rows[rows["estimate"] == first]


def summary(results: Results) -> Body:
    """Return the error of each estimate in contact, and the mean force there."""
    rows = results.rows("force_mae", kind="compensated", during="contact")
    names = _estimates(rows)
    body = [
        [
            Cell(str(recording)),
            _component(str(component)),
            number(part["mean_force"].iloc[0], 2),
            *_determined(part.set_index("estimate"), names),
        ]
        for (recording, component), part in rows.groupby(["recording", "component"], sort=False)
    ]
    return Body(["recording", "component", "mean in contact", *(ESTIMATES[x] for x in names)], body)


def _determined(rows: pd.DataFrame, names: list[str]) -> Iterator[Cell]:
    """Yield a component's errors by estimate, "undetermined" for moments that are."""
    marks = extremes(rows["mae"].to_dict())
    unknown = rows["component"].str.startswith("n") & (rows["determined"] == "no")
    for name in names:
        if name in NEW and unknown.get(name, False):
            yield Cell(UNDETERMINED)
        else:
            yield number(rows["mae"].get(name, math.nan), 2, marks.get(name))


def errors(results: Results, recording: str) -> Body:
    """Return all errors against the compensated sensor: in contact, free, whole run."""
    rows = results.rows("force_mae", recording=recording, kind="compensated")
    parts = [(label, rows[rows["during"] == during]) for during, label in DURING.items()]
    bodies = [(label, _errors(part, "mae")) for label, part in parts if len(part)]
    if not bodies:
        return NOTHING
    lines = [[Cell(label), *line] for label, body in bodies for line in body.rows]
    return Body(["during", *bodies[-1][1].header], lines)


def errors_from_start(results: Results, recording: str) -> Body:
    """Return all errors over the whole run against the sensor less its reading at the start."""
    rows = results.rows("force_mae", recording=recording, kind="corrected", during="all")
    return _errors(rows, "mae")


def largest_errors(results: Results, recording: str) -> Body:
    """Return the largest error of every estimate against the compensated sensor."""
    rows = results.rows("force_mae", recording=recording, kind="compensated", during="all")
    return _errors(rows, "max")


def _errors(rows: pd.DataFrame, figure: str) -> Body:
    names = _estimates(rows)
    values = rows.set_index(["component", "estimate"])[[figure, f"zero_{figure}"]]
    body = []
    for component in rows["component"].unique():
        errors = {name: values.loc[(component, name), figure] for name in names}
        marks = extremes(errors)
        line = [_component(component), *(number(errors[x], 2, marks[x]) for x in names)]
        body.append([*line, number(values.loc[(component, names[0]), f"zero_{figure}"], 2)])
    return Body(["component", *(ESTIMATES[name] for name in names), "zero"], body)


def printed_errors(results: Results, recording: str) -> Body:
    """Return Table 6.1: mean errors, printed, rebuilt, and their difference."""
    rows = results.rows("force_mae", recording=recording, kind="printed", during="all")
    return _printed(rows, "mae")


def printed_largest_errors(results: Results, recording: str) -> Body:
    """Return Table 6.2: largest errors, printed, rebuilt, and their difference."""
    rows = results.rows("force_mae", recording=recording, kind="printed", during="all")
    return _printed(rows, "max")


def _printed(rows: pd.DataFrame, figure: str) -> Body:
    rows = rows[rows[f"printed_{figure}"].notna()]
    names = _estimates(rows)
    header = ["component"]
    header += [f"{ESTIMATES[x]} {what}" for x in names for what in ("printed", "rebuilt", "diff.")]
    body = []
    for component, group in rows.groupby("component", sort=False):
        part = group.set_index("estimate")
        line = [_component(component)]
        marks = extremes(part[figure].to_dict())
        for name in names:
            printed, value = part.loc[name, [f"printed_{figure}", figure]]
            line += [
                number(printed, 2),
                number(value, 2, marks[name]),
                signed(100 * (value / printed - 1), 1, " %"),
            ]
        body.append([*line, number(group[f"zero_{figure}"].iloc[0], 2)])
    return Body([*header, "zero"], body)


def bands(results: Results, recording: str) -> Body:
    """Return skill, slope, correlation and coverage of the new estimates in contact."""
    rows = results.rows("force_mae", recording=recording, kind="compensated")
    rows = rows[rows["coverage95"].notna()]
    free = rows[rows["during"] == "free"].set_index(["estimate", "component"])["coverage95"]
    body = [
        [
            Cell(ESTIMATES[row.estimate]),
            _component(row.component),
            number(row.skill, 2) if row.determined == "yes" else Cell(UNDETERMINED),
            *(number(getattr(row, name), 2) for name in ("correlation", "slope")),
            *(number(100 * getattr(row, f"coverage{x}"), 0) for x in BANDS),
            number(row.interval_score95, 1),
            number(row.zero_interval_score95, 1),
            number(100 * free.get((row.estimate, row.component), math.nan), 0),
        ]
        for row in rows[rows["during"] == "contact"].itertuples()
    ]
    header = ["estimate", "component", "skill", "correlation", "slope"]
    header += [f"in {x} % band [%]" for x in BANDS]
    return Body([*header, "band's score", "zero's score", "free: in 95 % band [%]"], body)


def contact_errors(results: Results, recording: str) -> Body:
    """Return peak, impulse and onset of each contact, with the leading estimate's errors."""
    rows = leading(results.rows("contact_errors", recording=recording, component="norm"))
    columns: dict[str, Column] = {
        "contact [s]": lambda row: interval(row.start_s, row.end_s, 2),
        "peak [N]": lambda row: number(row.peak, 1),
        "peak error [N]": lambda row: signed(row.peak_error, 1),
        "impulse [N s]": lambda row: number(row.impulse, 1),
        "impulse error [N s]": lambda row: signed(row.impulse_error, 1),
        "onset delay [s]": lambda row: signed(row.onset_error_s, 2),
    }
    return tabulated(rows.itertuples(), columns)


def detections(results: Results) -> Body:
    """Return contacts found by the force that they reach, false alarms and delays."""
    rows = results.tables["detection"]
    rows = rows[rows["force_class_n"].notna()]
    classes = [*rows["force_class_n"].unique()]
    body = []
    for (recording, estimate), part in rows.groupby(["recording", "estimate"], sort=False):
        by_force = part.set_index("force_class_n")
        first = part.iloc[0]
        body.append(
            [
                Cell(str(recording)),
                Cell(ESTIMATES[str(estimate)]),
                number(first["threshold"] if estimate in PUBLISHED else math.nan, 1),
                *(_share(by_force.loc[force]) for force in classes),
                number(first["false_alarms_per_min"], 1),
                number(first["extra_alarms"], 0),
                number(100 * first["free_time_in_alarm"], 0),
                number(first["median_delay_s"], 2),
                _causal(first),
            ]
        )
    header = ["recording", "estimate", "from [N]", *(f"≥ {force:.0f} N" for force in classes)]
    header += ["false [1/min]", "extra", "free time in alarm [%]", "delay [s]", "causal"]
    return Body(header, body)


def _share(row: pd.Series, total: str = "contacts") -> Cell:
    return Cell(f"{row['found']:.0f} of {row[total]:.0f}")


def _causal(row: pd.Series) -> Cell:
    """Return the number of contacts that causal alarms find, and their delay."""
    if math.isnan(row["causal_found"]):
        return Cell("–")
    after = f", {row['causal_delay_s']:.2f} s" if row["causal_found"] else ""
    return Cell(f"{row['causal_found']:.0f} of {row['contacts']:.0f}{after}")


def fixed_threshold(results: Results) -> Body:
    """Return the pushes found along z above the thesis's threshold, and the time above it."""
    rows = results.rows("fixed_threshold", component="Fz")
    if "F*" not in {*rows["estimate"]}:
        return NOTHING
    roles, names = results.roles(), _estimates(rows)
    cells = rows.set_index(["recording", "estimate"])
    body = [
        [Cell(name), Cell(roles[name]), *(_above(cells, (name, x)) for x in names)]
        for name in rows["recording"].unique()
    ]
    return Body(["recording", "role", *(ESTIMATES[x] for x in names)], body)


def _above(rows: pd.DataFrame, key: tuple[str, str]) -> Cell:
    """Return the time above in percent and, where a sensor counted pushes, how many are found."""
    if key not in rows.index:
        return Cell("–")
    row = rows.loc[key]
    share = f"{100 * row['time_above']:.0f} %"
    return Cell(share if math.isnan(row["pushes"]) else f"{share}; {_share(row, 'pushes').text}")


def contacts(results: Results, recording: str) -> Body:
    """Return the contacts that F̂ᵐᵃᵖ finds: time, largest force, likely links, and a load."""
    rows = results.rows("contacts", recording=recording, estimate="Fmap")
    columns: dict[str, Column] = {
        "contact [s]": lambda row: interval(row.start_s, row.end_s, 2),
        "largest at [s]": lambda row: f"{row.peak_s:.2f}",
        "Fx [N]": lambda row: with_error(row.Fx, row.Fx_std, 1),
        "Fy [N]": lambda row: with_error(row.Fy, row.Fy_std, 1),
        "Fz [N]": lambda row: with_error(row.Fz, row.Fz_std, 1),
        "on link": _links,
    }
    if (rows["kind"] == "load").any():
        columns["load [kg]"] = _load
    return tabulated(rows.itertuples(), columns)


def _load(row: Any) -> Cell:
    return with_error(row.load_mass, row.load_mass_std, 2) if row.kind == "load" else Cell("–")


def likely(row: Any) -> list[int]:
    """Return the links that a contact may touch; empty where that was not estimated."""
    probabilities = {link: getattr(row, name) for link, name in enumerate(LINKS, start=1)}
    return [] if math.isnan(probabilities[6]) else likely_links(probabilities)


def _links(row: Any) -> Cell:
    links = likely(row)
    return Cell(numbered(links) if links else "–")


def alarms(results: Results) -> Body:
    """Return the alarms per minute of each estimate on recordings without a sensor."""
    rows = results.tables["detection"]
    rows = rows[rows["force_class_n"].isna()]
    names, roles = _estimates(rows), results.roles()
    alarms = rows.set_index(["recording", "estimate"])["alarms_per_min"]
    body = [
        [
            Cell(name),
            Cell(roles[name]),
            *(number(alarms.get((name, x), math.nan), 1) for x in names),
        ]
        for name in rows["recording"].unique()
    ]
    return Body(["recording", "role", *(f"{ESTIMATES[x]} [1/min]" for x in names)], body)


def smallest_pushes(results: Results) -> Body:
    """Return the smallest push along each axis that is detected on contact-free motions."""
    rows = pushes_found(results)
    kinds = {"": "in motion", "rest_": "at rest"}
    columns = [
        (where, axis)
        for where in kinds
        for axis in "xyz"
        if rows[f"smallest_force_95_{where}{axis}"].notna().any()
    ]
    body = [[Cell(row["recording"]), *_limits(row, columns)] for _, row in rows.iterrows()]
    return Body(["recording", *(f"{kinds[where]}: {axis} [N]" for where, axis in columns)], body)


def _limits(row: pd.Series, columns: list[tuple[str, str]]) -> Iterator[Cell]:
    """Yield the smallest detected push with its error, by state (rest or motion) and axis."""
    for where, axis in columns:
        force, std = (row[f"smallest_force_{kind}_{where}{axis}"] for kind in ("95", "std"))
        yield with_error(force, std, 0)


def pushes_found(results: Results) -> pd.DataFrame:
    """Return the smallest pushes that F̂ᵐᵃᵖ detects on motions without an undeclared load."""
    rows = results.rows("detection", estimate="Fmap").dropna(subset=PUSHES, how="all")
    return rows[~rows["recording"].isin(loaded(results)["recording"])]


def _estimates(rows: pd.DataFrame) -> list[str]:
    """Return the available estimates, in the report's order."""
    return [name for name in ESTIMATES if name in {*rows["estimate"]}]


def _component(name: str) -> Cell:
    return Cell(f"{name} [{UNITS[name[0]]}]")
