"""Errors of positions and velocities in closed loop, and of the targets themselves."""

from collections.abc import Iterator

from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import ClosedLoop
from ur5lib.report.reference import Printed, published
from ur5lib.report.study_results import Row, StudyResults
from ur5lib.timeseries.metrics import largest_error, mean_absolute_error

COLUMNS = ["recording", "model", "joint", "quantity", "mae", "max", "printed"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    loops = results.paths_of("closed_loop")
    for name, signals in results.paths_of("signals").items():
        states = Signals.read(signals), ClosedLoop.read(loops[name])
        yield from closed_loop_errors(name, *states, results.printed)


def closed_loop_errors(
    recording: str, signals: Signals, closed_loop: ClosedLoop, printed: Printed
) -> Iterator[Row]:
    """Yield the errors under each set of gains; interpolated frames are left out."""
    if not closed_loop.qd:
        return
    received = ~signals.interpolated
    for quantity, table in (("q", printed.closed_loop_q), ("qd", printed.closed_loop_qd)):
        values = published(table, recording)
        reference = getattr(signals, f"actual_{quantity}")[received]
        target = {"target": getattr(signals, f"target_{quantity}")}
        for model, states in (getattr(closed_loop, quantity) | target).items():
            mae = mean_absolute_error(states[received], reference)
            largest = largest_error(states[received], reference)
            for joint in range(6):
                yield {
                    "recording": recording,
                    "model": model,
                    "joint": joint + 1,
                    "quantity": quantity,
                    "mae": mae[joint],
                    "max": largest[joint],
                    "printed": values[model][joint] if model in values else None,
                }
