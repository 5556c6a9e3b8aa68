"""Found contacts, alarms, readings of the sensor, and the errors that judge the estimate."""

import pandas as pd

from ur5lib.force.estimators import LEADING, UNGATED
from ur5lib.records.contacts import with_sharp_peaks
from ur5lib.report.results import Results
from ur5lib.report.views.forces import compared, leading

FORCE_COMPONENTS = ["Fx", "Fy", "Fz"]


def touched(results: Results) -> list[str]:
    """Return the recordings on which a force sensor reads a contact, the strongest first."""
    rows = results.tables["sensed"].sort_values("largest_force_n", ascending=False)
    return [*rows.loc[rows["contacts"].astype(bool), "recording"]]


def decided(results: Results) -> pd.DataFrame:
    """Return the leading estimate's errors along x, y, z on recordings that no fit has used, with
    those of plain least squares (`plain`).
    """
    about = {"kind": "compensated", "during": "contact", "component": FORCE_COMPONENTS}
    rows, key = results.rows("force_mae", **about), ["recording", "component"]
    rows = rows[rows["reason"].ne("fitted")]
    plain = rows[rows["estimate"] == UNGATED].set_index(key)["mae"]
    return leading(rows).join(plain.rename("plain"), on=key)


def split(results: Results) -> pd.DataFrame:
    """Return the parts of the error in contact by recording, and the sensor's bias."""
    bias = results.tables["sensed"].filter(regex="^recording$|^bias_")
    return results.rows("error_parts").merge(bias, "left")


def at_sensors(results: Results) -> pd.DataFrame:
    """Return the contacts at force sensors, with the leading estimate's errors, fate and cause."""
    rows = with_sharp_peaks(leading(results.rows("contact_errors", component="norm")))
    return rows.assign(role=rows["recording"].map(results.roles()))


def judged(results: Results) -> pd.DataFrame:
    """Return the rows of `decided` with repeatability (`floor`), and whether the sensor's bias is
    certain.
    """
    rows = results.with_floor(decided(results), "force")
    return rows.assign(sure=~rows["recording"].isin(results.doubted()))


def found_anywhere(results: Results) -> pd.DataFrame:
    """Return the contacts that the leading estimate finds on recordings with figures, with a sensor
    or without.
    """
    return results.rows("contacts", estimate=LEADING, recording=compared(results))


def force_errors(results: Results) -> pd.DataFrame:
    """Return all estimates' errors against the sensor, with repeatability (`floor`) in contact."""
    rows = results.rows("force_mae", kind="compensated", during=["contact", "free", "all"])
    rows = results.with_floor(rows, "force")
    return rows.assign(floor=rows["floor"].where(rows["during"] == "contact"))


def classes(results: Results) -> pd.DataFrame:
    """Return the numbers of contacts and of found ones by class of force, on recordings with a
    force sensor.
    """
    return results.rows("detection").dropna(subset="force_class_n")


def alarm_rates(results: Results) -> pd.DataFrame:
    """Return the alarms of recordings without a force sensor."""
    rows = results.rows("detection")
    return rows[rows["force_class_n"].isna()].assign(role=rows["recording"].map(results.roles()))
