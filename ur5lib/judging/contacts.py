"""Found contacts, false alarms, and the smallest pushes that would be found."""

from collections.abc import Iterator, Mapping
from datetime import date
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import gammaincinv, stdtrit

from ur5lib.force.estimators import GATED, LEADING
from ur5lib.force.sensed_contact import CONTACT_FORCE
from ur5lib.judging.limits import (
    BELIEVED,
    GOOD_ALARM_RATE,
    MAX_GOOD_PEAK_ERROR,
    MAX_USUAL_THRESHOLD,
    UPPER_LIMIT,
)
from ur5lib.judging.study import AT_REST, IN_MOTION, StudyTables
from ur5lib.records.contacts import Fate, Kind, with_sharp_peaks
from ur5lib.records.pushes import YOURS
from ur5lib.records.verdicts import FalseAlarms, Noticed, Reason, Verdict, reason_in
from ur5lib.timeseries.metrics import NORMAL95

# Columns of detection.csv: what may be unseen.
LIMITS = "untouched_n", "hidden_n", "hidden_at_all_n", "unseen_link_2_n", "unseen_link_3_n"
EVERY_DAY, WITHOUT_FIT, FARTHEST = "all", "without fit", "farthest"  # choices of a recording's days


def at_sensors(study: StudyTables) -> pd.DataFrame:
    """Return the contacts of at least 5 N at the sensors, each with its fate (found, missed or
    merged) by the leading estimate, as rows of contact_errors.csv.

    Only recordings that no fit has used count, or all if these have no such contacts; then the
    column `fitted` is true.
    """
    rows = at_every_sensor(study)
    unseen = rows[~rows["recording"].isin(study.with_role("fit"))]
    moves = np.array([bool(study.moving(name)) for name in rows["recording"]], dtype=bool)
    rows = rows.assign(motion=np.where(moves, IN_MOTION, AT_REST), fitted=unseen.empty)
    return rows.loc[unseen.index] if len(unseen) else rows


def judge_contacts(study: StudyTables) -> Iterator[Verdict]:
    """Yield the number of found contacts, the force [N] above which none is missed, both also at
    rest and in motion, and the errors of peaks, where the sensor's bias is sure on any recording.
    """
    rows = at_sensors(study)
    if rows.empty:
        return
    about: dict[str, Any] = {
        "question": "contacts",
        "basis": "fit" if rows["fitted"].any() else "real",
    }
    doubt: Reason = "sensor_bias" if {*rows["recording"]} <= {*study.doubted()} else ""
    numbers = [_found(rows), _found_from(rows)]
    parts = [part for _, part in rows.groupby("motion")]
    if len(parts) > 1:
        numbers += [number for part in parts for number in (_found(part), _found_from(part))]
    numbers += [_of_fate(rows, fate) for fate in (Fate.MISSED, Fate.MERGED)]
    biased = rows["recording"].isin(study.doubted())
    sized = rows if biased.all() else rows[~biased]  # forces of these are known
    numbers += [*_peaks(sized), *_timing(sized)]
    if len(sized) < len(rows):
        numbers.append(_peak_error(rows[biased], ", sensor bias uncertain"))
    for rank, number in enumerate(filter(None, numbers), start=1):
        yield Verdict(**about | number, rank=rank, reason=doubt if rank == 1 else "")


def _found(rows: pd.DataFrame) -> dict[str, Any]:
    """Return the number of found contacts, as fields of a verdict."""
    count = int((rows["fate"] == Fate.FOUND).sum())
    about: dict[str, Any] = {
        "quantity": "contacts found",
        "sense": "more",
        "interval": "largest forces [N]",
    }
    about |= {"low": float(rows["peak"].min()), "high": float(rows["peak"].max())}
    return about | {"count": count, "of": len(rows)} | _motion_of(rows)


def _found_from(rows: pd.DataFrame) -> dict[str, Any]:
    """Return the smallest peak force [N] above that of all missed contacts; {} without one."""
    missed = rows.loc[rows["fate"] == Fate.MISSED, "peak"]
    above = rows[(rows["peak"] > missed.max()) | missed.empty]
    if above.empty:
        return {}
    least = above.loc[above["peak"].idxmin()]
    place = {"recording": str(least["recording"]), "count": len(above)}
    about = {"quantity": "no contact missed from", "value": float(least["peak"]), "unit": "N"}
    about |= {"sense": "from"}
    return about | place | _motion_of(rows)


def _motion_of(rows: pd.DataFrame) -> dict[str, Any]:
    motions = rows["motion"].unique()
    return {"motion": motions[0]} if len(motions) == 1 else {}


def _of_fate(rows: pd.DataFrame, fate: Fate) -> dict[str, Any]:
    """Return the number of contacts with a fate, missed or merged, and the largest of them, as
    fields of a verdict.
    """
    own = rows[rows["fate"] == fate]
    is_missed = fate == Fate.MISSED
    words = "contacts missed, the largest" if is_missed else "contacts in another's alarm"
    about: dict[str, Any] = {"quantity": words, "sense": "less"}
    about |= {"count": len(own), "of": len(rows)}
    if own.empty:
        return about
    most = own.loc[own["peak"].idxmax()]
    place = {"recording": str(most["recording"]), "motion": str(most["motion"])}
    return about | place | {"value": float(most["peak"]), "unit": "N"}


def _peaks(rows: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Yield the mean signed [%] and the largest [N] error of the peaks of found contacts."""
    found = rows[rows["fate"] == Fate.FOUND].dropna(subset="peak_error")
    if len(found):
        mean = _mean(100 * found["peak_error"] / found["peak"])
        quantity = "mean signed error of found peaks"
        yield mean | {"quantity": quantity, "sense": "error"}
        most = found.loc[found["peak_error"].abs().idxmax()]
        own = {"value": float(most["peak_error"]), "unit": "N", "recording": str(most["recording"])}
        about = {"quantity": "error of the peak of a found contact, largest", "sense": "error"}
        yield own | about


def _mean(shares: "pd.Series[float]") -> dict[str, Any]:
    """Return the mean of shares [%] with its 95 % interval by Student's t, none of a single one."""
    mean = float(shares.mean())
    found = {"value": mean, "unit": "%", "count": len(shares)}
    if len(shares) == 1:
        return found
    half = float(stdtrit(len(shares) - 1, (1 + BELIEVED) / 2) * shares.sem())
    return found | {"low": mean - half, "high": mean + half, "interval": "95 %"}


def _peak_error(rows: pd.DataFrame, where: str = "") -> dict[str, Any]:
    """Return the mean size of the error of the peaks of found contacts [%]; {} without any."""
    found = rows[rows["fate"] == Fate.FOUND]
    shares = (found["peak_error"] / found["peak"]).dropna()
    if shares.empty:
        return {}
    size = {"value": 100 * float(shares.abs().mean()), "unit": "%", "count": len(shares)}
    return size | {"quantity": f"mean absolute error of found peaks{where}", "sense": "less"}


def _timing(rows: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Yield how many peaks of found contacts lie in their 95 % bands and how many are far too
    small, their mean size of error [%] and the most that one is too small [N], the mean error of
    impulses [%], and the median delay [s].
    """
    found = rows[rows["fate"] == Fate.FOUND]
    banded = found.dropna(subset=["peak_error", "largest_band"])
    if len(banded):
        inside = (banded["peak_error"].abs() <= banded["largest_band"]).sum()
        quantity = "peaks within their 95 % bands"
        yield {"quantity": quantity, "sense": "more", "count": int(inside), "of": len(banded)}
    shares = (found["peak_error"] / found["peak"]).dropna()
    if len(shares):
        low = {"count": int((shares < -MAX_GOOD_PEAK_ERROR).sum()), "of": len(shares)}
        quantity = "peaks too small by more than a quarter"
        yield low | {"quantity": quantity, "sense": "less"}
    yield _peak_error(rows)
    short = found.loc[found["peak_error"] < 0].dropna(subset="peak_error")
    if len(short):
        row = short.loc[short["peak_error"].idxmin()]
        own = {"value": -float(row["peak_error"]), "unit": "N", "recording": str(row["recording"])}
        yield own | {"quantity": "largest shortfall of a peak", "sense": "less"}
    impulses = (found["impulse_error"] / found["impulse"]).dropna()
    if len(impulses):
        mean = _mean(100 * impulses)
        yield mean | {"quantity": "error of the impulse of found contacts, mean", "sense": "error"}
    delays = found["onset_error_s"].astype(float).dropna()
    if len(delays):
        median = {"value": float(delays.median()), "unit": "s", "count": len(delays)}
        yield median | {"quantity": "delay of found contacts, offline, median", "sense": "less"}


def detections(study: StudyTables) -> pd.DataFrame:
    """Return the row of detection.csv of each recording by the leading estimate: on contacts of at
    least 5 N, or on alarms alone without a sensor.
    """
    rows = study.rows("detection", estimate=LEADING)
    rows = rows[rows["force_class_n"].isna() | (rows["force_class_n"] == CONTACT_FORCE)]
    return rows.drop_duplicates("recording")


def noticed(study: StudyTables) -> Iterator[Noticed]:
    """Yield a row for each recording: its contacts by fate (found, missed, merged), its alarms, and
    the widest band.

    Recordings for fit or validation without contacts and alarms are left out.
    """
    sensed, roles = at_every_sensor(study), study.roles()
    alarms = study.rows("contacts", estimate=LEADING)
    for row in detections(study).itertuples():
        name = str(row.recording)
        touched = sensed[sensed["recording"] == name]
        raised = alarms[alarms["recording"] == name]
        if roles[name] == "contact" or len(touched) or len(raised):
            yield Noticed(
                recording=name,
                role=roles[name],
                **_contacts_on(touched),
                **_alarms_on(raised, row, study),
            )


def at_every_sensor(study: StudyTables) -> pd.DataFrame:
    """Return the contacts at the sensors that reach 5 N, of all recordings."""
    rows = with_sharp_peaks(study.rows("contact_errors", estimate=LEADING, component="norm"))
    return rows[(rows["peak"] >= CONTACT_FORCE) & rows["fate"].notna()]


def _contacts_on(rows: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers, times and peaks of one recording's contacts at the sensor, by fate
    (found, missed, merged).
    """
    found, merged, missed = (rows[rows["fate"] == fate] for fate in Fate)
    errors = (found["peak_error"] / found["peak"]).astype(float).dropna()
    return {
        "contacts": len(rows),
        "found": len(found),
        "merged": len(merged),
        "missed": len(missed),
        "missed_s": _times(missed["start_s"]),
        "merged_s": _times(merged["start_s"]),
        "largest_missed": _end(missed["peak"], "max"),
        "smallest_found": _end(found["peak"], "min"),
        "peak_bias": float(errors.mean()) if len(errors) else None,
    }


def _alarms_on(rows: pd.DataFrame, counts: Any, study: StudyTables) -> dict[str, Any]:
    """Return the numbers of alarms and false alarms, and the widest band of a contact.

    Where something may touch or load the arm, and no sensor says when, none is known to be false.
    """
    minutes = _minutes(study)[counts.recording]
    false: int | None = None
    if not pd.isna(counts.false_alarms_per_min):
        false = round(counts.false_alarms_per_min * minutes)
    elif study.roles()[counts.recording] != "contact" and counts.recording not in study.loaded():
        false = int((rows["kind"] == Kind.FALSE).sum())
    own = rows[rows["kind"] != Kind.OFF_FLANGE]  # stated forces are those of the flange
    bands = own.melt(
        ["peak_s", "posture_deg"], ["Fx_std", "Fy_std", "Fz_std"], "column", "std"
    ).dropna(subset="std")
    found: dict[str, Any] = {
        "alarms": len(rows),
        "alarms_per_min": len(rows) / minutes,
        "false_alarms": false,
    }
    found |= {name: getattr(counts, name, None) for name in LIMITS}
    if len(bands):
        row = bands.loc[bands["std"].idxmax()]
        found |= {"band": NORMAL95 * row["std"], "band_axis": row["column"][1]}
        found |= {"band_s": row["peak_s"], "posture_deg": row["posture_deg"]}
    return found


def _times(starts: "pd.Series[float]") -> str:
    return " ".join(f"{start:.1f}" for start in starts)


def _end(values: "pd.Series[float]", which: str) -> float | None:
    return float(getattr(values, which)()) if len(values) else None


def _minutes(study: StudyTables) -> "pd.Series[float]":
    """Return the duration of each recording [min], by name."""
    return study.tables["recordings"].set_index("recording")["duration_s"].astype(float) / 60


def false_alarms(study: StudyTables) -> Iterator[FalseAlarms]:
    """Yield the alarms where nothing touches the arm, by role and days."""
    away = days_away(study)
    for role in ("validate", "fit"):
        rows = detections(study)
        rows = rows[rows["recording"].isin(study.quiet(role))]
        minutes = rows["recording"].map(_minutes(study)).astype(float)
        days = rows["recording"].map(away).astype(float)
        alarms = rows["alarms_per_min"].astype(float) * minutes
        for when, part in of_days(
            pd.DataFrame({"alarms": alarms, "minutes": minutes, "days": days})
        ):
            yield FalseAlarms(role=role, estimate=LEADING, days=when, **counted(part))


def of_days(rows: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield (name, rows) of three parts of the rows: all days, days without a fit recording, and
    the day farthest from one.

    rows: with `days` from the nearest fit recording and `minutes`; parts of 0 minutes are left out.
    """
    days = rows["days"]
    parts = {EVERY_DAY: rows, WITHOUT_FIT: rows[days > 0]}
    parts[FARTHEST] = rows[(days > 0) & (days == days.max())]
    yield from ((when, part) for when, part in parts.items() if part["minutes"].sum() > 0)


def counted(rows: pd.DataFrame) -> dict[str, Any]:
    """Return the numbers of recordings, minutes and alarms, and the rate of alarms [1/min].

    rows: with `alarms` and `minutes`.
    """
    minutes, alarms = float(rows["minutes"].sum()), round(rows["alarms"].sum())
    return {
        "recordings": len(rows),
        "minutes": minutes,
        "alarms": alarms,
        "per_min": alarms / minutes,
        "per_min_high": upper_limit(alarms) / minutes,
    }


def upper_limit(count: int) -> float:
    """Return the one-sided 95 % upper limit of a Poisson mean from one observed count."""
    return float(gammaincinv(count + 1, UPPER_LIMIT))


def days_away(study: StudyTables) -> dict[str, int]:
    """Return by recording, dated and of the role `validate` or `contact`, the number of days to the
    nearest dated `fit` recording of its arm.
    """
    arms, roles, dates = study.arms(), study.roles(), study.dates()
    found = dict[str, int]()
    for robot in study.robots():
        own = {name: day for name, day in dates.items() if arms[name] == robot}
        found |= days_between(own, roles)
    return found


def days_between(dates: Mapping[str, date | None], roles: Mapping[str, str]) -> dict[str, int]:
    """Return by recording, dated and of the role `validate` or `contact`, the number of days to the
    nearest dated `fit` recording of the same arm.

    dates, roles: of one arm's recordings, by name.
    """
    dated = {name: day for name, day in dates.items() if day}
    fitted = [day for name, day in dated.items() if roles[name] == "fit"]
    return {
        name: min(abs((day - other).days) for other in fitted)
        for name, day in dated.items()
        if fitted and roles[name] in ("validate", "contact")
    }


def judge_alarms(study: StudyTables) -> Iterator[Verdict]:
    """Yield the false alarms on validate recordings with the upper limit of their rate, the same
    on days without a fit, the number on recordings with contacts and on all, and an unusual
    threshold.
    """
    rows = [row for row in false_alarms(study) if row.role == "validate"]
    numbers = [number for row in rows if row.days != FARTHEST for number in rates(row)]
    if not numbers and len(study.rows("detection", estimate=GATED)):
        why = study.why_unseen_is_missing()
        numbers.append({"quantity": "false alarms", "reason": why, "sense": "less"})
    every = [*noticed(study)]
    beside = [row for row in every if row.contacts]
    if any(row.alarms for row in beside):
        count = _false(beside)
        quantity = "false alarms on recordings with contacts"
        numbers.append({"quantity": quantity, "count": count, "sense": "less"})
    if numbers:
        numbers += _of_all(study, every)
        numbers += _high_threshold(detections(study)["threshold"])
    for rank, number in enumerate(numbers, start=1):
        yield Verdict(question="alarms", rank=rank, **number)


def _false(rows: list[Noticed]) -> int:
    return sum(row.false_alarms or 0 for row in rows)


def _of_all(study: StudyTables, every: list[Noticed]) -> Iterator[dict[str, Any]]:
    """Yield the number of false alarms on all searched recordings where a sensor or the role shows
    false ones, and the duration [min] of these.
    """
    untold = {row.recording for row in every if row.false_alarms is None} | {*study.loaded()}
    searched = detections(study)["recording"]
    searched = _minutes(study).reindex(searched[~searched.isin(untold)])
    if len(searched):
        yield from in_all(_false(every), float(searched.sum()))


def in_all(alarms: int, minutes: float) -> Iterator[dict[str, Any]]:
    """Yield the number of false alarms on all recordings that show them, and the minutes of these,
    as fields of verdicts.
    """
    yield {"quantity": "false alarms, all recordings", "count": alarms, "sense": "less"}
    quantity = "time of recordings that tell false alarms"
    yield {"quantity": quantity, "value": minutes, "unit": "min"}


def _high_threshold(thresholds: "pd.Series[float]") -> Iterator[dict[str, Any]]:
    """Yield the largest threshold of an arm's alarms, if it is above the usual ones."""
    if (most := float(thresholds.max())) > MAX_USUAL_THRESHOLD:
        quantity = f"log-odds that raise an alarm, usually below {MAX_USUAL_THRESHOLD:g}"
        yield {"quantity": quantity, "value": most, "sense": "less"}


def rates(row: FalseAlarms) -> Iterator[dict[str, Any]]:
    """Yield the number of false alarms, the minutes, and the upper limit of the rate [1/min]."""
    other = " on days without a fit recording" if row.days == WITHOUT_FIT else ""
    short = row.alarms == 0 and row.per_min_high > GOOD_ALARM_RATE
    unseen = {"basis": "unseen"}
    about = unseen | {"reason": "short" if short else ""}
    yield about | {"quantity": f"false alarms{other}", "count": row.alarms, "sense": "less"}
    about = unseen | {"quantity": f"time without contact{other}"}
    yield about | {"value": row.minutes, "unit": "min"}
    about = unseen | {"quantity": f"false alarms{other}, at most (95 %)", "sense": "at most"}
    yield about | {"value": row.per_min_high, "unit": "a minute"}


def judge_pushes(study: StudyTables, robot: str) -> Iterator[Verdict]:
    """Yield the smallest push [N] that trials find with a probability of 95 %.

    One verdict for each motion, on its worst axis and with the real contacts, the hardest motion
    first; then one for the best motion and axis; then its range over directions at postures.
    """
    rows = study.rows("pushes", robot=robot)
    if rows.empty:
        return
    sensed = at_sensors(study)
    worst = [_hardest(part) for _, part in rows.groupby("motion", sort=False)]
    order = sorted(worst, key=lambda row: -_size(row))
    for rank, row in enumerate(order, start=1):
        when = AT_REST if row["motion"] == AT_REST else IN_MOTION
        yield Verdict(question="pushes", arm=robot, rank=rank, **_trial(row), **_real(sensed, when))
    yield from _easiest(rows, robot, len(order))
    yield from _at_postures(study, robot, len(order) + 1)


def _trial(row: "pd.Series[Any]") -> dict[str, Any]:
    """Return the smallest trial push that is found, or the largest that was tried in vain."""
    beyond = row["bound"] == ">"
    value = row["largest_tried"] if beyond else row["value"]
    found = "not found" if beyond else "found with 95 %"
    about = {
        "reason": reason_in(row["reason"]),
        "quantity": f"trial push of {row['seconds']:g} s {found}",
        "sense": "beyond" if beyond else "from",
        "value": None if pd.isna(value) else float(value),
        "unit": "N",
        "axis": row.get("axes", row["axis"]),
        "motion": row["motion"],
        "basis": "fit" if row["basis"] == "fit" else "trial",
    }
    if beyond or pd.isna(value):
        return about
    return about | {"low": float(row["low"]), "high": float(row["high"]), "interval": "95 %"}


def _real(sensed: pd.DataFrame, motion: str) -> dict[str, Any]:
    """Return the force [N] above which no real contact at rest, or in motion, is missed; {} without
    such contacts.
    """
    rows = sensed[sensed["motion"] == motion]
    if rows.empty:
        return {}
    from_ = _found_from(rows).get("value")
    return {"rival": f"no real contact {motion} missed from", "rival_value": from_}


def _easiest(rows: pd.DataFrame, robot: str, rank: int) -> Iterator[Verdict]:
    """Yield the smallest push that is found with the best motion and axis."""
    if rows["value"].notna().any():
        row = rows.loc[rows["value"].astype(float).idxmin()]
        about = _trial(row) | {"quantity": "smallest trial push found along an axis, best motion"}
        yield Verdict(question="pushes", arm=robot, rank=rank + 1, **about | {"reason": ""})


def _at_postures(study: StudyTables, robot: str, rank: int) -> Iterator[Verdict]:
    """Yield the range of the push [N] over directions at all recorded postures that were tried, and
    at each of them.
    """
    every = study.rows("push_directions", robot=robot)
    rows, tried_on = every.dropna(subset="value"), every[every["posture"] != YOURS]
    recorded, tried = tried_on.dropna(subset="value"), len(tried_on)
    if recorded.empty:
        return
    count = tried_on["posture"].nunique()
    largest = float(study.rows("pushes", robot=robot)["largest_tried"].max())
    fitted = study.rows("pushes", robot=robot)["basis"].eq("fit").all()
    known: dict[str, Any] = {"question": "pushes", "arm": robot, "unit": "N"}
    known |= {"basis": "fit" if fitted else "trial"}
    yield Verdict(
        **known,
        rank=rank + 1,
        quantity="trial push found with 95 %, by posture and direction",
        **_range(tried_on, largest),
        interval=f"range over {tried} directions at {count} recorded postures",
    )
    for place, (posture, part) in enumerate(rows.groupby("posture", sort=False), start=rank + 2):
        yield _at_posture(
            part, every[every["posture"] == posture], largest, known | {"rank": place}
        )
    if lost := tried - len(recorded):
        quantity = f"directions without a push found, up to {largest:.0f} N"
        yield Verdict(
            **known | {"unit": "", "sense": "less"},
            rank=rank + 2 + rows["posture"].nunique(),
            quantity=quantity,
            count=lost,
            of=tried,
        )


def _at_posture(
    found: pd.DataFrame, tried: pd.DataFrame, largest: float, known: dict[str, Any]
) -> Verdict:
    """Return the range of the push over directions at one posture; the easiest one is that whose
    hardest direction needs the smallest push.
    """
    row = found.iloc[0]
    name = f"{row['posture']} posture"
    if row["posture"] == "easiest":
        name = "posture easiest in its hardest direction"
    return Verdict(
        **known,
        **_range(tried, largest),
        quantity=f"trial push found with 95 %, {name}",
        interval=f"range over {len(tried)} directions",
        recording="" if row["posture"] == YOURS else str(row["recording"]),
        motion=row["motion"],
        posture=str(row["posture_deg"]),
    )


def _range(rows: pd.DataFrame, largest: float) -> dict[str, Any]:
    """Return the range of found pushes, up to beyond the largest trial where one is not found."""
    low, high = float(rows["value"].min()), float(rows["value"].max())
    if rows["value"].isna().any():
        return {"sense": "beyond", "low": low, "high": largest}
    return {"sense": "from", "low": low, "high": high}


def _hardest(rows: pd.DataFrame) -> "pd.Series[Any]":
    """Return the row of the axis that needs the largest push; an axis without a found push counts
    as larger than all. `axes` names all such axes.
    """
    row = rows.loc[max(rows.index, key=lambda at: _size(rows.loc[at]))]
    beyond = rows.loc[rows["bound"] == ">", "axis"]
    return pd.Series({**row, "axes": " and ".join(beyond) if len(beyond) > 1 else row["axis"]})


def _size(row: "pd.Series[Any]") -> float:
    if row["bound"] == ">":
        return float("inf")
    return -1.0 if pd.isna(row["value"]) else float(row["value"])
