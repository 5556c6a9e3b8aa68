"""The report's part on the sensor in an arm's wrist: its faults, in sentences and numbers."""

from collections.abc import Mapping

import pandas as pd

from ur5lib.report.results import Results

DIGITS_BY_UNIT = {"N": 2, "N/min": 2, "Nm": 3, "Nm/min": 3, "°": 2, "1": 4, "kg": 3, "m": 4}
MAX_RELATIVE_MASS_ERROR = (
    0.1  # largest relative error of a mass that the report proposes to declare
)
GRAVEST_FIRST = ("wrong", "unknown", "right", "")  # verdicts
PLACES = ("first", "second", "third")  # these are the names of a quantity's components
CARRIED = ("mass", "center_of_mass")


def every_value(results: Results) -> pd.DataFrame:
    """Return every value of the audit, with the number of digits to print."""
    rows = results.rows("audit")
    rows = rows[rows["quantity"] != "free_time"]
    return rows.assign(digits=rows["unit"].map(DIGITS_BY_UNIT))


def by_quantity(results: Results) -> pd.DataFrame:
    """Return a row for each recording, quantity and unit: value, standard error and expected value
    of up to three components, `first` to `third`, and the gravest of their verdicts.
    """
    rows, every = every_value(results).astype({"verdict": object}), list[dict[str, object]]()
    rows = rows.fillna({"verdict": ""})
    for (recording, quantity, unit), part in rows.groupby(
        ["recording", "quantity", "unit"], sort=False
    ):
        found = {*part["verdict"]}
        own = {"recording": recording, "quantity": quantity, "unit": unit}
        own |= {"verdict": next(one for one in GRAVEST_FIRST if one in found)}
        for place, row in zip(PLACES, part.itertuples(), strict=False):
            told = {"": row.value, "_std": row.std_error, "_expected": row.expected}
            own |= {f"{place}{name}": value for name, value in told.items()}
        every.append(own)
    return pd.DataFrame(every)


def free(results: Results) -> pd.DataFrame:
    """Return the time without contact [s] of each recording with a sensor, and whether it suffices
    to judge it.
    """
    rows = results.rows("audit")
    judged = {*rows.loc[rows["quantity"] != "free_time", "recording"]}
    times = rows.loc[rows["quantity"] == "free_time", ["recording", "value"]]
    suffices = times["recording"].isin(judged).map({True: "yes", False: "no"})
    return times.rename(columns={"value": "seconds"}).assign(suffices=suffices)


def declared(results: Results) -> pd.DataFrame:
    """Return the recordings with a load on the sensor that should be declared: `mass` with its
    `std_error`, `declared` mass [kg], and the centre of mass `x`, `y`, `z` [m].
    """
    found = list[dict[str, object]]()
    for recording, rows in results.rows("audit").groupby("recording", sort=False):
        audit = dict([*rows.groupby("quantity")])
        if is_to_declare(audit):
            mass, center = (audit[name] for name in CARRIED)
            (value, std, expected), *_ = mass[["value", "std_error", "expected"]].to_numpy()
            row = {"recording": recording, "mass": value, "std_error": std, "declared": expected}
            found.append(row | dict(zip("xyz", center["value"], strict=True)))
    return pd.DataFrame(found)


def is_to_declare(audit: Mapping[str, pd.DataFrame]) -> bool:
    """Return whether a sensor's load is certain, and either undeclared or with another centre of
    mass than declared, which an error of the sensor's scale cannot explain.

    audit: the rows of a recording, by quantity.
    """
    if not {*CARRIED} <= audit.keys():
        return False
    (value, std), *_ = audit["mass"][["value", "std_error"]].to_numpy()
    displaced = (audit["center_of_mass"]["verdict"] == "wrong").any()
    return bool(0 < std < MAX_RELATIVE_MASS_ERROR * value and ("scale" not in audit or displaced))
