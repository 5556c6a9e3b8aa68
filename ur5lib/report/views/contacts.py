"""Contact forces in sentences: errors in contact, bands, contacts found, alarms."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.pipeline.estimates import ESTIMATES, NEW, SPOKEN
from ur5lib.report.cells import listed, numbered, rounded
from ur5lib.report.contents import MOST_SHOWN
from ur5lib.report.results import Results
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import PUSHES, leading, likely, pushes_found

FORCES = ["Fx", "Fy", "Fz"]
FLANGE = 6  # the link that carries flange and tool


def told(results: Results) -> list[str]:
    """Return what the tables say about forces and contacts, in sentences."""
    force = results.tables["force_mae"]
    return [
        *in_contact(force),
        *bands_held(force),
        *largest_contacts(results),
        *detection(results),
    ]


def in_contact(force: pd.DataFrame) -> Iterator[str]:
    """Report the errors of the leading estimate in contact and free of contact."""
    forces = _forces(force)
    better = []
    for recording, rows in forces.groupby("recording", sort=False):
        contact, free = (rows[rows["during"] == during] for during in ("contact", "free"))
        if contact.empty:
            continue
        lead = leading(contact)
        better.append(lead["mae"].mean() < lead["mean_force"].mean())
        if len(better) <= MOST_SHOWN:
            yield " ".join(_errors_in_contact(str(recording), lead, contact, leading(free)))
    if len(better) > MOST_SHOWN:
        yield (
            f"On {sum(better)} of all {len(better)} recordings with a force sensor, the error in "
            "contact is smaller than that of an estimate of zero, averaged over x, y, z."
        )


def _errors_in_contact(
    recording: str, lead: pd.DataFrame, contact: pd.DataFrame, free: pd.DataFrame
) -> Iterator[str]:
    """Report one recording's errors in contact, with intervals and bands, and its free errors."""
    name = lead["estimate"].iloc[0]
    ends = zip(lead["mae_low"], lead["mae_high"], strict=True)
    ranges = ", ".join(f"{rounded(low, 1)} to {rounded(high, 1)}" for low, high in ends)
    known = "" if lead["mae_low"].isna().any() else f" (95 % intervals {ranges} N)"
    yield (
        f"On {recording}, the mean absolute error of {SPOKEN[name]} in contact (above 5 N at "
        f"the sensor) is {listed(lead['mae'], 1)} N in x, y, z{known}; the mean force there is "
        f"{listed(lead['mean_force'], 1)} N."
    )
    if lead["coverage95"].notna().all():
        held = listed(100 * lead["coverage95"], 0)
        yield f"Its 95 % bands contain {held} % of the readings in contact."
    baseline = contact[contact["estimate"] == "least_squares"]
    if len(baseline) and name != "least_squares":
        yield f"Least squares without a prior has an error of {listed(baseline['mae'], 1)} N there."
    if len(free):
        yield f"Free of contact, the error of {SPOKEN[name]} is {listed(free['mae'])} N."


def undetermined_moments(force: pd.DataFrame) -> Iterator[str]:
    """Report the moments that the leading estimate determines on no recording."""
    rows = leading(force[(force["kind"] == "compensated") & (force["during"] == "contact")])
    moments = rows[rows["component"].str.startswith("n")]
    known = moments[moments["determined"] == "yes"]
    unknown = [name for name in moments["component"].unique() if name not in {*known["component"]}]
    if unknown:
        several = len(unknown) > 1
        yield (
            f"The moment{'s' if several else ''} {', '.join(unknown)} "
            f"{'are' if several else 'is'} undetermined: on no recording is "
            f"{SPOKEN[rows['estimate'].iloc[0]]} in contact significantly better than an "
            "estimate of zero."
        )


def bands_held(force: pd.DataFrame) -> Iterator[str]:
    """Report the coverage of the stated bands, in contact and free."""
    rows = _forces(force)
    held = rows.pivot_table("coverage95", "estimate", "during", aggfunc="mean").reindex([*NEW])
    if {"contact", "free"} <= {*held}:
        parts = [
            f"{ESTIMATES[row.Index]} {100 * row.contact:.0f} % ({100 * row.free:.0f} %)"
            for row in held.dropna(subset=["contact", "free"]).itertuples()
        ]
        yield (
            "Averaged over recordings and axes, the stated 95 % bands contain these shares of the "
            f"force sensors' readings in contact (in brackets: free): {', '.join(parts)}."
        )


def found_without_sensor(results: Results) -> dict[str, int]:
    """Return the number of contacts that F̂ᵐᵃᵖ finds, by contact recording without a sensor."""
    sensed = {*results.tables["force_mae"]["recording"]}
    searched = {*results.rows("detection", estimate="Fmap")["recording"]}
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")["recording"]
    names = [name for name in results.with_role("contact") if name in searched - sensed]
    return {name: int((contacts == name).sum()) for name in names}


def counted(results: Results) -> Iterator[str]:
    """Report how many contacts recordings without a sensor hold, also if there are none."""
    for name, count in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        which = f"{count} contact{'s' if count > 1 else ''}" if count else "no contact"
        yield f"On {name}, which has no force sensor, {ESTIMATES['Fmap']} finds {which}."


def largest_contacts(results: Results) -> Iterator[str]:
    """Report the largest force on each contact recording without a sensor."""
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")
    for name, count in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        if count:
            rows = contacts[contacts["recording"] == name]
            largest = rows.loc[(rows[FORCES] ** 2).sum(axis="columns").idxmax()]
            values = ", ".join(
                f"{rounded(largest[axis], 1)} ± {largest[f'{axis}_std']:.1f}" for axis in FORCES
            )
            yield (
                f"On {name}, the largest force is {values} N in x, y, z, at "
                f"{largest['peak_s']:.1f} s.{_touched(likely(largest))}"
            )


def _touched(links: list[int]) -> str:
    """Return a sentence on where the contact of a stated force may be, if that is known."""
    if links == [FLANGE]:
        return " By the torques of the joints, the flange or a tool was touched."
    if FLANGE in links:
        return f" The torques of the joints do not tell which of links {numbered(links)} it is on."
    if links:
        told = f" By the torques of the joints, it is on link {numbered(links)}"
        return f"{told}, not on the flange, for which alone this force holds."
    return ""


def elsewhere(results: Results) -> Iterator[str]:
    """Report the contacts that are not on the flange, for which alone the forces hold."""
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")
    for name in [*found_without_sensor(results)][:MOST_SHOWN]:
        links = [likely(row) for row in contacts[contacts["recording"] == name].itertuples()]
        others = [own for own in links if own and FLANGE not in own]
        if others:
            yield (
                f"On {name}, {len(others)} of {len(links)} contacts are not on the flange, by the "
                "torques of the joints: their stated forces do not hold."
            )


def detection(results: Results) -> Iterator[str]:
    """Report the contacts found by their force, and the smallest push detected along each axis."""
    rows, name = results.rows("detection", estimate="Fmap"), ESTIMATES["Fmap"]
    by_class = rows.groupby("force_class_n")[["found", "contacts"]].sum()
    if len(by_class):
        parts = [
            f"{row.found:.0f} of {row.contacts:.0f} that reach {row.Index:.0f} N"
            for row in by_class.itertuples()
        ]
        yield (
            f"Of the contacts measured by force sensors, {name} finds {', '.join(parts)}, each "
            "with an alarm of its own."
        )
        yield from _causal(rows[rows["force_class_n"] == rows["force_class_n"].min()])
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield (
            f"{name} detects pushes above {listed(smallest, 0)} N along x, y, z with a "
            "probability of 95 % (median over motions without contact)."
        )


def _causal(rows: pd.DataFrame) -> Iterator[str]:
    """Report what is found from past samples only; rows: of the least class of contacts."""
    known = rows.dropna(subset="causal_found")
    if len(known):
        delays = known["causal_delay_s"].dropna()
        late = f", after {listed(delays)} s (median of each recording)" if len(delays) else ""
        yield (
            f"Alarms that use past data only find {known['causal_found'].sum():.0f} of "
            f"{known['contacts'].sum():.0f}{late}."
        )


def quiet(results: Results) -> pd.DataFrame:
    """Return the alarms of F̂ᵐᵃᵖ on validate recordings without an undeclared load."""
    rows = results.rows("detection", estimate="Fmap")
    rows = rows[rows["recording"].isin(results.with_role("validate"))]
    return rows[~rows["recording"].isin(loaded(results)["recording"])]


def _forces(force: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of the forces against the compensated sensor."""
    return force[(force["kind"] == "compensated") & force["component"].str.startswith("F")]
