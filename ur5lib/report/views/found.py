"""The findings of a study in sentences; every number comes from its tables."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.pipeline.estimates import ESTIMATES, NEW, PUBLISHED
from ur5lib.report.cells import SMALLEST_DIFFERENCE, rounded
from ur5lib.report.findings import SEVERITIES
from ur5lib.report.results import Results
from ur5lib.report.tables.remarks import STOP
from ur5lib.report.views.audit import faults as wrist_sensor_faults
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import PUSHES, leading, pushes_found

MOST_NAMED = 4  # recordings that get a sentence of their own
SPOKEN = {"stop": "stop sign"}


def findings(results: Results) -> list[str]:
    """Return the findings, one item each."""
    torque, force = results.tables["torque_mae"], results.tables["force_mae"]
    return [
        *stop_signs(results),
        *_best_model(torque, results.with_role("fit")),
        *_against_printed_torques(torque),
        *_accelerations(results.tables["acceleration_mae"]),
        *_currents(results),
        *loads_found(results),
        *_against_printed_forces(force),
        *in_contact(force),
        *undetermined_moments(force),
        *bands_held(force),
        *contacts_found(results),
        *loads_taken_up(results),
        *_detection(results),
        *wrist_sensor_faults(results),
        _data_quality(results.tables["quality"]),
        *beside_truth(results.tables.get("truth")),
    ]


def stop_signs(results: Results) -> Iterator[str]:
    """Report what contradicts the study, so that no forces are stated."""
    rows = results.rows("quality", severity="stop")
    for row in rows[:MOST_NAMED].itertuples():
        yield f"Stop sign on {row.recording}: {row.detail}. No forces are stated for it."
    if len(rows) > MOST_NAMED:
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
    if len(results.tables["detection"]) and results.tables["force_mae"].empty:
        yield "Errors of the force estimates: no recording has a working force sensor."


def _best_model(torque: pd.DataFrame, fitted: list[str]) -> Iterator[str]:
    """Report the model nearest to the controller's torque, on unseen recordings if possible."""
    computed = torque[torque["mae"].notna()]
    if computed.empty:
        return
    unseen = computed[~computed["recording"].isin(fitted)]
    computed, which = (unseen, "that were not used for fitting") if len(unseen) else (computed, "")
    motion = computed["motion"].iloc[0]
    rows = computed[computed["motion"] == motion]
    mean = rows.pivot_table("mae", "joint", "model", aggfunc="mean")
    zero = rows.groupby("joint")["zero_mae"].mean()
    near = _near_the_best(mean)
    winner, *equal = near.columns[near.sum() == near.sum().max()]
    errors = {model: _list(mean[model], 3) for model in mean}
    others = "; ".join(f"{_model(model)}: {errors[model]}" for model in errors if model != winner)
    if len(errors) > 1:
        yield (
            f"Among the link models, {_model(winner)} is closest to the controller's torques on "
            f"{near[winner].sum()} of the {len(near)} joints where the models differ"
            f"{f', as is {_listed(equal)}' if equal else ''}."
        )
    yield (
        f"At the {motion} motion, the mean absolute error of {_model(winner)} against the "
        f"controller's torques is {errors[winner]} Nm on joints 1 to 6, averaged over the "
        f"recordings {which}".rstrip()
        + f"{f' ({others} Nm)' if others else ''}; the error of a torque of zero is "
        f"{_list(zero, 3)} Nm."
    )


def _near_the_best(mean: pd.DataFrame) -> pd.DataFrame:
    """Return whether a model (column) equals the best one, on joints (rows) where they differ."""
    above = mean.sub(mean.min(axis="columns"), axis="index")
    return above[above.max(axis="columns") > SMALLEST_DIFFERENCE] <= SMALLEST_DIFFERENCE


def _against_printed_torques(torque: pd.DataFrame) -> Iterator[str]:
    known = torque["mae"].notna() & torque["printed"].notna()
    rows = torque[known & (torque["motion"] == "closed_loop")]
    if len(rows):
        gap = (rows["mae"] - rows["printed"]).abs()
        worst = rows.loc[gap.idxmax()]
        yield (
            f"The published torque errors are reproduced within {gap.max():.3f} Nm; the largest "
            f"difference is that of {_model(worst['model'])} on joint {worst['joint']}."
        )


def _accelerations(acceleration: pd.DataFrame) -> Iterator[str]:
    """Report the error of the encoders against the IMU, averaged over recordings with one."""
    rows = acceleration[acceleration["estimate"] == "encoders"]
    if len(rows):
        mean = rows.groupby("component", sort=False)[["mae", "zero_mae"]].mean()
        yield (
            "The end effector's acceleration, computed from the joint encoders alone, differs from "
            f"the IMU's by {_list(mean['mae'][:3], 3)} m/s² in x, y, z, averaged over "
            f"{rows['recording'].nunique()} recordings (an acceleration of zero: "
            f"{_list(mean['zero_mae'][:3], 3)} m/s²)."
        )


def _currents(results: Results) -> Iterator[str]:
    """Report the prediction of currents on validation recordings without a load."""
    rows, carrying = results.tables["current_rmse"], {*loaded(results)["recording"]}
    judged = rows[rows["recording"].isin({*results.with_role("validate")} - carrying)]
    mean = judged.groupby(["model", "joint"], sort=False)["rmse_2hz"].mean()
    if "fitted" in mean.index:
        known = "i_target" in mean.index and mean["i_target"].notna().all()
        beside = f" (the controller's target_current: {_list(mean['i_target'])} A)" if known else ""
        which = " without a load" if carrying else ""
        yield (
            f"On the validate recordings{which}, motor currents below 2 Hz are predicted with an "
            f"RMSE of {_list(mean['fitted'])} A on joints 1 to 6{beside}."
        )


def loads_found(results: Results) -> Iterator[str]:
    """Report the recordings with an undeclared load."""
    for row in loaded(results)[:MOST_NAMED].itertuples():
        yield (
            f"On {row.recording}, the currents show an undeclared load of {rounded(row.mass, 2)} ± "
            f"{rounded(row.std_error, 2)} kg on the flange. The prediction of currents and forces "
            "includes it; declare it as `payload` to confirm it."
        )


def _against_printed_forces(force: pd.DataFrame) -> Iterator[str]:
    for figure, name in (("mae", "mean"), ("max", "largest")):
        rows = force[force[f"printed_{figure}"].notna()]
        if len(rows):
            gap = 100 * (rows[figure] / rows[f"printed_{figure}"] - 1).abs()
            widest = gap.groupby(rows["estimate"]).max()
            parts = [f"{label} within {widest[name]:.1f} %" for name, label in PUBLISHED.items()]
            yield f"The published {name} force errors are reproduced: {', '.join(parts)}."


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
        if len(better) <= MOST_NAMED:
            yield " ".join(_errors_in_contact(str(recording), lead, contact, leading(free)))
    if len(better) > MOST_NAMED:
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
        f"On {recording}, the mean absolute error of {ESTIMATES[name]} in contact (above 5 N at "
        f"the sensor) is {_list(lead['mae'], 1)} N in x, y, z{known}; the mean force there is "
        f"{_list(lead['mean_force'], 1)} N."
    )
    if lead["coverage95"].notna().all():
        yield f"Its 95 % bands contain {_percent(lead['coverage95'])} % of the readings in contact."
    baseline = contact[contact["estimate"] == "least_squares"]
    if len(baseline) and name != "least_squares":
        yield f"Least squares without a prior has an error of {_list(baseline['mae'], 1)} N there."
    if len(free):
        yield f"Free of contact, the error of {ESTIMATES[name]} is {_list(free['mae'])} N."


def undetermined_moments(force: pd.DataFrame) -> Iterator[str]:
    """Report the moments that the leading estimate determines on no recording."""
    rows = leading(force[(force["kind"] == "compensated") & (force["during"] == "contact")])
    moments = rows[rows["component"].str.startswith("n")]
    known = moments[moments["determined"] == "yes"]
    unknown = [name for name in moments["component"].unique() if name not in {*known["component"]}]
    if unknown:
        yield (
            f"The moments {', '.join(unknown)} are undetermined: on no recording is "
            f"{ESTIMATES[rows['estimate'].iloc[0]]} in contact significantly better than an "
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


def contacts_found(results: Results) -> Iterator[str]:
    """Report the contacts found on recordings without a force sensor."""
    sensed = {*results.tables["force_mae"]["recording"]}
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")
    felt = [name for name in results.with_role("contact") if name not in sensed]
    for recording in felt[:MOST_NAMED]:
        rows = contacts[contacts["recording"] == recording]
        if len(rows):
            force = rows[["Fx", "Fy", "Fz"]]
            largest = rows.loc[(force**2).sum(axis="columns").idxmax()]
            values = ", ".join(
                f"{rounded(largest[axis], 1)} ± {largest[f'{axis}_std']:.1f}" for axis in force
            )
            yield (
                f"On {recording}, which has no force sensor, {ESTIMATES['Fmap']} finds "
                f"{len(rows)} contact{'s' if len(rows) > 1 else ''}. The largest force is {values} "
                f"N in x, y, z, at {largest['peak_s']:.1f} s."
            )


def loads_taken_up(results: Results) -> Iterator[str]:
    """Report the loads that the arm picked up during a run."""
    contacts = results.rows("contacts", estimate="Fmap", kind="load")
    for row in contacts[:MOST_NAMED].itertuples():
        yield (
            f"On {row.recording}, the currents show that the arm carries a load of "
            f"{rounded(row.load_mass, 2)} ± {rounded(row.load_mass_std, 2)} kg from "
            f"{row.start_s:.1f} s on."
        )


def _detection(results: Results) -> Iterator[str]:
    """Report the contacts found, the false alarms, and the smallest push detected."""
    rows, name = results.rows("detection", estimate="Fmap"), ESTIMATES["Fmap"]
    counted = rows.groupby("force_class_n")[["found", "contacts"]].sum()
    if len(counted):
        parts = [
            f"{row.found:.0f} of {row.contacts:.0f} that reach {row.Index:.0f} N"
            for row in counted.itertuples()
        ]
        yield (
            f"Of the contacts measured by force sensors, {name} finds {', '.join(parts)}, each "
            "with an alarm of its own."
        )
    free = rows[rows["recording"].isin(results.with_role("validate"))]
    free = free[~free["recording"].isin(loaded(results)["recording"])]
    if len(free):
        yield (
            f"On contact-free recordings that were not used for fitting, {name} raises "
            f"{free['alarms_per_min'].mean():.1f} false alarms per minute on average."
        )
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield (
            f"{name} detects pushes above {_list(smallest, 0)} N along x, y, z with a "
            "probability of 95 % (median over motions without contact)."
        )


def _data_quality(quality: pd.DataFrame) -> str:
    counts = quality["severity"].value_counts()
    found = [(counts.get(name, 0), SPOKEN.get(name, name)) for name in SEVERITIES]
    parts = [f"{count} {name}{'s' if count > 1 else ''}" for count, name in found if count]
    serious = quality[quality["severity"] != "note"]["finding"].value_counts()
    worst = ", ".join(f"{name} ({count})" for name, count in serious[:MOST_NAMED].items())
    return (
        f"Findings about the recordings' files: {', '.join(parts) or 'none'}"
        f"{f'. Most frequent errors and warnings: {worst}' if worst else ''}."
    )


def beside_truth(truth: pd.DataFrame | None) -> Iterator[str]:
    """Report how many stated intervals contain the truth of a simulation."""
    if truth is not None and len(truth):
        stated = truth["within95"].dropna()
        yield (
            f"Of {len(stated)} values with a stated 95 % interval, {(stated == 'yes').sum()} have "
            "the truth of the simulation inside this interval."
        )


def _forces(force: pd.DataFrame) -> pd.DataFrame:
    """Return the errors of the forces against the compensated sensor."""
    return force[(force["kind"] == "compensated") & force["component"].str.startswith("F")]


def _model(name: str) -> str:
    """Return a model's name as used in sentences: Model C, the model “identified”."""
    return f"Model {name}" if name[0].isupper() else f"the model “{name}”"


def _listed(models: list[str]) -> str:
    return " and ".join(map(_model, models))


def _percent(shares: pd.Series) -> str:
    """Return shares in per cent."""
    return ", ".join(f"{100 * share:.0f}" for share in shares)


def _list(values: pd.Series, digits: int = 2) -> str:
    """Return values with some decimals."""
    return ", ".join(rounded(value, digits) for value in values)
