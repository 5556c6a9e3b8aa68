"""What a study found, in sentences; every number comes from its tables."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE, rounded
from ur5lib.report.estimates import ESTIMATES, NEW, PUBLISHED
from ur5lib.report.results import Results
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import PUSHES, leading, pushes_found

MOST_TOLD = 4  # recordings that get a sentence of their own


def findings(results: Results) -> list[str]:
    """The verdict, one finding an item."""
    torque, force = results.tables["torque_mae"], results.tables["force_mae"]
    return [
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
        _data_quality(results.tables["quality"]),
        *beside_truth(results.tables.get("truth")),
    ]


def left_out(results: Results) -> list[str]:
    """What this study's data do not allow, and why."""
    return [*results.left_out, *left_out_fits(results), *_not_compared(results)]


def left_out_heading(results: Results) -> list[str]:
    """Opens the list of these, if there are any."""
    return ["Left out, as this study's data do not allow it:"] if left_out(results) else []


def left_out_fits(results: Results) -> list[str]:
    """Which fits made nothing, and why."""
    remarks = results.tables["remarks"]
    rows = remarks[remarks["joint"].isna()].itertuples()
    return [f"{row.step.capitalize()} of {row.robot}: {row.remark}." for row in rows]


def _not_compared(results: Results) -> Iterator[str]:
    """What is estimated but stands beside nothing."""
    if len(results.tables["friction"]) and not results.with_role("validate"):
        yield "Prediction of currents on recordings not fitted on: none has the role validate."
    if len(results.tables["detection"]) and results.tables["force_mae"].empty:
        yield "Errors of force estimates: no recording has a working force sensor."


def _best_model(torque: pd.DataFrame, fitted: list[str]) -> Iterator[str]:
    """Which model misses the controller's torque least, where nothing was fitted if possible."""
    computed = torque[torque["mae"].notna()]
    if computed.empty:
        return
    unseen = computed[~computed["recording"].isin(fitted)]
    computed, which = (unseen, "that were not fitted on") if len(unseen) else (computed, "")
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
            f"Of the link models, {_model(winner)} comes nearest to the controller's torques on "
            f"{near[winner].sum()} of the {len(near)} joints where they differ"
            f"{f', {_listed(equal)} on as many' if equal else ''}."
        )
    yield (
        f"At the {motion} motion, {_model(winner)} misses the controller's torques by "
        f"{errors[winner]} Nm on joints 1 to 6, on the mean of the recordings {which}".rstrip()
        + f"{f' ({others} Nm)' if others else ''}; a torque of zero misses them by "
        f"{_list(zero, 3)} Nm."
    )


def _near_the_best(mean: pd.DataFrame) -> pd.DataFrame:
    """Whether a model (column) errs no more than the best, on joints (rows) where they differ."""
    above = mean.sub(mean.min(axis="columns"), axis="index")
    return above[above.max(axis="columns") > SMALLEST_DIFFERENCE] <= SMALLEST_DIFFERENCE


def _against_printed_torques(torque: pd.DataFrame) -> Iterator[str]:
    known = torque["mae"].notna() & torque["printed"].notna()
    rows = torque[known & (torque["motion"] == "closed_loop")]
    if len(rows):
        gap = (rows["mae"] - rows["printed"]).abs()
        worst = rows.loc[gap.idxmax()]
        yield (
            f"The published torque errors are met within {gap.max():.3f} Nm; the largest "
            f"difference is that of {_model(worst['model'])} on joint {worst['joint']}."
        )


def _accelerations(acceleration: pd.DataFrame) -> Iterator[str]:
    """How near joint encoders come to the IMU, on the mean of the recordings that have one."""
    rows = acceleration[acceleration["estimate"] == "encoders"]
    if len(rows):
        mean = rows.groupby("component", sort=False)[["mae", "zero_mae"]].mean()
        yield (
            "The end effector's acceleration from the joints' encoders alone misses the IMU by "
            f"{_list(mean['mae'][:3], 3)} m/s² in x, y, z, on the mean of "
            f"{rows['recording'].nunique()} recordings (no acceleration: "
            f"{_list(mean['zero_mae'][:3], 3)} m/s²)."
        )


def _currents(results: Results) -> Iterator[str]:
    """How well currents are predicted where nothing was fitted, or hangs on the flange."""
    rows, carrying = results.tables["current_rmse"], {*loaded(results)["recording"]}
    judged = rows[rows["recording"].isin({*results.with_role("validate")} - carrying)]
    mean = judged.groupby(["model", "joint"], sort=False)["rmse_2hz"].mean()
    if "fitted" in mean.index:
        known = "i_target" in mean.index and mean["i_target"].notna().all()
        beside = f" (the controller's target_current: {_list(mean['i_target'])} A)" if known else ""
        which = " without a load" if carrying else ""
        yield (
            f"On recordings to validate on{which}, motor currents below 2 Hz are predicted with "
            f"an RMSE of {_list(mean['fitted'])} A on joints 1 to 6{beside}."
        )


def loads_found(results: Results) -> Iterator[str]:
    """Which recordings carry more than was declared."""
    for row in loaded(results)[:MOST_TOLD].itertuples():
        yield (
            f"On {row.recording}, the currents tell of a load of {rounded(row.mass, 2)} ± "
            f"{rounded(row.std_error, 2)} kg on the flange that nobody declared. It is taken into "
            "the prediction of currents and forces; declare it as `payload` to be sure."
        )


def _against_printed_forces(force: pd.DataFrame) -> Iterator[str]:
    for figure, name in (("mae", "mean"), ("max", "largest")):
        rows = force[force[f"printed_{figure}"].notna()]
        if len(rows):
            gap = 100 * (rows[figure] / rows[f"printed_{figure}"] - 1).abs()
            widest = gap.groupby(rows["estimate"]).max()
            parts = [f"{label} within {widest[name]:.1f} %" for name, label in PUBLISHED.items()]
            yield f"The published {name} force errors are met: {', '.join(parts)}."


def in_contact(force: pd.DataFrame) -> Iterator[str]:
    """The leading estimate where something touches the arm, and where nothing does."""
    forces = _forces(force)
    better = []
    for recording, rows in forces.groupby("recording", sort=False):
        contact, free = (rows[rows["during"] == during] for during in ("contact", "free"))
        if contact.empty:
            continue
        lead = leading(contact)
        better.append(lead["mae"].mean() < lead["mean_force"].mean())
        if len(better) <= MOST_TOLD:
            yield " ".join(_told_of_contact(str(recording), lead, contact, leading(free)))
    if len(better) > MOST_TOLD:
        yield (
            f"In contact, on {sum(better)} of all {len(better)} recordings with a force sensor, "
            "the error is smaller than that of saying “no force”, on the mean over x, y, z."
        )


def _told_of_contact(
    recording: str, lead: pd.DataFrame, contact: pd.DataFrame, free: pd.DataFrame
) -> Iterator[str]:
    """One recording's errors in contact, their intervals and bands; then its free ones."""
    name = lead["estimate"].iloc[0]
    ends = zip(lead["mae_low"], lead["mae_high"], strict=True)
    ranges = ", ".join(f"{rounded(low, 1)} to {rounded(high, 1)}" for low, high in ends)
    known = "" if lead["mae_low"].isna().any() else f" (95 % intervals {ranges} N)"
    yield (
        f"On {recording}, in contact (above 5 N by the sensor), {ESTIMATES[name]} errs by "
        f"{_list(lead['mae'], 1)} N in x, y, z{known}, where the mean force is "
        f"{_list(lead['mean_force'], 1)} N."
    )
    if lead["coverage95"].notna().all():
        yield f"Its 95 % bands hold {_percent(lead['coverage95'])} % of the readings in contact."
    baseline = contact[contact["estimate"] == "least_squares"]
    if len(baseline) and name != "least_squares":
        yield f"Least squares without a prior errs by {_list(baseline['mae'], 1)} N there."
    if len(free):
        yield f"Free of contact, {ESTIMATES[name]} errs by {_list(free['mae'])} N."


def undetermined_moments(force: pd.DataFrame) -> Iterator[str]:
    """The moments of which the leading estimate knows nothing on any recording."""
    rows = leading(force[(force["kind"] == "compensated") & (force["during"] == "contact")])
    moments = rows[rows["component"].str.startswith("n")]
    known = moments[moments["determined"] == "yes"]
    unknown = [name for name in moments["component"].unique() if name not in {*known["component"]}]
    if unknown:
        yield (
            f"The moments {', '.join(unknown)} are undetermined: on no recording is "
            f"{ESTIMATES[rows['estimate'].iloc[0]]} in contact certainly better than “no moment”."
        )


def bands_held(force: pd.DataFrame) -> Iterator[str]:
    """What the stated bands hold, in contact beside free."""
    rows = _forces(force)
    held = rows.pivot_table("coverage95", "estimate", "during", aggfunc="mean").reindex([*NEW])
    if {"contact", "free"} <= {*held}:
        parts = [
            f"{ESTIMATES[row.Index]} {100 * row.contact:.0f} % ({100 * row.free:.0f} %)"
            for row in held.dropna(subset=["contact", "free"]).itertuples()
        ]
        yield (
            "Of the force sensors' readings in contact (in brackets: free of contact), the stated "
            f"95 % bands hold, on the mean over recordings and axes: {', '.join(parts)}."
        )


def contacts_found(results: Results) -> Iterator[str]:
    """What touches the arm where no sensor tells."""
    sensed = {*results.tables["force_mae"]["recording"]}
    contacts = results.rows("contacts", estimate="Fmap", kind="contact")
    felt = [name for name in results.with_role("contact") if name not in sensed]
    for recording in felt[:MOST_TOLD]:
        rows = contacts[contacts["recording"] == recording]
        if len(rows):
            force = rows[["Fx", "Fy", "Fz"]]
            largest = rows.loc[(force**2).sum(axis="columns").idxmax()]
            values = ", ".join(
                f"{rounded(largest[axis], 1)} ± {largest[f'{axis}_std']:.1f}" for axis in force
            )
            yield (
                f"On {recording}, without a force sensor, {ESTIMATES['Fmap']} finds contacts: "
                f"{len(rows)}. The largest force is {values} N in x, y, z, at "
                f"{largest['peak_s']:.1f} s."
            )


def loads_taken_up(results: Results) -> Iterator[str]:
    """What the arm picked up in mid-run."""
    contacts = results.rows("contacts", estimate="Fmap", kind="load")
    for row in contacts[:MOST_TOLD].itertuples():
        yield (
            f"On {row.recording}, the arm carries a load of {rounded(row.load_mass, 2)} ± "
            f"{rounded(row.load_mass_std, 2)} kg from {row.start_s:.1f} s on, by the currents."
        )


def _detection(results: Results) -> Iterator[str]:
    """How many contacts are found, how many made up, and how small a push is detected."""
    rows, name = results.rows("detection", estimate="Fmap"), ESTIMATES["Fmap"]
    counted = rows.groupby("force_class_n")[["found", "contacts"]].sum()
    if len(counted):
        parts = [
            f"{row.found:.0f} of {row.contacts:.0f} that reach {row.Index:.0f} N"
            for row in counted.itertuples()
        ]
        yield (
            f"Of the contacts that force sensors saw, {name} finds {', '.join(parts)}, each by an "
            "alarm of its own."
        )
    free = rows[rows["recording"].isin(results.with_role("validate"))]
    free = free[~free["recording"].isin(loaded(results)["recording"])]
    if len(free):
        yield (
            f"On contact-free recordings not fitted on, {name} raises "
            f"{free['alarms_per_min'].mean():.1f} false alarms a minute, on the mean."
        )
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield (
            f"{name} detects pushes above {_list(smallest, 0)} N along x, y, z with a "
            "probability of 95 % (median over motions without contact)."
        )


def _data_quality(quality: pd.DataFrame) -> str:
    counts = quality["severity"].value_counts()
    parts = [f"{counts.get(name, 0)} {name}s" for name in ("error", "warning", "note")]
    serious = quality[quality["severity"] != "note"]["finding"].value_counts()
    worst = ", ".join(f"{name} ({count})" for name, count in serious[:MOST_TOLD].items())
    return (
        f"Findings about the recordings' files: {', '.join(parts)}"
        f"{f'; most often {worst}' if worst else ''}."
    )


def beside_truth(truth: pd.DataFrame | None) -> Iterator[str]:
    """How many stated intervals hold the truth of a simulation."""
    if truth is not None and len(truth):
        stated = truth["within95"].dropna()
        yield (
            f"Of {len(stated)} values with a stated 95 % interval, {(stated == 'yes').sum()} "
            "intervals hold the truth of the simulation."
        )


def _forces(force: pd.DataFrame) -> pd.DataFrame:
    """Errors against the best reference, of forces."""
    return force[(force["kind"] == "compensated") & force["component"].str.startswith("F")]


def _model(name: str) -> str:
    """A model as one speaks of it: Model C, the model “identified”."""
    return f"Model {name}" if name[0].isupper() else f"the model “{name}”"


def _listed(models: list[str]) -> str:
    return " and ".join(map(_model, models))


def _percent(shares: pd.Series) -> str:
    """Shares in per cent."""
    return ", ".join(f"{100 * share:.0f}" for share in shares)


def _list(values: pd.Series, digits: int = 2) -> str:
    """Values with some decimals."""
    return ", ".join(rounded(value, digits) for value in values)
