"""Contacts found, alarms, readings of the sensor, forces by which the estimate is judged."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.force.contact_wrench import (
    BREAKAWAY_SHARE,
    MIN_CONSTANT_ERROR,
    STATIC_SPEED,
)
from ur5lib.force.estimators import LEADING, SPOKEN, UNGATED
from ur5lib.records.account import NOTHING
from ur5lib.records.contacts import OF_CONTACTS, OFF_FLANGE
from ur5lib.records.quality import UNUSUAL_FRICTION
from ur5lib.report.page.document import MOST_SHOWN
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.forces import FORCE_COMPONENTS, compared, contact_errors, leading

WRENCH_NAME = r"(?i)force|wrench|\bft[_x]|\bf_?[xyz]\b"  # among the columns of a file


def undetermined_moments(results: Results) -> Iterator[str]:
    """Report the moments that the leading estimate determines on no recording."""
    rows = leading(results.rows("force_mae", kind="compensated", during="contact"))
    moments = rows[rows["component"].str.startswith("n")]
    determined = {*moments.loc[moments["determined"] == "yes", "component"]}
    names = [name for name in moments["component"].unique() if name not in determined]
    if names:
        yield say("contacts.undetermined", moments=names, name=SPOKEN[rows["estimate"].iloc[0]])


def found_without_sensor(results: Results) -> dict[str, pd.DataFrame]:
    """Return the contacts that are found, by contact recording without a sensor."""
    searched = {*results.rows("detection", estimate=LEADING)["recording"]}
    names = results.with_role("contact", searched.difference(results.listed("force_mae")))
    contacts = results.rows("contacts", estimate=LEADING, kind=OF_CONTACTS)
    by_recording = dict([*contacts.groupby("recording")])
    return {name: by_recording.get(name, contacts[:0]) for name in names}


def counted(results: Results) -> Iterator[str]:
    """Report the number of contacts on each recording without a sensor, also zero."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        yield say("contacts.counted", name=name, count=len(rows))


def elsewhere(results: Results) -> Iterator[str]:
    """Report the contacts that are not on the flange: stated forces hold only for the flange."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        if times := [*rows.loc[rows["kind"] == OFF_FLANGE, "peak_s"]]:
            yield say("contacts.elsewhere", name=name, times=times, total=len(rows))


def touched(results: Results) -> list[str]:
    """Return the recordings on which a force sensor reads a contact, the strongest first."""
    rows = results.tables["sensed"].sort_values("largest_force_n", ascending=False)
    return [*rows.loc[rows["contacts"].astype(bool), "recording"]]


def readings(results: Results) -> Iterator[str]:
    """Report largest force and share in contact by sensor, where no friction was fitted."""
    if len(results.tables["friction"]):
        return
    for row in results.tables["sensed"][:MOST_SHOWN].itertuples():
        yield say("sensed.reading", row=row)


def uncalibrated(results: Results) -> Iterator[str]:
    """Report the assumptions of the static estimate, which replaces a fit."""
    if len(results.rows("force_mae", estimate="static")):
        yield say(
            "sensed.uncalibrated",
            error=MIN_CONSTANT_ERROR,
            breakaway=BREAKAWAY_SHARE,
            slow=STATIC_SPEED,
        )


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
    """Return of what the error in contact consists by recording, and the sensor's bias."""
    bias = results.tables["sensed"].filter(regex="^recording$|^bias_")
    return results.rows("error_parts").merge(bias, "left")


def explained(results: Results, recording: str) -> pd.DataFrame:
    """Return peak, impulse and onset of each contact, with the leading estimate's errors, fate and
    cause; doubted: whether the sensor's bias is.
    """
    rows = contact_errors(results, recording)
    why = rows["cause"].where(rows["cause"].notna(), rows["fate"])
    return rows.assign(why=why, doubted=recording in results.doubted())


def widest_band(results: Results) -> Iterator[str]:
    """Say in which posture the band of a contact's largest force is widest."""
    found = results.rows("noticed", role="contact").dropna(subset="band")
    for row in found.sort_values("band")[-1:].itertuples():
        yield say("contacts.widest band", row=row)


def unused_wrenches(results: Results) -> list[str]:
    """Return the recordings whose file has a wrench that is not used."""
    unused = results.rows("account", taken_for=NOTHING)
    named = unused["subject"].astype(str).str.contains(WRENCH_NAME)
    return sorted({*unused.loc[named, "recording"]})


def withheld(results: Results) -> Iterator[str]:
    """Say why a force was not stated or judged: friction hides it, or its wrench is not used."""
    for row in results.rows("quality", finding=UNUSUAL_FRICTION)[:MOST_SHOWN].itertuples():
        yield say("force.withheld", row=row)
    if unused := unused_wrenches(results):
        yield say("force.unused", names=unused)


def at_sensors(results: Results) -> pd.DataFrame:
    """Return the contacts at force sensors, with the leading estimate's errors, fate and cause."""
    rows = leading(results.rows("contact_errors", component="norm"))
    return rows.assign(role=rows["recording"].map(results.roles()))


def judged(results: Results) -> pd.DataFrame:
    """Return the rows of `decided` with repeatability (`floor`) and whether the sensor is sure."""
    rows = decided(results)
    places = zip(rows["recording"], rows["component"], strict=True)
    floors = [results.floor("force", name, component) for name, component in places]
    return rows.assign(floor=floors, sure=~rows["recording"].isin(results.doubted()))


def found_anywhere(results: Results) -> pd.DataFrame:
    """Return the contacts that the leading estimate finds on recordings with figures."""
    return results.rows("contacts", estimate=LEADING, recording=compared(results))


def force_errors(results: Results) -> pd.DataFrame:
    """Return all estimates' errors beside the sensor, with repeatability (`floor`) in contact."""
    rows = results.rows("force_mae", kind="compensated", during=["contact", "free", "all"])
    places = zip(rows["recording"], rows["component"], rows["during"], strict=True)
    floors = [
        results.floor("force", name, component) if during == "contact" else None
        for name, component, during in places
    ]
    return rows.assign(floor=floors)


def classes(results: Results) -> pd.DataFrame:
    """Return the contacts found by size of their force, of recordings with a force sensor."""
    return results.rows("detection").dropna(subset="force_class_n")


def alarm_rates(results: Results) -> pd.DataFrame:
    """Return the alarms of recordings without a force sensor."""
    rows = results.rows("detection")
    return rows[rows["force_class_n"].isna()].assign(role=rows["recording"].map(results.roles()))
