"""Contact forces: errors, bands, contacts found, alarms, readings of the sensor, the verdict."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from ur5lib.force.contact_wrench import (
    BREAKAWAY_SHARE,
    MIN_CONSTANT_ERROR,
    STATIC_SPEED,
)
from ur5lib.force.estimators import ESTIMATES, LEADING, NEW, SPOKEN
from ur5lib.report.page.document import MOST_SHOWN, Number, Verdict
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.baseline import MIN_GOOD_SKILL, ZERO_ESTIMATE, Rival, error_bar, state
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import (
    FORCE_COMPONENTS,
    SMALLEST_PUSHES,
    leading,
    pushes_found,
    searched,
)

CLAIMED_ESTIMATE, CLAIMED_COMPONENT = "F*", "Fz"  # by which the thesis detects pushes
FORCE_TOPIC = "Force in contact"
STATIC_ESTIMATE = "static"  # the estimate without any fit


def sentences(results: Results) -> list[str]:
    """Return sentences about errors in contact, bands, contacts and alarms."""
    return [
        *in_contact(results),
        *bands_held(results),
        *largest_contacts(results),
        *detection(results),
    ]


def in_contact(results: Results) -> Iterator[str]:
    """Report the errors of the leading estimate, in contact and free."""
    rows = results.rows("force_mae", kind="compensated", component=FORCE_COMPONENTS)
    touched = dict([*rows[rows["during"] == "contact"].groupby("recording", sort=False)])
    free = rows[rows["during"] == "free"]
    for name, contact in [*touched.items()][:MOST_SHOWN]:
        yield _errors_in_contact(contact, leading(free[free["recording"] == name]))
    if len(touched) > MOST_SHOWN:
        means = [leading(errors)[["mae", "mean_force"]].mean() for errors in touched.values()]
        better = sum(mean["mae"] < mean["mean_force"] for mean in means)
        yield say("contacts.better", better=better, count=len(touched))


def _errors_in_contact(contact: pd.DataFrame, free: pd.DataFrame) -> str:
    """Report one recording's errors in contact, with intervals and bands, and its free errors."""
    lead = leading(contact)
    recording, name = lead[["recording", "estimate"]].iloc[0]
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


def undetermined_moments(results: Results) -> Iterator[str]:
    """Report the moments that the leading estimate determines on no recording."""
    rows = leading(results.rows("force_mae", kind="compensated", during="contact"))
    moments = rows[rows["component"].str.startswith("n")]
    determined = {*moments.loc[moments["determined"] == "yes", "component"]}
    names = [name for name in moments["component"].unique() if name not in determined]
    if names:
        yield say("contacts.undetermined", moments=names, name=SPOKEN[rows["estimate"].iloc[0]])


def bands_held(results: Results) -> Iterator[str]:
    """Report the coverage of the stated bands, in contact and free."""
    rows = results.rows("force_mae", kind="compensated", component=FORCE_COMPONENTS)
    coverage = rows.pivot_table("coverage95", "estimate", "during", aggfunc="mean").reindex([*NEW])
    if {"contact", "free"} <= {*coverage}:
        complete = coverage.dropna(subset=["contact", "free"])
        yield say("contacts.averaged", held=[*complete.itertuples()])


def found_without_sensor(results: Results) -> dict[str, pd.DataFrame]:
    """Return the contacts that are found, by contact recording without a sensor."""
    searched = {*results.rows("detection", estimate=LEADING)["recording"]}
    names = results.with_role("contact", searched.difference(results.listed("force_mae")))
    contacts = results.rows("contacts", estimate=LEADING, kind="contact")
    by_recording = dict([*contacts.groupby("recording")])
    return {name: by_recording.get(name, contacts[:0]) for name in names}


def felt_while_fitted(results: Results) -> list[str]:
    """Return the recordings of the role fit on which contacts are found, by a fit without them."""
    contacts = results.rows("contacts", estimate=LEADING, kind="contact")
    return results.with_role("fit", contacts["recording"])


def counted(results: Results) -> Iterator[str]:
    """Report the number of contacts on each recording without a sensor, also zero."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        yield say("contacts.counted", name=name, count=len(rows))


def largest_contacts(results: Results) -> Iterator[str]:
    """Report the largest force on each contact recording without a sensor."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        if len(rows):
            largest = rows.loc[(rows[FORCE_COMPONENTS] ** 2).sum(axis="columns").idxmax()]
            yield say("contacts.largest", name=name, row=largest)


def elsewhere(results: Results) -> Iterator[str]:
    """Report the contacts that are not on the flange: stated forces hold only for the flange."""
    for name, rows in [*found_without_sensor(results).items()][:MOST_SHOWN]:
        if count := int((rows["off_flange"] == "yes").sum()):
            yield say("contacts.elsewhere", name=name, count=count, total=len(rows))


def detection(results: Results) -> Iterator[str]:
    """Report the contacts found by their force, those of the weakest that past samples alone show,
    and the smallest push detected along each axis.
    """
    rows = results.rows("detection", estimate=LEADING)
    by_class = rows.groupby("force_class_n")[["found", "contacts"]].sum()
    if len(by_class):
        yield say("contacts.found", classes=[*by_class.itertuples()])
        weakest = rows[rows["force_class_n"] == rows["force_class_n"].min()]
        rated = weakest.dropna(subset="causal_found")
        if len(rated):
            delays = [*rated["causal_delay_s"].dropna()]
            yield say("contacts.causal", rows=rated, delays=delays, most=MOST_SHOWN)
    smallest = pushes_found(results)[SMALLEST_PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield say("contacts.smallest", forces=smallest)


def quiet(results: Results) -> pd.DataFrame:
    """Return the alarms on validate recordings without an undeclared load, with the recordings'
    minutes; a recording has one row.
    """
    validated = results.with_role("validate")
    rows = results.rows("detection", estimate=LEADING, recording=validated)
    rows = rows[~rows["recording"].isin(loaded(results)["recording"])].drop_duplicates("recording")
    lengths = results.tables["recordings"].set_index("recording")["duration_s"]
    return rows.assign(minutes=rows["recording"].map(lengths).astype(float) / 60)


def false_alarms(results: Results) -> Iterator[str]:
    """Report the alarms where nothing touches the arm, of all samples and of past ones."""
    if len(results.rows("detection", estimate=LEADING)):
        rows = quiet(results)
        rate, causal = (a_minute(rows, f"{kind}alarms_per_min") for kind in ("", "causal_"))
        yield say("force.false alarms", minutes=rows["minutes"].sum(), rate=rate, causal=causal)


def a_minute(rows: pd.DataFrame, column: str) -> float:
    """Return the alarms a minute of recordings together, NaN where none has a rate."""
    rated = rows.dropna(subset=column)
    minutes = rated["minutes"].sum()
    return float((rated[column] * rated["minutes"]).sum() / minutes) if minutes else math.nan


class ClaimScore(NamedTuple):
    """How an estimate detects pushes along z.

    found: of all pushes that reach the threshold at the sensor; above: largest share of a
    contact-free recording for which the estimate is above it.
    """

    found: int
    pushes: int
    above: float


def score(results: Results, estimate: str) -> ClaimScore | None:
    """Return an estimate's score, None without such recordings.

    Pushes are counted on recordings with printed errors, time above on validate recordings.
    """
    printed, validated = results.printed("force_mae", "printed_mae"), results.with_role("validate")
    rows = {"component": CLAIMED_COMPONENT, "estimate": estimate}
    pushed = results.rows("fixed_threshold", recording=printed, **rows)
    free = results.rows("fixed_threshold", recording=validated, **rows)
    if pushed.empty or free.empty:
        return None
    detected, pushes = (int(pushed[name].sum()) for name in ("found", "pushes"))
    return ClaimScore(detected, pushes, float(free["time_above"].max()))


def claim(results: Results) -> Iterator[str]:
    """Report whether the claim holds, and why not."""
    if (claimed := score(results, CLAIMED_ESTIMATE)) is not None:
        yield say("claim.judged", claimed=claimed)


def scores(results: Results) -> list[str]:
    """Return a sentence with the scores of F̂*_z and ours, by which the claim is judged."""
    claimed, ours = score(results, CLAIMED_ESTIMATE), score(results, LEADING)
    if claimed is None or ours is None:
        return []
    named_scores = [(ESTIMATES[CLAIMED_ESTIMATE], claimed), (ESTIMATES[LEADING], ours)]
    return [say("claim.compared", pushes=claimed.pushes, scores=named_scores)]


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


def errors_in_contact(results: Results) -> pd.DataFrame:
    """Return the leading estimate's errors along x, y, z on recordings that no fit has seen."""
    rows = results.rows(
        "force_mae", kind="compensated", during="contact", component=FORCE_COMPONENTS
    )
    rows = leading(rows[~rows["recording"].isin(results.with_role("fit"))])
    return rows.assign(axis=rows["component"].str[1:])


def judge_force(results: Results) -> Verdict:
    """Judge the force by the larger relative error, that of the axis with the largest error or of
    the recording with the largest share, and by the smallest coverage of a stated band.
    """
    if results.stopped():
        return Verdict(FORCE_TOPIC, "do not use", say("force.stopped"))
    judged = errors_in_contact(results)
    if judged.empty:
        return _unjudged(results)
    rival = _least_squares(results, judged)
    row = judged.loc[judged["mae"].idxmax()]  # the axis with the largest error
    means = judged.groupby("recording", sort=False)[["mae", "mean_force"]].mean()
    share = means.loc[(means["mae"] / means["mean_force"]).idxmax()]  # the worst recording
    stated = judged.dropna(subset="coverage95")
    least_covered = stated.loc[stated["coverage95"].idxmin()] if len(stated) else None
    has_interval, calibrated = not pd.isna(row["mae_low"]), row["estimate"] != STATIC_ESTIMATE
    sure = row["mae_high"] < (1 - MIN_GOOD_SKILL) * row["mean_force"]  # not if it has no interval
    doubted = doubted_biases(results, [*means.index])
    relied = sure and calibrated and rival.better.empty and not doubted
    error = max(errors["mae"] / errors["mean_force"] for errors in (row, share))
    covered = 1.0 if least_covered is None else least_covered["coverage95"]
    about = {"known": has_interval, "calibrated": calibrated, "doubted": doubted}
    sentence = say("force.verdict", row=row, estimate=_named(row["estimate"]))
    return Verdict(
        topic=FORCE_TOPIC,
        state=state(error, 1.0, covered, tested=relied),
        sentence=rival.after(sentence, "N", 1),
        evidence=" ".join(
            [
                say(
                    "force.evidence",
                    row=row,
                    share=share,
                    held=least_covered,
                    zero=ZERO_ESTIMATE,
                    **about,
                ),
                *false_alarms(results),
            ]
        ),
        drawing=error_bar(row["mae"], row["mae_low"], row["mae_high"], row["mean_force"]),
        caption=say("force.caption", known=has_interval),
        numbers=tuple(_numbers(row, share, least_covered)),
    )


def doubted_biases(results: Results, among: list[str]) -> list[str]:
    """Return the recordings, of some, on which the force sensor's bias is uncertain."""
    doubt = {"device": "force", "severity": "warning", "finding": "offset"}
    return [*results.rows("quality", recording=among, **doubt)["recording"].unique()]


def _least_squares(results: Results, judged: pd.DataFrame) -> Rival:
    """Compare the leading estimate with least squares, means over x, y, z by recording."""
    rows = results.rows(
        "force_mae", kind="compensated", during="contact", component=FORCE_COMPONENTS
    )
    rows = rows[rows["recording"].isin(judged["recording"])]
    models = {judged["estimate"].iloc[0]: "ours", "least_squares": "rival"}
    return Rival.beside("least squares", rows, "mae", "recording", models)


def _named(estimate: str) -> str:
    """Return an estimate's name as used in sentences."""
    if estimate == STATIC_ESTIMATE:
        return f"{SPOKEN[estimate]} of the force"
    if SPOKEN[estimate] != ESTIMATES[estimate]:
        return SPOKEN[estimate]
    noun = "the controller's own force" if estimate == "Fu" else "the force"
    return f"{noun} {ESTIMATES[estimate]}"


def _numbers(row: pd.Series, share: pd.Series, least_covered: pd.Series | None) -> Iterator[Number]:
    """Yield the numbers of the evidence."""
    name = f"mean absolute error of {ESTIMATES[row['estimate']]}"
    place = f"{row['recording']}, along {row['axis']}, in contact"
    error = Number(name, float(row["mae"]), "N", place)
    yield error.within(row["mae_low"], row["mae_high"], "95 %").beside(
        row["mean_force"], ZERO_ESTIMATE
    )
    place = f"{share.name}, mean over x, y, z, in contact"
    yield Number(name, float(share["mae"]), "N", place).beside(share["mean_force"], ZERO_ESTIMATE)
    if least_covered is not None:
        place = f"{least_covered['recording']}, along {least_covered['axis']}, in contact"
        yield Number(
            "least share in the 95 % band", 100 * float(least_covered["coverage95"]), "%", place
        )


def _unjudged(results: Results) -> Verdict:
    """Return the verdict without a sensor that could judge the force."""
    if searched(results).empty:
        return Verdict(
            FORCE_TOPIC, "not determined", say("force.none"), " ".join(readings(results))
        )
    if len(results.tables["force_mae"]):
        return Verdict(FORCE_TOPIC, "not determined", say("force.untouched"))
    counts = [*map(len, found_without_sensor(results).values())]
    plausible = [say("force.plausible", counts=counts)] if counts else []
    evidence = " ".join([*plausible, *false_alarms(results)])
    return Verdict(FORCE_TOPIC, "not determined", say("force.no sensor"), evidence)
