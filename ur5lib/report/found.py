"""Findings of a study in addition to its cards, and results that its data do not allow."""

import re
from collections.abc import Iterator

import pandas as pd

from ur5lib.errors import printable
from ur5lib.force.estimators import LEADING, SPOKEN
from ur5lib.judging.advice import CONTRADICTIONS
from ur5lib.records.account import NOTHING
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.contacts import OF_CONTACTS, Kind
from ur5lib.records.phrases import as_written, number
from ur5lib.records.quality import STOP
from ur5lib.report import topics
from ur5lib.report.results import Results
from ur5lib.report.stated import (
    alarms_on,
    capital,
    claim,
    joints,
    listed,
    overruled,
    quoted,
    with_error,
)
from ur5lib.report.views.forces import leading, searched
from ur5lib.report.views.recordings import accepted_signs

MOST_FINDINGS = 8  # on the page, to be readable; the tables have all
MOST_OF_A_KIND = 3
WRENCH_NAME = r"(?i)force|wrench|\bft[_x]|\bf_?[xyz]\b"  # matches columns with a wrench
ASIDE = re.compile(r"\((by itself, .*)\)$")  # the end of such a remark, with its numbers


def findings(results: Results) -> list[str]:
    """Return the findings in sentences, the gravest first: faults, findings of topics, then
    contacts; of many, the last sentence counts those left out and names their tables.
    """
    every = [
        (table, place, told) for table, own in _kinds(results) for place, told in enumerate(own)
    ]
    shown = [one for one in every if one[1] < MOST_OF_A_KIND]
    if len(shown) == len(every) <= MOST_FINDINGS:
        return [printable(told) for *_, told in every] or [*_unsearched(results)]
    shown = shown[: MOST_FINDINGS - 1]
    tables = dict.fromkeys(f"{one[0]}.csv" for one in every if one not in shown)
    more = f"{len(every) - len(shown)} more in {listed([*tables])}."
    return [*(printable(told) for *_, told in shown), more]


def _kinds(results: Results) -> Iterator[tuple[str, list[str]]]:
    """Yield (table that contains them, sentences) of each kind of findings, the gravest first."""
    yield "quality", [*_stopped_recordings(results)]
    yield "remarks", [*_stopped_arms(results)]
    yield "quality", [*_accepted(results)]
    yield "quality", [*_errors(results)]
    yield "remarks", [*_contradictions(results)]
    yield "payload", [*_undeclared_loads(results)]
    yield "uses", [*_felt(results)]
    yield "contacts", [*_off_flange(results)]
    yield "quality", [*_withheld(results)]
    yield "account", [*_unused_wrenches(results)]
    yield "force_mae", [*_undetermined_moments(results)]
    yield from topics.findings(results)
    yield "contacts", [*_taken_up(results)]
    yield "contacts", [*_without_sensor(results)]
    yield "sensed", [*_readings(results)]


def _stopped_recordings(results: Results) -> Iterator[str]:
    """Report recordings that contradict the study or cannot be read."""
    for row in results.rows("quality", severity="stop").itertuples():
        sign, line = overruled(row.detail)
        stop = f"Stop sign on “{row.recording}”: {sign}."
        known = {Found.UNREADABLE: f"“{row.recording}” is left out: {sign}.", Found.SAME_RUN: stop}
        yield known.get(row.code) or _without_forces(stop, line)


def _stopped_arms(results: Results) -> Iterator[str]:
    """Report the arms without stated forces."""
    for row in results.rows("remarks", step=STOP).itertuples():
        sign, line = overruled(row.remark)
        yield _without_forces(f"Stop sign on {row.robot}: {sign}.", line)


def _without_forces(stop: str, line: str) -> str:
    """Return the sentence of a stop sign with its consequence, that no force is stated, and the
    line of a study that overrules it.
    """
    return f"{stop} No forces are stated." + (f" If the study is right: `{line}`." if line else "")


def _accepted(results: Results) -> Iterator[str]:
    """Report the stop signs that the study overrules, with its reasons."""
    for one in accepted_signs(results):
        reason, _, sign = one["detail"].partition(": ")[2].partition("; found: ")
        yield f"On {quoted(one['of'])}, the study accepts a stop sign ({reason}): {claim(sign)}."


def _errors(results: Results) -> Iterator[str]:
    """Report each finding of the severity error, for example that a sensor is ignored or a role is
    wrong.
    """
    for row in results.rows("quality", severity="error").itertuples():
        yield f"On “{row.recording}”, {claim(row.detail)}."


def _contradictions(results: Results) -> Iterator[str]:
    """Report constants that contradict the documented ones."""
    rows = results.rows("remarks", code=[*CONTRADICTIONS, CauseCode.EXPLAINED_CONTRADICTION])
    for (robot, remark), group in rows.groupby(["robot", "remark"], sort=False):
        numbers = group["joint"].dropna()
        place = f"{joints(numbers)} of {robot}" if len(numbers) else robot
        aside = ASIDE.search(remark)
        yield f"{capital(place)}: {aside[1] if aside else claim(remark)}."


def _undeclared_loads(results: Results) -> Iterator[str]:
    """Report the undeclared loads that currents or torques prove."""
    rows = results.rows("payload", taken="yes")
    names, show = [*rows["recording"]], f"The {results.effort.quantity}s show"
    if len(names) == 1:
        mass, low, high = (number(rows[name].iloc[0], ".3g") for name in ("mass", "low", "high"))
        load = f"an undeclared load of {mass} kg on “{names[0]}”"
        yield f"{show} {load} (95 %: {low} to {high}), taken off the force."
    elif names:
        least, most = (number(end, ".3g") for end in (rows["mass"].min(), rows["mass"].max()))
        loads = f"undeclared loads of {least} to {most} kg"
        yield f"{show} {loads} on {len(names)} recordings: {quoted(names)}."


def _felt(results: Results) -> Iterator[str]:
    """Report fit recordings with more contacts than false alarms explain."""
    for name in results.rows("uses", purpose="fit", reason="felt")["recording"]:
        yield (
            f"“{name}”, role fit: {alarms_on(results, name)}, more than the other fit recordings "
            "explain; something touches the arm, or friction changed."
        )


def _without_a_sensor(results: Results) -> dict[str, pd.DataFrame]:
    """Return the found contacts, by contact recording without a sensor."""
    found = {*results.rows("detection", estimate=LEADING)["recording"]}
    names = results.with_role("contact", found.difference(results.listed("force_mae")))
    contacts = results.rows("contacts", estimate=LEADING, kind=OF_CONTACTS)
    return {name: contacts[contacts["recording"] == name] for name in names}


def _off_flange(results: Results) -> Iterator[str]:
    """Report the contacts that seem to be off the flange, with the link, where it is known; at
    rest, the stated forces are then wrong.
    """
    for name, rows in _without_a_sensor(results).items():
        off = rows[rows["kind"] == Kind.OFF_FLANGE]
        for at_rest, own in off.groupby(off["link"].isna()):
            times, one = [*own["peak_s"]], len(own) == 1
            their = "its force" if one else "their forces"
            where = f"where {their} would be wrong" if at_rest else f"most likely on {_links(own)}"
            yield (
                f"{len(own)} of {len(rows)} contacts on “{name}”, at {as_written(times, '.1f')} "
                f"s, {'seems' if one else 'seem'} to be off the flange, {where}."
            )


def _links(contacts: pd.DataFrame) -> str:
    """Return the likeliest links of contacts in words."""
    links = sorted({int(link) for link in contacts["link"]})
    return f"link{'s' * (len(links) > 1)} {', '.join(map(str, links))}"


def _without_sensor(results: Results) -> Iterator[str]:
    """Report the number of contacts, also 0, found on each recording without a sensor."""
    counts = {name: len(rows) for name, rows in _without_a_sensor(results).items()}
    if counts:
        each = [f"{count or 'none'} on “{name}”" for name, count in counts.items()]
        yield f"Contacts found without a force sensor: {listed(each)}."


def _withheld(results: Results) -> Iterator[str]:
    """Report recordings on which no force is stated because friction hides it."""
    for row in results.rows("quality", code=Found.UNUSUAL_FRICTION).itertuples():
        yield f"No force is stated on “{row.recording}”: {claim(row.detail)}."


def _unused_wrenches(results: Results) -> Iterator[str]:
    """Report the recordings that have an unused wrench in their file."""
    rows = results.rows("account", taken_for=NOTHING)
    named = rows["subject"].astype(str).str.contains(WRENCH_NAME)
    if names := sorted({*rows.loc[named, "recording"]}):
        yield f"The wrench in the files of {quoted(names)} is not used; account.csv says why."


def _undetermined_moments(results: Results) -> Iterator[str]:
    """Report the moments that the leading estimate determines on no recording."""
    rows = leading(results.rows("force_mae", kind="compensated", during="contact"))
    moments = rows[rows["component"].str.startswith("n")]
    determined = {*moments.loc[moments["determined"] == "yes", "component"]}
    if names := [name for name in moments["component"].unique() if name not in determined]:
        moments_of = f"Do not use the moments {listed(names)}"
        whose = SPOKEN[str(moments["estimate"].iloc[0])]
        yield f"{moments_of} of {whose}: on no recording are they reliably better than zero."


def _taken_up(results: Results) -> Iterator[str]:
    """Report loads that the arm picks up."""
    for row in results.rows("contacts", estimate=LEADING, kind=Kind.LOAD).itertuples():
        mass = with_error(row.load_mass, row.load_mass_std)
        yield f"The arm takes up a load of {mass} kg on “{row.recording}”."


def _readings(results: Results) -> Iterator[str]:
    """Report the largest force and the share of time in contact by each sensor, if no friction was
    fitted.
    """
    if len(results.tables["friction"]):
        return
    for row in results.tables["sensed"].itertuples():
        yield (
            f"The force sensor on “{row.recording}” reads at most "
            f"{number(row.largest_force_n, '.1f')} N, and contacts in "
            f"{100 * row.share_in_contact:.0f} % of the time."
        )


def _unsearched(results: Results) -> Iterator[str]:
    """Report that no contacts were searched for, so that their absence means nothing."""
    if searched(results).empty and results.tables["sensed"].empty:
        why = (
            "no force was estimated"
            if len(results.tables["friction"])
            else "no friction was fitted"
        )
        yield f"No contact was searched for: {why}, and no force sensor recorded."


def left_out(results: Results) -> list[str]:
    """Return results that the study's data do not allow or leave in doubt, with the reasons."""
    reasons = [*map(printable, _left_out_fits(results))]
    if len(results.tables["friction"]) and not results.with_role("validate"):
        quantity = results.effort.quantity
        reasons.append(f"Prediction of {quantity}s: no recording has the role validate.")
    if len(searched(results)) and results.tables["sensed"].empty:
        reasons.append("Errors of the force: no recording has a working force sensor.")
    return reasons


def _left_out_fits(results: Results) -> Iterator[str]:
    """Report the fits that were not possible or are in doubt."""
    remarks = results.tables["remarks"]
    asked = remarks["code"] == CauseCode.HIDDEN_CONTACT  # in what to do next
    for row in remarks[remarks["joint"].isna() & (remarks["step"] != STOP) & ~asked].itertuples():
        why = claim(row.remark).partition(", which ")[0]
        yield f"{capital(row.step)} of {row.robot}: {why}."
