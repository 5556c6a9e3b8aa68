"""The page's tables of what few recordings tell, from tables that `learning_curve` writes."""

from collections.abc import Iterator

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from ur5lib.leaderboard.tables import markdown, number
from ur5lib.timeseries.arrays import Array

OURS, ALONE, LEAST_SQUARES = MODELS = ("ours", "without typical friction", "least squares")
DRAWS, SEED = 1000, 0
AIM = 0.90, 0.99  # of the share inside a 95 % band
MOST_DRAWN = 5.0  # relative error, above which a figure shows none


def learning_table(table: pd.DataFrame) -> str:
    """Return a row for each arm and number of recordings: errors relative to ours of all, ours less
    that without typical friction, and shares inside the bands.
    """
    rows = []
    for arm, own in table.groupby("arm", sort=False):
        whole = rmse(own[(own["fitted"] == "all") & (own["model"] == OURS)])
        for size, part in own.groupby("fitted", sort=False):
            by_model = {name: part[part["model"] == name] for name in MODELS}
            errors = [relative(each, whole) for each in by_model.values()]
            shares = [share_and_worst(by_model[name]) for name in (OURS, ALONE)]
            difference = interval(by_model, whole) if len(by_model[ALONE]) else ""
            rows.append([str(arm), str(size), *errors, difference, *shares])
    heads = [
        *MODELS,
        "ours less without typical friction",
        "inside our band",
        "inside band without",
    ]
    return markdown(["arm", "recordings", *heads], rows)


def relative(table: pd.DataFrame, whole: pd.Series) -> str:
    """Return the mean over joints of the RMSE relative to a whole one; least squares on a joint
    that hardly moves has no bound.
    """
    ratio = (rmse(table) / whole).mean() if len(table) else np.nan
    return "more than 100" if ratio > 100 else number(ratio, 2)


def rmse(table: pd.DataFrame) -> pd.Series:
    """Return the RMSE [A] of each joint."""
    sums = table.groupby("joint")[["square", "samples"]].sum()
    return np.sqrt(sums["square"] / sums["samples"])


def share_and_worst(table: pd.DataFrame) -> str:
    """Return the share of samples inside the band, and that of the worst joint."""
    if table["banded"].sum() == 0:
        return ""
    sums = table.groupby("joint")[["inside", "banded"]].sum()
    share = sums["inside"].sum() / sums["banded"].sum()
    return f"{share:.2f}, joint {(sums['inside'] / sums['banded']).min():.2f}"


def interval(by_model: dict[str, pd.DataFrame], whole: pd.Series) -> str:
    """Return ours less that without it, with the 95 % interval over drawn recordings."""
    sums = {
        name: by_model[name].pivot_table(
            ["square", "samples"], index="recording", columns="joint", aggfunc="sum"
        )
        for name in (OURS, ALONE)
    }
    names = sums[OURS].index
    drawn = np.random.default_rng(SEED).integers(len(names), size=(DRAWS, len(names)))

    def errors(name: str) -> Array:
        square, samples = (sums[name][key].loc[names].to_numpy() for key in ("square", "samples"))
        places = np.vstack([np.arange(len(names)), drawn])
        roots = np.sqrt(np.nansum(square[places], axis=1) / np.nansum(samples[places], axis=1))
        return (roots / whole.to_numpy()).mean(axis=1)

    difference = errors(OURS) - errors(ALONE)
    low, high = np.quantile(difference[1:], [0.025, 0.975])
    return f"{difference[0]:+.2f} ({low:.2f} to {high:.2f})".replace("-", "−")


def learning_findings(table: pd.DataFrame) -> Iterator[str]:
    """Yield where our bands miss AIM, and where fewer recordings, or none, had a smaller error."""
    for arm, whole in table[table["model"] == OURS].groupby("arm", sort=False):
        shares = {size: share_inside(own) for size, own in whole.groupby("fitted", sort=False)}
        missed = {size: own for size, own in shares.items() if not AIM[0] <= own[0] <= AIM[1]}
        each = "; ".join(
            f"{size}: {share:.3f} ({low:.3f} to {high:.3f})"
            for size, (share, low, high) in missed.items()
        )
        yield f"{arm}: our band misses {AIM[0]:.2f} to {AIM[1]:.2f} with {each or 'no number'}."
        one, none = (rmse(whole[whole["fitted"] == size]) for size in ("1", "0"))
        if (one / none).mean() > 1:
            yield f"{arm}: one recording gives {(one / none).mean():.2f} times the error of none."


def share_inside(table: pd.DataFrame) -> tuple[float, float, float]:
    """Return the share of samples inside the band, with the 95 % interval over drawn recordings."""
    sums = table.groupby("recording")[["inside", "banded"]].sum().to_numpy()
    drawn = np.random.default_rng(SEED).integers(len(sums), size=(DRAWS, len(sums)))
    inside, banded = np.moveaxis(sums[drawn].sum(axis=1), -1, 0)
    low, high = np.quantile(inside / banded, [0.025, 0.975])
    return float(sums[:, 0].sum() / sums[:, 1].sum()), float(low), float(high)


def days_table(table: pd.DataFrame) -> str:
    """Return a row for each day left out: currents inside the band, by joint and in all, and torque
    constants that agree.
    """
    rows = []
    for arm, own in table.groupby("arm", sort=False):
        for day, part in [*own.groupby("day"), ("all", own)]:
            sums = part.groupby("joint")[["inside", "banded"]].sum()
            shares = [number(each, 2) for each in sums["inside"] / sums["banded"]]
            agree = part.drop_duplicates(["day", "joint"])["agrees"]
            whole = number(sums["inside"].sum() / sums["banded"].sum(), 3)
            rows.append([str(arm), str(day), *shares, whole, f"{agree.sum()} of {len(agree)}"])
    joints = [f"joint {joint}" for joint in range(1, 7)]
    return markdown(["arm", "day", *joints, "all joints", "torque constants agree"], rows)


def forces_table(table: pd.DataFrame) -> str:
    """Return a row for each arm and number of recordings: forces in contact, and false alarms."""
    return markdown(
        ["arm", "recordings", "recording in contact", "error", "inside band", "alarms a minute"],
        [row for (arm, size), own in table.groupby(["arm", "fitted"], sort=False)
         for row in force_rows(str(arm), str(size), own)],
    )  # fmt: skip


def force_rows(arm: str, size: str, table: pd.DataFrame) -> Iterator[list[str]]:
    """Yield the mean over subsets of each recording in contact, then all false alarms."""
    for name, own in table.dropna(subset="error").groupby("recording", sort=False):
        cells = number(own["error"].mean(), 2), number(own["inside"].mean(), 2)
        yield [arm, size, str(name), *cells, ""]
    minutes = table["minutes"].sum()
    rate = number(table["alarms"].sum() / minutes, 2) if minutes else ""
    yield [arm, size, "none", "", "", rate]


def learning_figure(table: pd.DataFrame) -> Figure:
    """Return error and coverage of each arm's predicted currents by the number of recordings."""
    arms = table["arm"].unique()
    figure, axes = plt.subplots(len(arms), 2, figsize=(8, 2.6 * len(arms)), squeeze=False)
    for (left, right), arm in zip(axes, arms, strict=True):
        own = table[table["arm"] == arm]
        sizes = [*own["fitted"].unique()]
        whole = rmse(own[(own["fitted"] == "all") & (own["model"] == OURS)])
        for model in MODELS:
            parts = {size: own[(own["fitted"] == size) & (own["model"] == model)] for size in sizes}
            known = {size: part for size, part in parts.items() if len(part)}
            errors = [(rmse(part) / whole).mean() for part in known.values()]
            left.plot([*map(sizes.index, known)], errors, marker="o", label=model)
            banded = {size: part for size, part in known.items() if part["banded"].sum()}
            shares = [part["inside"].sum() / part["banded"].sum() for part in banded.values()]
            if shares:
                right.plot([*map(sizes.index, banded)], shares, marker="o", label=model)
        left.set_ylim(0, MOST_DRAWN)
        right.axhspan(*AIM, color="0.9")
        left.set_ylabel(f"{arm}: relative error")
        right.set_ylabel("inside the 95 % band")
        for panel in (left, right):
            panel.set_xticks(range(len(sizes)), sizes)
            panel.set_xlabel("recordings")
    axes[0, 0].legend()
    figure.tight_layout()
    return figure
