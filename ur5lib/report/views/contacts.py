"""Contact forces in sentences: errors, bands, contacts found, alarms, readings of the sensor."""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from ur5lib.force.contact_wrench import BREAKAWAY, LEAST_ERROR, SLOW
from ur5lib.pipeline.estimators import ESTIMATES, NEW, SPOKEN
from ur5lib.report.document import MOST_SHOWN
from ur5lib.report.formats import Sentence
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import PUSHES, leading, leading_of_each, likely, pushes_found

FORCES = ["Fx", "Fy", "Fz"]
FLANGE = 6  # the link that carries flange and tool
CLAIMED, OURS, AXIS = "F*", "Fmap", "Fz"


def sentences(results: Results) -> list[str]:
    """Return sentences about errors in contact, bands, contacts and alarms."""
    force = results.tables["force_mae"]
    return [
        *in_contact(force),
        *bands_held(force),
        *largest_contacts(results),
        *detection(results),
    ]


def in_contact(force: pd.DataFrame) -> Iterator[Sentence]:
    """Report the errors of the leading estimate, in contact and free."""
    forces = _forces(force)
    touched = forces[forces["during"] == "contact"]
    names = touched["recording"].unique()
    for name in names[:MOST_SHOWN]:
        rows = forces[forces["recording"] == name]
        contact, free = (rows[rows["during"] == during] for during in ("contact", "free"))
        yield _errors_in_contact(str(name), leading(contact), contact, leading(free))
    if len(names) > MOST_SHOWN:
        means = leading_of_each(touched).groupby("recording")[["mae", "mean_force"]].mean()
        better = int((means["mae"] < means["mean_force"]).sum())
        yield say("contacts.better", better=better, count=len(names))


def _errors_in_contact(
    recording: str, lead: pd.DataFrame, contact: pd.DataFrame, free: pd.DataFrame
) -> Sentence:
    """Report one recording's errors in contact, with intervals and bands, and its free errors."""
    name = lead["estimate"].iloc[0]
    ends = lead[["mae_low", "mae_high"]].dropna().to_numpy()
    plain = contact.loc[contact["estimate"] == "least_squares", "mae"]
    return say(
        "contacts.errors",
        recording=recording,
        name=SPOKEN[name],
        lead=lead,
        ranges=ends.tolist() if len(ends) == len(lead) else [],
        held=100 * lead["coverage95"] if lead["coverage95"].notna().all() else None,
        plain=[] if name == "least_squares" else plain,
        free=free["mae"],
    )


def undetermined_moments(force: pd.DataFrame) -> Iterator[Sentence]:
    """Report the moments that the leading estimate determines on no recording."""
    rows = leading(force[(force["kind"] == "compensated") & (force["during"] == "contact")])
    moments = rows[rows["component"].str.startswith("n")]
    determined = {*moments.loc[moments["determined"] == "yes", "component"]}
    names = [name for name in moments["component"].unique() if name not in determined]
    if names:
        words = {"several": len(names) > 1, "name": SPOKEN[rows["estimate"].iloc[0]]}
        yield say("contacts.undetermined", moments=names, **words)


def bands_held(force: pd.DataFrame) -> Iterator[Sentence]:
    """Report the coverage of the stated bands, in contact and free."""
    rows = _forces(force)
    held = rows.pivot_table("coverage95", "estimate", "during", aggfunc="mean").reindex([*NEW])
    if {"contact", "free"} <= {*held}:
        known = held.dropna(subset=["contact", "free"])
        yield say("contacts.averaged", held=[*known.itertuples()])


def found_without_sensor(results: Results) -> dict[str, int]:
    """Return the number of contacts that F̂ᵐᵃᵖ finds, by contact recording without a sensor."""
    searched = {*results.rows("detection", estimate="Fmap")["recording"].unique()}
    without = searched.difference(results.listed("force_mae"))
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")["recording"]
    names = [name for name in results.with_role("contact") if name in without]
    return contacts.value_counts().reindex(names, fill_value=0).to_dict()


def felt_while_fitted(results: Results) -> list[str]:
    """Return the recordings of the role fit on which F̂ᵐᵃᵖ finds contacts, by a fit without them."""
    rows = results.rows("contacts", estimate="Fmap", kind="contact")
    found = {*rows["recording"].unique()}
    return [name for name in results.with_role("fit") if name in found]


def counted(results: Results) -> Iterator[Sentence]:
    """Report the number of contacts on each recording without a sensor, also zero."""
    for name, count in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        yield say("contacts.counted", name=name, estimate=ESTIMATES["Fmap"], count=count)


def largest_contacts(results: Results) -> Iterator[Sentence]:
    """Report the largest force on each contact recording without a sensor."""
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")
    for name, count in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        if count:
            rows = contacts[contacts["recording"] == name]
            largest = rows.loc[(rows[FORCES] ** 2).sum(axis="columns").idxmax()]
            place = {"links": likely(largest), "flange": FLANGE}
            yield say("contacts.largest", name=name, row=largest, **place)


def elsewhere(results: Results) -> Iterator[Sentence]:
    """Report the contacts that are not on the flange: stated forces hold only for the flange."""
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")
    for name in [*found_without_sensor(results)][:MOST_SHOWN]:
        links = [likely(row) for _, row in contacts[contacts["recording"] == name].iterrows()]
        others = [likely for likely in links if likely and FLANGE not in likely]
        if others:
            yield say("contacts.elsewhere", name=name, count=len(others), total=len(links))


def detection(results: Results) -> Iterator[Sentence]:
    """Report the contacts found by their force, and the smallest push detected along each axis."""
    rows, name = results.rows("detection", estimate="Fmap"), ESTIMATES["Fmap"]
    by_class = rows.groupby("force_class_n")[["found", "contacts"]].sum()
    if len(by_class):
        yield say("contacts.found", name=name, classes=[*by_class.itertuples()])
        yield from _causal(rows[rows["force_class_n"] == rows["force_class_n"].min()])
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield say("contacts.smallest", name=name, forces=smallest)


def _causal(rows: pd.DataFrame) -> Iterator[Sentence]:
    """Report the contacts found from past samples only; rows: those of the weakest contacts."""
    rated = rows.dropna(subset="causal_found")
    if len(rated):
        found, count = (int(rated[name].sum()) for name in ("causal_found", "contacts"))
        delays = [*rated["causal_delay_s"].dropna()]
        words = {"found": found, "count": count, "delays": delays, "most": MOST_SHOWN}
        yield say("contacts.causal", **words)


def quiet(results: Results) -> pd.DataFrame:
    """Return the alarms of F̂ᵐᵃᵖ on validate recordings without an undeclared load."""
    rows = results.rows("detection", estimate="Fmap")
    rows = rows[rows["recording"].isin(results.with_role("validate"))]
    return rows[~rows["recording"].isin(loaded(results)["recording"])]


def _forces(force: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of the forces against the compensated sensor."""
    return force[(force["kind"] == "compensated") & force["component"].str.startswith("F")]


class Score(NamedTuple):
    """How an estimate detects pushes along z.

    found: of all pushes that reach the threshold at the sensor; above: largest share of a
    contact-free recording for which the estimate is above it.
    """

    found: int
    pushes: int
    above: float

    @property
    def reliable(self) -> bool:
        """Whether every push is found and nothing else is above the threshold."""
        return self.found == self.pushes and self.above == 0


def score(results: Results, estimate: str) -> Score | None:
    """Return an estimate's score, None without such recordings.

    Pushes are counted on recordings with printed errors, time above on validate recordings.
    """
    rows = results.rows("fixed_threshold", component=AXIS, estimate=estimate)
    pushed = rows[rows["recording"].isin(results.printed("force_mae", "printed_mae"))]
    free = rows[rows["recording"].isin(results.with_role("validate"))]
    if pushed.empty or free.empty:
        return None
    found, pushes = (int(pushed[name].sum()) for name in ("found", "pushes"))
    return Score(found, pushes, float(free["time_above"].max()))


def claim(results: Results) -> Iterator[Sentence]:
    """Report whether the claim holds, and why not."""
    if (claimed := score(results, CLAIMED)) is not None:
        yield say("claim.judged", claimed=claimed)


def scores(results: Results) -> list[str]:
    """Return a sentence with the scores of F̂*_z and F̂ᵐᵃᵖ, by which the claim is judged."""
    claimed, ours = score(results, CLAIMED), score(results, OURS)
    if claimed is None or ours is None:
        return []
    both = [(ESTIMATES[CLAIMED], claimed), (ESTIMATES[OURS], ours)]
    return [say("claim.compared", pushes=claimed.pushes, scores=both)]


def touched(results: Results) -> list[str]:
    """Return the recordings on which a force sensor reads a contact, the strongest first."""
    rows = results.tables["sensed"]
    rows = rows[rows["contacts"] > 0].sort_values("largest_force_n", ascending=False)
    return [*rows["recording"]]


def readings(results: Results) -> Iterator[Sentence]:
    """Report largest force and share in contact by sensor, where no friction was fitted."""
    if len(results.tables["friction"]):
        return
    for row in results.tables["sensed"][:MOST_SHOWN].itertuples():
        yield say("sensed.reading", row=row)


def uncalibrated(results: Results) -> Iterator[Sentence]:
    """Report the assumptions of the static estimate, which replaces a fit."""
    if (results.tables["force_mae"]["estimate"] == "static").any():
        limits = {"error": LEAST_ERROR, "breakaway": BREAKAWAY, "slow": SLOW}
        yield say("sensed.uncalibrated", **limits)
