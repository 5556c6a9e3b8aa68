"""What a study found, in sentences; every number comes from its tables."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.report.cells import SMALLEST_DIFFERENCE
from ur5lib.report.force_section import ESTIMATES, PUBLISHED


def findings(torque: pd.DataFrame, force: pd.DataFrame, quality: pd.DataFrame) -> list[str]:
    """The verdict, one sentence a finding. torque, force, quality: the tables of these names."""
    return [
        *_best_model(torque),
        *_against_printed_torques(torque),
        *_against_printed_forces(force),
        *_against_no_force(force),
        _data_quality(quality),
    ]


def _best_model(torque: pd.DataFrame) -> Iterator[str]:
    """Which model misses the controller's torque least, joint by joint."""
    computed = torque[torque["mae"].notna()]
    if computed.empty:
        return
    motion = computed["motion"].iloc[0]
    mean = computed[computed["motion"] == motion].pivot_table(
        "mae", "joint", "model", aggfunc="mean"
    )
    differ = mean.max(axis="columns") - mean.min(axis="columns") > SMALLEST_DIFFERENCE
    best = mean.idxmin(axis="columns")[differ]
    winner = mean.columns[0] if best.empty else best.mode()[0]
    errors = {model: ", ".join(f"{value:.3f}" for value in mean[model]) for model in mean}
    others = "; ".join(f"Model {model}: {errors[model]}" for model in errors if model != winner)
    if len(errors) > 1:
        yield (
            f"Model {winner} comes nearest to the controller's torques on "
            f"{(best == winner).sum()} of the {len(best)} joints where the models differ."
        )
    yield (
        f"At the {motion} motion, Model {winner} misses the controller's torques by "
        f"{errors[winner]} Nm on joints 1 to 6, on the mean of the recordings"
        f"{f' ({others} Nm)' if others else ''}."
    )


def _against_printed_torques(torque: pd.DataFrame) -> Iterator[str]:
    known = torque["mae"].notna() & torque["printed"].notna()
    rows = torque[known & (torque["motion"] == "closed_loop")]
    if len(rows):
        gap = (rows["mae"] - rows["printed"]).abs()
        worst = rows.loc[gap.idxmax()]
        yield (
            f"The published torque errors are met within {gap.max():.3f} Nm; the largest "
            f"difference is Model {worst['model']}'s on joint {worst['joint']}."
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
    forces = force[(force["kind"] == "compensated") & force["component"].str.startswith("F")]
    for recording, rows in forces.groupby("recording", sort=False):
        zero = rows.drop_duplicates("component")["zero_mae"]
        mean = rows.groupby("estimate", sort=False)["mae"].mean()
        best = rows[rows["estimate"] == mean.idxmin()]
        verb = "beats" if (best["mae"] < best["zero_mae"]).all() else "does not beat"
        yield (
            f"On {recording}, {ESTIMATES[mean.idxmin()]} comes nearest to the force sensor: wrong "
            f"by {_list(best['mae'])} N in x, y, z on the mean. It {verb} an estimate that always "
            f"says “no force” on every axis ({_list(zero)} N)."
        )


def _list(values: pd.Series) -> str:
    return ", ".join(f"{value:.2f}" for value in values)


def _data_quality(quality: pd.DataFrame) -> str:
    counts = quality["severity"].value_counts()
    parts = [f"{counts.get(name, 0)} {name}s" for name in ("error", "warning", "note")]
    return f"Findings about the recordings' files: {', '.join(parts)}."
