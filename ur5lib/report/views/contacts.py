"""Contact forces: errors, bands, contacts found, alarms, readings of the sensor, the verdict."""

import math
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.special import gammainc, gammaincinv

from ur5lib.force.contact_wrench import (
    BREAKAWAY_SHARE,
    MIN_CONSTANT_ERROR,
    STATIC_SPEED,
)
from ur5lib.force.estimators import ESTIMATES, LEADING, SPOKEN, UNGATED
from ur5lib.force.matching import match
from ur5lib.force.sensed_contact import CONTACT_FORCE
from ur5lib.records.account import NOTHING
from ur5lib.records.contacts import OF_CONTACTS
from ur5lib.records.quality import UNUSUAL_FRICTION
from ur5lib.report.page.document import MOST_SHOWN, Number, Verdict
from ur5lib.report.page.sentences import say
from ur5lib.report.results import AT_REST, Results
from ur5lib.report.views.baseline import (
    BETTER_RIVAL_RATIO,
    MAX_GOOD_FLOORS,
    MIN_GOOD_BAND_FACTOR,
    MIN_GOOD_SKILL,
    ZERO_ESTIMATE,
    Rival,
    state,
)
from ur5lib.report.views.currents import days_away, loaded
from ur5lib.report.views.forces import (
    FORCE_COMPONENTS,
    FORCE_STDS,
    contact_errors,
    contacts,
    flange_speeds,
    leading,
    searched,
)
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import Span, overlap

FORCE_TOPIC = "Force in contact"
MAX_DRIFT_ERROR = 1.0  # N/min, half of the 95 % interval of a drift that is determined
FATES = ["found", "merged", "missed"]  # of a contact: by its own alarm, by another one's, by none
WRENCH_NAME = r"(?i)force|wrench|\bft[_x]|\bf_?[xyz]\b"  # among the columns of a file
STATIC_ESTIMATE = "static"  # the estimate without any fit
MAX_BLIND_SHARE = 0.5  # of the time in contact in which a useful band may hold zero on every axis
MAX_CHANCE_OF_ALARMS = 0.05  # of as many in any recording, at the rate of the others
MIN_PUSH = 1.0  # mean force [N] along an axis that is pushed
USUAL_ALARMS, USUAL_SECONDS = 0.02, 60.0  # of false alarms where others tell nothing


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


def felt_while_fitted(results: Results) -> list[str]:
    """Return the recordings of the role fit on which more contacts are found, by a fit without
    them, than the rate of alarms on the arm's other ones, and on usual ones, lets expect.
    """
    kinds = [*OF_CONTACTS, "false"]  # a role makes them so
    found = results.rows("contacts", estimate=LEADING, kind=kinds)["recording"].value_counts()
    lengths = results.tables["recordings"].set_index("recording")["duration_s"].astype(float)
    fitted = results.with_role("fit")
    rows = pd.DataFrame({"arm": results.arms(), "alarms": found, "seconds": lengths}).loc[fitted]
    rows = rows.fillna({"alarms": 0})
    others = rows.groupby("arm")[["alarms", "seconds"]].transform("sum") - rows
    rate = (others["alarms"] + USUAL_ALARMS) / (others["seconds"] + USUAL_SECONDS)
    chance = gammainc(rows["alarms"], rate * rows["seconds"])  # of as many or more, by Poisson
    return [*rows.index[len(rows) * chance < MAX_CHANCE_OF_ALARMS]]


def counted(results: Results) -> Iterator[str]:
    """Report the number of contacts on each recording without a sensor, also zero."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        yield say("contacts.counted", name=name, count=len(rows))


def elsewhere(results: Results) -> Iterator[str]:
    """Report the contacts that are not on the flange: stated forces hold only for the flange."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        if times := [*rows.loc[rows["off_flange"] == "yes", "peak_s"]]:
            yield say("contacts.elsewhere", name=name, times=times, total=len(rows))


def quiet(results: Results, role: str = "validate") -> pd.DataFrame:
    """Return the alarms on recordings of a role without an undeclared load, with the recordings'
    minutes; a recording has one row.
    """
    rows = results.rows("detection", estimate=LEADING, recording=results.with_role(role))
    rows = rows[~rows["recording"].isin(loaded(results)["recording"])].drop_duplicates("recording")
    return rows.assign(minutes=_minutes(results, rows))


def _minutes(results: Results, rows: pd.DataFrame) -> pd.Series:
    """Return how long the recordings of rows last [min]."""
    lengths = results.tables["recordings"].set_index("recording")["duration_s"]
    return rows["recording"].map(lengths).astype(float) / 60


class FalseAlarms(NamedTuple):
    """Alarms where nothing touches the arm, in so many minutes in which that is known; unknown:
    share of all minutes in which it is not.
    """

    alarms: int
    minutes: float
    unknown: float = 0.0

    @classmethod
    def on(cls, rows: pd.DataFrame, kind: str = "") -> "FalseAlarms":
        """Count those of recordings, which have `minutes`; kind: "causal_", stated live."""
        counts = rows[f"{kind}alarms_per_min"] * rows["minutes"]
        minutes = rows.loc[counts.notna(), "minutes"]
        known = minutes * (1 - rows["causal_unknown"]) if kind else minutes
        total = float(known.sum())
        return cls(round(counts.sum()), total, 1 - total / minutes.sum() if total else 0.0)

    @property
    def most(self) -> float:
        """Upper limit of the rate: with more, so few would have a chance below 5 % (Poisson)."""
        return float(gammaincinv(self.alarms + 1, 0.95)) / self.minutes


def false_alarms(results: Results) -> dict[str, FalseAlarms | None]:
    """Return the alarms on quiet recordings: all, by the live estimate, both on days without a fit,
    the latter also on the day farthest from one; None where no recording tells.
    """
    rows = quiet(results)
    away = {n: d for own in results.robots() for n, d in days_away(results, own).items()}
    days = rows["recording"].map(away)
    other = rows[days > 0]
    found = {
        "all": FalseAlarms.on(rows),
        "past": FalseAlarms.on(rows, "causal_"),
        "other": FalseAlarms.on(other),
        "past_other": FalseAlarms.on(other, "causal_"),
        "past_far": FalseAlarms.on(rows[(days > 0) & (days == days.max())], "causal_"),
    }
    return {name: one if one.minutes else None for name, one in found.items()}


def false_by_role(results: Results) -> pd.DataFrame:
    """Return the false alarms of contact-free recordings by role, all and by the live estimate,
    with the upper limits of their rates, and the share of time in which the latter does not know.
    """
    found = []
    for role in ("fit", "validate"):
        rows = quiet(results, role)
        every, past = FalseAlarms.on(rows), FalseAlarms.on(rows, "causal_")
        if every.minutes:
            row = {"role": role, "recordings": len(rows), **every._asdict(), "most": every.most}
            live = (past.alarms, past.most, past.unknown) if past.minutes else [math.nan] * 3
            names = ("past", "past_most", "past_unknown")
            found.append(row | dict(zip(names, live, strict=True)))
    return pd.DataFrame(found)


def noticed_in_words(results: Results) -> Iterator[str]:
    """Say what the band holds for while contacts are missed, and how many alarms are false."""
    missed = errors_in_contact(results, "missed")
    if len(results.rows("detection", estimate=LEADING)):
        least = missed.loc[missed["coverage95"].idxmin()] if len(missed) else None
        yield say("force.while shut", least=least)
        yield say("force.false alarms", alarms=false_alarms(results))


def missed_contacts(results: Results) -> Iterator[str]:
    """Say how many contacts are missed, how large they are, and how many alarms may be false."""
    if len(listed := _listed(results)):
        sensed = at_sensors(results).set_index("fate")
        off = sensed.loc[sensed.index == FATES[0], "peak_error"].abs().max()
        missed = sensed.loc[sensed.index == FATES[-1], "peak"]
        unknown = sensed.loc[sensed["peak_error"].isna(), "recording"].unique()
        of_doubt = listed["recording"].isin(doubted_biases(results, [*listed["recording"]]))
        words: dict[str, Any] = {
            "strongest": missed.max(),
            "saturated": saturated(results, [*unknown]),
        }
        words["doubted"] = int(listed.loc[of_doubt, "contacts"].sum())
        yield say("force.missed", rows=listed, off=off, **words)
    if (alarms := false_alarms(results))["all"] is not None:
        yield say("force.most alarms", **alarms)


def _listed(results: Results) -> pd.DataFrame:
    """Return how many contacts are found, merged and missed, also live, of those that the table
    lists, and how many alarms are false beside them.
    """
    rows = results.rows("detection", estimate=LEADING, force_class_n=CONTACT_FORCE)
    merged = rows["merged"].astype(float).fillna(0.0)
    live = rows["contacts"] - rows["causal_found"] - rows["causal_merged"].astype(float).fillna(0.0)
    missed = rows["contacts"] - rows["found"] - merged
    minutes = _minutes(results, rows)
    beside = {
        f"{kind}beside": (rows[f"{kind}false_alarms_per_min"].astype(float) * minutes).round()
        for kind in ("", "causal_")
    }
    return rows.assign(merged=merged, missed=missed, missed_live=live, **beside)


def _numbers_of_alarms(results: Results) -> Iterator[Number]:
    """Yield how many contacts are missed and how many alarms are false."""
    if len(rows := _listed(results)):
        count, missed = (int(rows[name].sum()) for name in ("contacts", "missed"))
        least = f"of {CONTACT_FORCE:g} N or more at the sensor"
        yield Number("missed contacts", missed, f"of {count}", least)
    counted = false_alarms(results)
    if (alarms := counted["all"]) is not None:
        yield Number("false alarms without contact", alarms.alarms, f"in {alarms.minutes:.1f} min")
        name, other = "false alarms, upper limit", counted["other"]
        if other is not None and other.most > alarms.most:
            yield Number(name, other.most, "a minute", "95 %, on days without a fit recording")
        else:
            yield Number(name, alarms.most, "a minute", "95 %")


def touched(results: Results) -> list[str]:
    """Return the recordings on which a force sensor reads a contact, the strongest first."""
    rows = results.tables["sensed"]
    rows = rows[rows["contacts"] > 0].sort_values("largest_force_n", ascending=False)
    return [*rows["recording"]]


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


def errors_in_contact(results: Results, during: str = "contact") -> pd.DataFrame:
    """Return the leading estimate's errors along x, y, z on recordings that no fit has seen.

    during: "contact", or "missed", of contacts that it does not show.
    """
    rows = results.rows("force_mae", kind="compensated", during=during, component=FORCE_COMPONENTS)
    rows = leading(rows[~rows["recording"].isin(results.with_role("fit"))])
    return rows.assign(axis=rows["component"].str[1:])


def decided(results: Results) -> pd.DataFrame:
    """Return the errors by which the force is judged, beside the simplest rival and their floor."""
    rows, key = with_floors(results, errors_in_contact(results)), ["recording", "component"]
    others = results.rows("force_mae", kind="compensated", during="contact")
    plain = others[others["estimate"] == UNGATED].set_index(key)["mae"]
    return rows.join(plain.rename("plain"), on=key)


def worst_in_contact(results: Results) -> pd.DataFrame:
    """Return the one row of `decided` with the largest error, of recordings whose sensor's bias is
    sure, if there are any; empty without errors. uncertain: the largest error on the others.
    """
    known = decided(results)
    judged = with_sure_bias(results, known)
    others = known.drop(judged.index)["mae"]
    return (
        judged[judged.index == judged["mae"].idxmax()].assign(uncertain=others.max())
        if len(judged)
        else judged
    )


def with_sure_bias(results: Results, rows: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of recordings whose sensor's bias is sure, or all if none is."""
    doubted = doubted_biases(results, [*rows["recording"]])
    sure = rows[~rows["recording"].isin(doubted)]
    return rows if sure.empty else sure


def split(results: Results) -> pd.DataFrame:
    """Return of what the error in contact consists by recording, means over x, y, z, beside the
    sensor's bias and its drift where that is determined, with the largest error of this; friction:
    what neither alarms nor a gain explain; doubted: of the bias.
    """
    rows = errors_in_contact(results)
    names = ["mae", "mae_missed", "mae_shut", "mae_gain"]
    means = rows.groupby("recording", sort=False)[names].mean().dropna()
    friction = means["mae"] - means[names[1:]].sum(axis="columns")
    doubted = means.index.isin(doubted_biases(results, [*means.index]))
    parts = means.assign(friction=friction, doubted=doubted).reset_index()
    sensed, drifts = results.tables["sensed"], [f"drift_{axis}" for axis in "xyz"]
    errors = sensed[[f"drift_std_{axis}" for axis in "xyz"]].astype(float)
    told = NORMAL95 * errors.to_numpy() <= MAX_DRIFT_ERROR
    drift_std = errors.where(told).max(axis="columns")
    known = sensed.assign(drift_std=drift_std, **sensed[drifts].where(told))
    return parts.merge(known, "left")


def with_floors(results: Results, rows: pd.DataFrame) -> pd.DataFrame:
    """Return errors of forces by recording and component with what repetition alone leaves."""
    places = zip(rows["recording"], rows["component"], strict=True)
    floors = [results.floor("force", *place) for place in places]
    return rows.assign(floor=np.array(floors, dtype=float))


def noticed(results: Results) -> pd.DataFrame:
    """Return by recording which contacts are found, alarms, and the widest band.

    Recordings to fit or to validate are left out without alarms, each of which is false unless an
    undeclared load is felt.
    """
    rows = results.rows("detection", estimate=LEADING).drop_duplicates("recording")
    of_contacts = rows["recording"].isin(results.with_role("contact"))
    rows = rows[of_contacts | (rows["alarms_per_min"] > 0)]
    if rows.empty:
        return rows.assign(role="", band=math.nan)
    parts = [{**row, **_noticed_on(results, row["recording"])} for row in rows.to_dict("records")]
    found = pd.DataFrame(parts).assign(role=[*rows["recording"].map(results.roles())])
    false = found["alarms_per_min"].where(found["role"] != "contact", found["false_alarms_per_min"])
    carrying = found["recording"].isin(loaded(results)["recording"])
    return found.assign(false_alarms_per_min=false.mask(carrying))


def _noticed_on(results: Results, recording: str) -> dict[str, object]:
    """Return the contacts at the sensor, those without an alarm of their own, and the widest band.

    missed, merged: their starts [s]; strongest: peak of the strongest that is missed [N]; weakest:
    of the weakest that is found; band: half its width [N] along `axis` at `band_s` in a posture, of
    the largest force of an alarm.
    """
    alarms, sensed = contacts(results, recording), at_sensors(results, [recording])
    found, merged, missed = (sensed[sensed["fate"] == fate] for fate in FATES)
    own = alarms[alarms["off_flange"] != "yes"]  # whose stated forces hold
    stds = own.melt(["peak_s", "posture_deg"], FORCE_STDS, "column", "std").dropna(subset="std")
    noticed: dict[str, object] = {"contacts": len(sensed), "found": len(found), "band": math.nan}
    noticed |= {"missed": [*missed["start_s"]], "merged": [*merged["start_s"]]}
    noticed |= {"weakest": found["peak"].min(), "strongest": missed["peak"].max()}
    for row in stds.sort_values("std")[-1:].itertuples():
        noticed |= {"band": NORMAL95 * row.std, "axis": row.column[1], "band_s": row.peak_s}
        noticed |= {"posture": row.posture_deg}
    return noticed


def at_sensors(results: Results, recordings: list[str] | None = None) -> pd.DataFrame:
    """Return the contacts at the sensors of recordings, by default of all, with their fate: found
    by an alarm of their own, merged within another one's, or missed.
    """
    sensed = results.rows("contact_errors", estimate=LEADING, component="norm")
    names = sensed["recording"].unique() if recordings is None else recordings
    parts = []
    for name in names:
        rows = sensed[sensed["recording"] == name]
        raised, touches = _spans(contacts(results, name)), _spans(rows)
        own = {contact for _, contact in match(raised, touches)}
        felt = [any(overlap(alarm, touch) for alarm in raised) for touch in touches]
        fates = [FATES[0 if k in own else 1 if one else 2] for k, one in enumerate(felt)]
        parts.append(rows.assign(fate=fates))
    return pd.concat([sensed[:0].assign(fate=""), *parts])


def explained(results: Results, recording: str) -> pd.DataFrame:
    """Return peak, impulse and onset of each contact, with the leading estimate's errors, half the
    95 % `band` of the peak where an alarm finds it, and `why` it is off or missed; doubted: whether
    the sensor's bias is.
    """
    rows, sensed = contact_errors(results, recording), at_sensors(results, [recording])
    rows = rows.drop(columns=["fate", "cause", "band"], errors="ignore")  # computed anew
    alarms = contacts(results, recording)
    bands = NORMAL95 * _size_std(alarms).to_numpy()
    pairs, states = match(_spans(alarms), _spans(sensed)), flange_speeds(alarms)
    found = {sensed.index[contact]: bands[alarm] for alarm, contact in pairs}
    speeds = {sensed.index[contact]: states.iloc[alarm] for alarm, contact in pairs}
    band = pd.Series(found, sensed.index, float)
    doubted = bool(doubted_biases(results, [recording]))
    rows = rows.join(sensed["fate"]).assign(band=band, doubted=doubted)
    causes = _causes(rows, pd.Series(speeds, sensed.index, object))
    return rows.assign(why=rows["fate"].mask(rows["fate"] == FATES[0], causes))


def _size_std(alarms: pd.DataFrame) -> pd.Series:
    """Return the standard deviation of the size of each alarm's force."""
    parts = alarms[FORCE_COMPONENTS].to_numpy(float) * alarms[FORCE_STDS].to_numpy(float)
    return np.sqrt(pd.Series((parts**2).sum(axis=1), alarms.index)) / alarms["size"]


def _causes(rows: pd.DataFrame, states: pd.Series) -> pd.Series:
    """Return what makes most of the error of each contact; states: speed of the flange in words."""
    parts = rows[["mae_shut", "mae_gain"]].astype(float).fillna(0.0)
    friction = rows["mae"].astype(float) - parts.sum(axis="columns")
    parts.insert(0, "friction", friction.fillna(0.0))
    largest = parts.idxmax(axis="columns")
    return largest.mask((largest == "friction") & (states == AT_REST), "stiction")


def widest_band(results: Results) -> Iterator[str]:
    """Say in which posture the band of a contact's largest force is widest."""
    found = noticed(results).query("role == 'contact'").dropna(subset="band")
    for row in found.sort_values("band")[-1:].itertuples():
        yield say("contacts.widest band", row=row)


def _spans(rows: pd.DataFrame) -> list[Span]:
    """Return the times of rows [ms]."""
    return [*map(tuple, (1000 * rows[["start_s", "end_s"]]).round().astype(int).to_numpy())]


def judge_force(results: Results) -> Verdict:
    """Judge the force by the larger relative error, that of the axis with the largest error or of
    the recording with the largest share, by its rivals, and by its stated band: how much this
    holds, and whether it tells contact from none. Recordings whose sensor's bias is in doubt count
    where there are no others.
    """
    if results.stopped():
        return Verdict(FORCE_TOPIC, "do not use", say("force.stopped"))
    known = decided(results)
    if known.empty:
        return _unjudged(results)
    judged = with_sure_bias(results, known)
    row = worst_in_contact(results).iloc[0]  # the axis with the largest error
    means = judged.groupby("recording", sort=False)[["mae", "mean_force"]].mean()
    share = means.loc[(means["mae"] / means["mean_force"]).idxmax()]  # the worst recording
    rival, band = _plain(results, judged), _band(judged)
    doubted = doubted_biases(results, [*known["recording"].unique()])
    beaten = _beaten(judged, row) | {"blind": band is not None and band.blind > MAX_BLIND_SHARE}
    words = {"row": row, "share": share, "band": band, "zero": ZERO_ESTIMATE, "doubted": doubted}
    words |= {"known": not pd.isna(row["mae_low"])}
    words |= beaten | {"calibrated": row["estimate"] != STATIC_ESTIMATE}
    sure = row["mae_high"] < (1 - MIN_GOOD_SKILL) * row["mean_force"]  # not if it has no interval
    unbeaten = rival.better.empty and not beaten["equal"] and beaten["far"].empty
    relied = (
        sure and words["calibrated"] and unbeaten and doubted_biases(results, [*means.index]) == []
    )
    error = max(errors["mae"] / errors["mean_force"] for errors in (row, share))
    found = state(error, 1.0, 1.0 if band is None else band.least["coverage95"], tested=relied)
    sentence = say("force.verdict", estimate=_named(row["estimate"]), **words)
    return Verdict(
        topic=FORCE_TOPIC,
        state="do not use" if beaten["blind"] else found,
        sentence=rival.after(sentence, "N"),
        answers=(*missed_contacts(results), *bands_in_contact(results)),
        evidence=" ".join([say("force.evidence", **words), *noticed_in_words(results)]),
        numbers=tuple(_numbers(results, row, share, band)),
    )


def bands_in_contact(results: Results) -> Iterator[str]:
    """Say what the bands of the force are worth in contact, at rest and in motion."""
    rows = errors_in_contact(results).dropna(subset=["coverage95", "band_factor95"])
    rows = rows[rows["mean_force"] > MIN_PUSH]
    moves = np.array([bool(results.moving(name)) for name in rows["recording"]], dtype=bool)
    halves = {AT_REST: rows[~moves], "in motion": rows[moves]}
    sure = {when: with_sure_bias(results, part) for when, part in halves.items() if len(part)}
    if sure:
        doubted = [when for when in sure if doubted_biases(results, [*sure[when]["recording"]])]
        words = {"rows": sure, "doubted": doubted, "blind": MAX_BLIND_SHARE}
        yield say("force.band", **words, narrowest=MIN_GOOD_BAND_FACTOR)


def _beaten(judged: pd.DataFrame, worst: pd.Series) -> dict[str, Any]:
    """Return whether plain least squares does as well at the worst place (`equal`), and the rows
    that are farther above what repetition leaves than a good error is (`far`).
    """
    return {
        "equal": bool(worst["mae"] >= BETTER_RIVAL_RATIO * worst["plain"]),
        "far": judged[judged["mae"] > MAX_GOOD_FLOORS * judged["floor"]],
    }


class Band(NamedTuple):
    """What a stated 95 % band is worth in contact.

    least, widest: rows in which it holds least, and is too wide by the largest factor; blind: the
    largest share of the time in contact of a recording (`of`) in which it holds zero on every axis.
    """

    least: pd.Series
    widest: pd.Series
    blind: float
    of: str


def _band(judged: pd.DataFrame) -> Band | None:
    """Return the worth of the band of forces, None where none is stated."""
    stated = judged.dropna(subset="coverage95")
    if stated.empty:
        return None
    zeros = stated.set_index("recording")["zero_in_band95"].astype(float).fillna(0.0)
    least, widest = stated["coverage95"].idxmin(), stated["band_factor95"].astype(float).fillna(1.0)
    ends = stated.loc[least], stated.loc[widest.idxmin()]
    return Band(*ends, float(zeros.max()), str(zeros.idxmax()))


def doubted_biases(results: Results, among: list[str]) -> list[str]:
    """Return the recordings, of some, on which the force sensor's bias is uncertain."""
    doubt = {"device": "force", "severity": "warning", "finding": "offset"}
    return [*results.rows("quality", recording=among, **doubt)["recording"].unique()]


def saturated(results: Results, among: list[str]) -> list[str]:
    """Return the recordings, of some, on which the force sensor is saturated at times."""
    found = results.rows("quality", recording=among, device="force", finding="saturation")
    return [*found["recording"].unique()]


def _plain(results: Results, judged: pd.DataFrame) -> Rival:
    """Compare the leading estimate with plain least squares, means over x, y, z by recording."""
    rows = results.rows(
        "force_mae", kind="compensated", during="contact", component=FORCE_COMPONENTS
    )
    rows = rows[rows["recording"].isin(judged["recording"])]
    models = {judged["estimate"].iloc[0]: "ours", UNGATED: "rival"}
    return Rival.beside(ESTIMATES[UNGATED], rows, "mae", "recording", models)


def _named(estimate: str) -> str:
    """Return an estimate's name as used in sentences."""
    if estimate == STATIC_ESTIMATE:
        return f"{SPOKEN[estimate]} of the force"
    if SPOKEN[estimate] != ESTIMATES[estimate]:
        return SPOKEN[estimate]
    noun = "the controller's own force" if estimate == "Fu" else "the force"
    return f"{noun} {ESTIMATES[estimate]}"


def _numbers(
    results: Results, row: pd.Series, share: pd.Series, band: Band | None
) -> Iterator[Number]:
    """Yield the numbers of the evidence."""
    name = f"mean absolute error of {ESTIMATES[row['estimate']]}"
    place = f"{row['recording']}, along {row['axis']}, in contact"
    error = Number(name, float(row["mae"]), "N", place)
    error = error.within(row["mae_low"], row["mae_high"], "95 %").above(row["floor"])
    yield error.beside(row["mean_force"], ZERO_ESTIMATE)
    yield from _numbers_of_alarms(results)
    place = f"{share.name}, mean over x, y, z, in contact"
    yield Number(name, float(share["mae"]), "N", place).beside(share["mean_force"], ZERO_ESTIMATE)
    if band is not None:
        place = f"{band.least['recording']}, along {band.least['axis']}, in contact"
        covered = 100 * float(band.least["coverage95"])
        yield Number("least share in the 95 % band", covered, "%", place)


def unused_wrenches(results: Results) -> list[str]:
    """Return the recordings whose file has a wrench that is not used."""
    unused = results.rows("account", taken_for=NOTHING)
    named = unused["subject"].astype(str).str.contains(WRENCH_NAME)
    return sorted({*unused.loc[named, "recording"]})


def withheld(results: Results) -> Iterator[str]:
    """Say on which recordings no force is stated, since friction hides it."""
    for row in results.rows("quality", finding=UNUSUAL_FRICTION)[:MOST_SHOWN].itertuples():
        yield say("force.withheld", row=row)


def _unjudged(results: Results) -> Verdict:
    """Return the verdict without a sensor that could judge the force."""
    if searched(results).empty:
        evidence = " ".join([*withheld(results), *readings(results)])
        why = results.rows("remarks", step="contact forces")["remark"].unique()
        words = say("force.none", why=why)
        return Verdict(FORCE_TOPIC, "not determined", words, evidence=evidence)
    if len(results.tables["force_mae"]):
        return Verdict(FORCE_TOPIC, "not determined", say("force.untouched"))
    counts = [*map(len, found_without_sensor(results).values())]
    plausible = [say("force.plausible", counts=counts)] if counts else []
    evidence = " ".join([*plausible, *noticed_in_words(results)])
    return Verdict(
        FORCE_TOPIC,
        "not determined",
        sentence=say("force.no sensor", unused=unused_wrenches(results)),
        answers=tuple(missed_contacts(results)),
        evidence=evidence,
        numbers=tuple(_numbers_of_alarms(results)),
    )
