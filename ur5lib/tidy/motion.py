"""Rows of tables about the closed loop."""

from collections.abc import Iterator

from ur5lib.records.closed_loop import ClosedLoop
from ur5lib.records.gains import GainSummary
from ur5lib.records.signals import Signals
from ur5lib.thesis.reference import Published
from ur5lib.tidy import Row, by_joint
from ur5lib.timeseries.metrics import largest_error, mean_absolute_error


def closed_loop_mae(
    closed_loop: ClosedLoop, signals: Signals, published: Published
) -> Iterator[Row]:
    """Yield errors of positions and velocities in closed loop under each set of gains, and of the
    targets themselves; interpolated frames are left out.
    """
    if not closed_loop.qd:
        return
    received = ~signals.interpolated
    tables = {"q": published.values("closed_loop_q"), "qd": published.values("closed_loop_qd")}
    for quantity, printed in tables.items():
        actual = getattr(signals, f"actual_{quantity}")[received]
        target = {"target": getattr(signals, f"target_{quantity}")}
        for model, states in (getattr(closed_loop, quantity) | target).items():
            columns = {
                "mae": mean_absolute_error(states[received], actual),
                "max": largest_error(states[received], actual),
            } | ({"printed": printed[model]} if model in printed else {})
            yield from by_joint(columns, model=model, quantity=quantity)


def gains(gains: GainSummary) -> Iterator[Row]:
    """Yield the gains of the closed loop: a value only if the recording determines it.

    low and high: of the range that fits equally well, empty where it reaches a search bound.
    """
    for joint, found in enumerate(gains.joints, start=1):
        for name, gain, unit in (
            ("position", found.position, "1/s2"),
            ("velocity", found.velocity, "1/s"),
        ):
            bounds = gain.grid[0], gain.grid[-1]
            known = {"value": gain.best, "std_error": gain.std_error} if gain.determined else {}
            yield known | {
                "joint": joint,
                "gain": name,
                "unit": unit,
                "determined": gain.determined,
                "low": None if gain.low in bounds else gain.low,
                "high": None if gain.high in bounds else gain.high,
            }


def published_gains(gains: GainSummary) -> Iterator[Row]:
    """Yield whether published gains fit as well as the best ones, of joints whose target moves."""
    for model, costs in gains.published.items():
        for joint, (cost, found) in enumerate(zip(costs, gains.joints, strict=True), start=1):
            if found.excited:
                yield {
                    "model": model,
                    "joint": joint,
                    "cost": cost,
                    "least_cost": found.cost,
                    "limit": found.limit,
                    "fits": bool(cost <= found.limit),
                }
