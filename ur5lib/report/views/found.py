"""The findings of a study in short sentences; every number comes from its tables."""

from collections.abc import Iterator

import pandas as pd
from scipy.special import bdtr, bdtrc

from ur5lib.pipeline.estimates import ESTIMATES
from ur5lib.report.cells import fixed, rounded
from ur5lib.report.contents import MOST_SHOWN
from ur5lib.report.results import Results
from ur5lib.report.tables.models import STOP
from ur5lib.report.verdicts.link_model import compare, named
from ur5lib.report.views import claimed, comparison, printed, sensed
from ur5lib.report.views.audit import faults as wrist_sensor_faults
from ur5lib.report.views.contacts import counted, elsewhere, quiet, undetermined_moments
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import PUSHES, pushes_found, searched

IMPROBABLE = 0.025  # chance below which a number of intervals with the truth inside is remarkable
NOTHING = "The recordings show no contact, load, fault or difference between models."

UNSEARCHED = (
    "No contact was searched for: no friction was fitted and no force sensor recorded. No load, "
    "fault or difference between models was found."
)


def findings(results: Results) -> list[str]:
    """Return the findings, one item each, or the sentence that there are none."""
    told = [
        *stop_signs(results),
        *nearest_model(results),
        *printed.found(results),
        *loads_found(results),
        *counted(results),
        *elsewhere(results),
        *loads_taken_up(results),
        *sensed.readings(results),
        *_detection(results),
        *claimed.judged(results),
        *undetermined_moments(results.tables["force_mae"]),
        *wrist_sensor_faults(results),
        *beside_truth(results.tables.get("truth")),
        *comparison.found(results),
    ]
    looked = len(searched(results)) or len(results.tables["sensed"])
    return told or [NOTHING if looked else UNSEARCHED]


def stop_signs(results: Results) -> Iterator[str]:
    """Report what contradicts the study, so that no forces are stated."""
    rows = results.rows("quality", severity="stop")
    for row in rows[:MOST_SHOWN].itertuples():
        yield f"Stop sign on {row.recording}: {row.detail}. No forces are stated for it."
    if len(rows) > MOST_SHOWN:
        yield f"There are {len(rows)} stop signs in all; tables/quality.csv lists them."
    for row in results.rows("remarks", step=STOP).itertuples():
        yield f"Stop sign on {row.robot}: {row.remark}. No forces are stated for this arm."


def left_out(results: Results) -> list[str]:
    """Return the results that this study's data do not allow, with the reasons."""
    return [*results.left_out, *left_out_fits(results), *_not_compared(results)]


def left_out_heading(results: Results) -> list[str]:
    """Return the sentence above this list, if the list has entries."""
    return (
        ["The data of this study do not allow the following results:"] if left_out(results) else []
    )


def left_out_fits(results: Results) -> list[str]:
    """Return which fits were not possible, and why."""
    remarks = results.tables["remarks"]
    rows = remarks[remarks["joint"].isna() & (remarks["step"] != STOP)].itertuples()
    return [f"{row.step.capitalize()} of {row.robot}: {row.remark}." for row in rows]


def _not_compared(results: Results) -> Iterator[str]:
    """Report estimates that have nothing to be compared with."""
    if len(results.tables["friction"]) and not results.with_role("validate"):
        yield "Prediction of currents on unseen recordings: no recording has the role `validate`."
    if len(searched(results)) and results.tables["sensed"].empty:
        yield "Errors of the force estimates: no recording has a working force sensor."


def nearest_model(results: Results) -> Iterator[str]:
    """Report the model that is closest to the controller's torques, if the models differ."""
    compared = compare(results)
    if compared is None or compared.rows["model"].nunique() < 2:
        return
    if not compared.differ:
        yield "The link models compute the same torques: these recordings do not tell them apart."
        return
    where = "not used for fitting" if compared.unseen else "used for fitting, for want of others"
    best = " and ".join(map(named, compared.best))
    verb = "are" if len(compared.best) > 1 else "is"
    yield (
        f"Among the link models, {best} {verb} closest to the controller's torques on "
        f"{compared.near} of the {compared.differ} joints where the models differ, on recordings "
        f"{where}."
    )


def loads_found(results: Results) -> Iterator[str]:
    """Report the recordings with an undeclared load."""
    for row in loaded(results)[:MOST_SHOWN].itertuples():
        yield (
            f"On {row.recording}, the currents show an undeclared load of {rounded(row.mass, 2)} ± "
            f"{rounded(row.std_error, 2)} kg on the flange, which the predictions include."
        )


def loads_taken_up(results: Results) -> Iterator[str]:
    """Report the loads that the arm picked up during a run."""
    for row in results.rows("contacts", estimate="Fmap", kind="load")[:MOST_SHOWN].itertuples():
        yield (
            f"On {row.recording}, the arm takes up a load of {rounded(row.load_mass, 2)} ± "
            f"{rounded(row.load_mass_std, 2)} kg."
        )


def _detection(results: Results) -> Iterator[str]:
    """Report the contacts found, the false alarms, and the smallest push detected."""
    rows, name = results.rows("detection", estimate="Fmap"), ESTIMATES["Fmap"]
    least = rows[rows["force_class_n"] == rows["force_class_n"].min()]
    if len(least):
        yield (
            f"{name} finds {least['found'].sum():.0f} of the {least['contacts'].sum():.0f} "
            "contacts that force sensors measured."
        )
    free = quiet(results)
    if len(free):
        yield (
            f"On contact-free recordings that were not used for fitting, {name} raises "
            f"{free['alarms_per_min'].mean():.1f} false alarms per minute."
        )
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        axis = smallest.idxmax()[-1]
        yield (
            f"A push along {axis} is the hardest to detect: it must exceed "
            f"{fixed(smallest.max(), 0)} N to be found with a probability of 95 %."
        )


def beside_truth(truth: pd.DataFrame | None) -> Iterator[str]:
    """Report how many stated intervals contain the truth of a simulation, and how many should."""
    stated = pd.Series(dtype=object) if truth is None else truth["within95"].dropna()
    if len(stated):
        count, held = len(stated), int((stated == "yes").sum())
        yield (
            f"Of {count} values with a stated 95 % interval, {held} have the truth of the "
            "simulation inside this interval."
        )
        yield f"Right intervals hold {0.95 * count:.0f} of these truths{_surprise(held, count)}."


def _surprise(held: int, count: int) -> str:
    """Return what an improbable number of 95 % intervals with the truth inside says of them.

    By the binomial distribution, on the side where the number lies, for independent values.
    """
    many, few = bdtrc(held - 1, count, 0.95), bdtr(held, count, 0.95)
    chance, verdict = (many, "wide") if many < few else (few, "narrow")
    if chance >= IMPROBABLE:
        return ""
    return (
        f"; for independent values, the chance of as {'many' if many < few else 'few'} as found is "
        f"{rounded(100 * chance, 1)} %, so that the intervals are too {verdict}"
    )
