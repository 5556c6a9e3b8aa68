"""What a study found, in sentences; every number comes from its tables."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE, rounded
from ur5lib.report.results import Results
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import ESTIMATES, NEW, PUBLISHED, PUSHES, pushes_found

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
        *_against_no_force(force),
        *contacts_found(results),
        *_trusted_force(force, results),
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
    """Which recordings carry more than the arm's model knows."""
    for row in loaded(results)[:MOST_TOLD].itertuples():
        yield (
            f"On {row.recording}, the currents tell of {rounded(row.mass, 2)} ± "
            f"{rounded(row.std_error, 2)} kg on the flange that the arm's model lacks: currents "
            "and forces predicted there miss that load."
        )


def _against_printed_forces(force: pd.DataFrame) -> Iterator[str]:
    for figure, name in (("mae", "mean"), ("max", "largest")):
        rows = force[force[f"printed_{figure}"].notna()]
        if len(rows):
            gap = 100 * (rows[figure] / rows[f"printed_{figure}"] - 1).abs()
            widest = gap.groupby(rows["estimate"]).max()
            parts = [f"{label} within {widest[name]:.1f} %" for name, label in PUBLISHED.items()]
            yield f"The published {name} force errors are met: {', '.join(parts)}."


def _against_no_force(force: pd.DataFrame) -> Iterator[str]:
    """Whether any estimate is better than saying "no force"."""
    forces = _forces(force)
    beaten = []
    for recording, rows in forces.groupby("recording", sort=False):
        zero = rows.drop_duplicates("component")["zero_mae"]
        mean = rows.groupby("estimate", sort=False)["mae"].mean()
        best = rows[rows["estimate"] == mean.idxmin()]
        beaten.append(best["mae"].mean() < best["zero_mae"].mean())
        if len(beaten) <= MOST_TOLD:
            yield (
                f"On {recording}, {ESTIMATES[mean.idxmin()]} comes nearest to the force sensor: "
                f"wrong by {_list(best['mae'])} N in x, y, z on the mean. It "
                f"beats an estimate that always says “no force” ({_list(zero)} N) "
                f"{_axes(best)}."
            )
    if len(beaten) > MOST_TOLD:
        yield (
            f"On {sum(beaten)} of all {len(beaten)} recordings with a force sensor, the best "
            "estimate beats “no force” on the mean over x, y, z."
        )


def _axes(errors: pd.DataFrame) -> str:
    """On which axes errors are smaller than those of no force."""
    better = errors["component"].str[-1][errors["mae"] < errors["zero_mae"]]
    every = {0: "on no axis", 3: "on every axis"}
    return every.get(len(better), f"on {' and '.join(better)} alone")


def contacts_found(results: Results) -> Iterator[str]:
    """What touches the arm where no sensor tells."""
    sensed = {*results.tables["force_mae"]["recording"]}
    contacts = results.rows("contacts", estimate="Fmap")
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


def _trusted_force(force: pd.DataFrame, results: Results) -> Iterator[str]:
    """How much the stated bands hold, and how small a push is still found."""
    rows = _forces(force)
    held = rows.groupby("estimate")["coverage95"].mean().reindex([*NEW]).dropna()
    if len(held):
        parts = [f"{ESTIMATES[name]} {100 * share:.0f} %" for name, share in held.items()]
        yield (
            "Of the force sensor's readings in x, y, z, the stated 95 % bands hold, on the mean: "
            f"{', '.join(parts)}."
        )
    smallest = pushes_found(results)[PUSHES].median(skipna=False)
    if smallest.notna().all():
        yield (
            f"By {ESTIMATES['Fmap']}, a push of {_list(smallest, 0)} N along x, y, z is found with "
            "a probability of 95 % (median over motions without contact)."
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


def _list(values: pd.Series, digits: int = 2) -> str:
    """Values with some decimals."""
    return ", ".join(rounded(value, digits) for value in values)
