"""The report's part on the sensor in an arm's wrist: its faults, in sentences and numbers."""

import pandas as pd

from ur5lib.report.results import Results

DIGITS_BY_UNIT = {"N": 2, "N/min": 2, "Nm": 3, "Nm/min": 3, "°": 2, "1": 4, "kg": 3, "m": 4}
MAX_RELATIVE_MASS_ERROR = (
    0.1  # largest relative error of a mass that the report proposes to declare
)
GRAVEST_FIRST = ("wrong", "unknown", "right", "")  # verdicts
PLACES = ("first", "second", "third")  # of a quantity's components
CARRIED = ("mass", "center_of_mass")


def every_value(results: Results) -> pd.DataFrame:
    """Return every value of the recordings' sensors, with its number of digits."""
    rows = results.rows("audit")
    rows = rows[rows["quantity"] != "free_time"]
    return rows.assign(digits=rows["unit"].map(DIGITS_BY_UNIT))


def by_quantity(results: Results) -> pd.DataFrame:
    """Return a row by recording, quantity and unit: values, standard errors and expected values of
    its components (x, y, z, or one), `first` to `third`, and the gravest verdict.
    """
    rows, every = every_value(results).fillna({"verdict": ""}), list[dict[str, object]]()
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
    """Return the recordings whose sensor carries a mass that is known well enough to declare it,
    where none is declared or its centre of mass is another: mass, declared [kg], x, y, z [m].
    """
    found = list[dict[str, object]]()
    for recording, rows in results.rows("audit").groupby("recording", sort=False):
        audit = dict([*rows.groupby("quantity")])
        if {*CARRIED} <= audit.keys():
            mass, center = (audit[name] for name in CARRIED)
            value, std = float(mass["value"].iloc[0]), float(mass["std_error"].iloc[0])
            certain = 0 < std < MAX_RELATIVE_MASS_ERROR * value
            if certain and ("scale" not in audit or (center["verdict"] == "wrong").any()):
                places = dict(zip("xyz", center["value"], strict=True))
                row = {"recording": recording, "mass": value, "std_error": std, **places}
                found.append(row | {"declared": mass["expected"].iloc[0]})
    return pd.DataFrame(found)
