"""Contact forces against the force sensor, their bands, and detected contacts."""

import math

import pandas as pd

from ur5lib.report.cells import extremes, interval, number, signed, with_error
from ur5lib.report.document import Cell
from ur5lib.report.results import Body, Results, shown
from ur5lib.report.views.currents import loaded

PUBLISHED = {"Fu": "F̂ᵘ", "F": "F̂", "F*": "F̂*"}
NEW = {"Fmap": "F̂ᵐᵃᵖ", "observer": "observer", "repeat": "repeat-aware"}
ESTIMATES = PUBLISHED | NEW
UNITS = {"F": "N", "n": "Nm"}
BANDS = (50, 80, 95)  # %
PUSHES = [f"smallest_force_95_{axis}" for axis in "xyz"]


def compared(results: Results) -> list[str]:
    """Recordings with printed errors, with a working force sensor, then others with contact."""
    drawn = {*results.tables["detection"]["recording"]}
    felt = [name for name in results.with_role("contact") if name in drawn]
    return shown([*printed(results), *results.tables["force_mae"]["recording"], *felt])


def printed(results: Results) -> list[str]:
    """Recordings with printed errors."""
    return results.printed("force_mae", "printed_mae")


def summary(results: Results) -> Body:
    """Mean error over x, y, z of each estimate, a row a recording, beside no force."""
    rows = results.rows("force_mae", kind="compensated")
    forces = rows[rows["component"].str.startswith("F")]
    known = _known(forces)
    body = []
    for recording, part in forces.groupby("recording", sort=False):
        mean = part.groupby("estimate")["mae"].mean()
        marks = extremes(dict(mean))
        zero = part.drop_duplicates("component")["zero_mae"].mean()
        values = [number(mean.get(name, float("nan")), 2, marks.get(name)) for name in known]
        body.append([Cell(str(recording)), *values, number(zero, 2)])
    return Body(["recording", *(ESTIMATES[name] for name in known), "zero"], body)


def errors(results: Results, of: str) -> Body:
    """Every estimate against the sensor less bias and tool weight."""
    return _errors(results.rows("force_mae", recording=of, kind="compensated"), "mae")


def errors_from_start(results: Results, of: str) -> Body:
    """Every estimate against the sensor less its reading at the start."""
    return _errors(results.rows("force_mae", recording=of, kind="corrected"), "mae")


def largest_errors(results: Results, of: str) -> Body:
    """The largest error of every estimate against the sensor less bias and tool weight."""
    return _errors(results.rows("force_mae", recording=of, kind="compensated"), "max")


def _errors(rows: pd.DataFrame, figure: str) -> Body:
    known = _known(rows)
    values = rows.set_index(["component", "estimate"])[[figure, f"zero_{figure}"]]
    body = []
    for component in rows["component"].unique():
        errors = {name: values.loc[(component, name), figure] for name in known}
        marks = extremes(errors)
        line = [_component(component), *(number(errors[x], 2, marks[x]) for x in known)]
        body.append([*line, number(values.loc[(component, known[0]), f"zero_{figure}"], 2)])
    return Body(["component", *(ESTIMATES[name] for name in known), "zero"], body)


def printed_errors(results: Results, of: str) -> Body:
    """Table 6.1: mean errors, printed, rebuilt, their difference."""
    return _printed(results.rows("force_mae", recording=of, kind="printed"), "mae")


def printed_largest_errors(results: Results, of: str) -> Body:
    """Table 6.2: largest errors, printed, rebuilt, their difference."""
    return _printed(results.rows("force_mae", recording=of, kind="printed"), "max")


def _printed(rows: pd.DataFrame, figure: str) -> Body:
    rows = rows[rows[f"printed_{figure}"].notna()]
    known = _known(rows)
    header = ["component"]
    header += [f"{ESTIMATES[x]} {what}" for x in known for what in ("printed", "rebuilt", "diff.")]
    body = []
    for component, group in rows.groupby("component", sort=False):
        part = group.set_index("estimate")
        line = [_component(component)]
        marks = extremes(part[figure].to_dict())
        for name in known:
            printed, value = part.loc[name, [f"printed_{figure}", figure]]
            line += [
                number(printed, 2),
                number(value, 2, marks[name]),
                signed(100 * (value / printed - 1), 1, " %"),
            ]
        body.append([*line, number(group[f"zero_{figure}"].iloc[0], 2)])
    return Body([*header, "zero"], body)


def bands(results: Results, of: str) -> Body:
    """The new estimates: skill, gain, correlation, and what their bands hold."""
    rows = results.rows("force_mae", recording=of, kind="compensated")
    body = [
        [
            Cell(ESTIMATES[row.estimate]),
            _component(row.component),
            *(number(getattr(row, name), 2) for name in ("skill", "correlation", "gain")),
            *(number(100 * getattr(row, f"coverage{x}"), 0) for x in BANDS),
        ]
        for row in rows[rows["coverage95"].notna()].itertuples()
    ]
    header = ["estimate", "component", "skill", "correlation", "gain"]
    return Body([*header, *(f"in {x} % band [%]" for x in BANDS)], body)


def detections(results: Results) -> Body:
    """Contacts of at least 15 N by the sensor: found, false alarms, delay."""
    rows = results.tables["detection"]
    body = [
        [
            Cell(row.recording),
            Cell(ESTIMATES[row.estimate]),
            Cell(f"{row.found:.0f} of {row.contacts:.0f}"),
            number(row.precision, 2),
            number(row.false_alarms_per_min, 1),
            number(row.median_delay_s, 2),
        ]
        for row in rows[rows["contacts"].notna()].itertuples()
    ]
    header = ["recording", "estimate", "found", "precision", "false alarms [1/min]"]
    return Body([*header, "median delay [s]"], body)


def contacts(results: Results, of: str) -> Body:
    """When F̂ᵐᵃᵖ finds a contact on a recording, and the largest force in each."""
    rows = results.rows("contacts", recording=of, estimate="Fmap")
    body = [
        [
            Cell(interval(row.start_s, row.end_s, 2)),
            Cell(f"{row.peak_s:.2f}"),
            *(
                with_error(force, std, 1)
                for force, std in ((row.Fx, row.Fx_std), (row.Fy, row.Fy_std), (row.Fz, row.Fz_std))
            ),
        ]
        for row in rows.itertuples()
    ]
    return Body(["contact [s]", "largest at [s]", "Fx [N]", "Fy [N]", "Fz [N]"], body)


def alarms(results: Results) -> Body:
    """Alarms a minute by each estimate where no sensor tells of contacts."""
    rows = results.tables["detection"]
    rows = rows[rows["contacts"].isna()]
    known, roles = _known(rows), results.roles()
    alarms = rows.set_index(["recording", "estimate"])["alarms_per_min"]
    body = [
        [
            Cell(name),
            Cell(roles[name]),
            *(number(alarms.get((name, x), math.nan), 1) for x in known),
        ]
        for name in rows["recording"].unique()
    ]
    return Body(["recording", "role", *(f"{ESTIMATES[x]} [1/min]" for x in known)], body)


def smallest_pushes(results: Results) -> Body:
    """The smallest push along an axis that is found on a motion without contact."""
    rows = pushes_found(results)
    body = [
        [Cell(name), *(number(force, 0) for force in forces)]
        for name, forces in zip(rows["recording"], rows[PUSHES].to_numpy(float), strict=True)
    ]
    return Body(["recording", *(f"{axis} [N]" for axis in "xyz")], body)


def pushes_found(results: Results) -> pd.DataFrame:
    """The smallest pushes by F̂ᵐᵃᵖ on motions that differ from the arm's model by no load."""
    rows = results.rows("detection", estimate="Fmap").dropna(subset=PUSHES, how="all")
    return rows[~rows["recording"].isin(loaded(results)["recording"])]


def _known(rows: pd.DataFrame) -> list[str]:
    """The estimates that were made, in the report's order."""
    return [name for name in ESTIMATES if name in {*rows["estimate"]}]


def _component(name: str) -> Cell:
    return Cell(f"{name} [{UNITS[name[0]]}]")
