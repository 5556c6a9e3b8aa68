"""The first screen: verdicts, and one figure."""

from collections.abc import Callable, Iterator

from ur5lib.report.document import Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts import force, models, recordings
from ur5lib.report.views.contacts import touched
from ur5lib.report.views.currents import loaded, predicted
from ur5lib.report.views.models import compared

VERDICTS: list[Callable[[Results], Verdict | None]] = [
    recordings.judge_files,
    models.judge_links,
    models.judge_constants,
    models.judge_currents,
    force.judge_force,
    models.judge_motion,
    recordings.judge_drift,
]


def verdicts(results: Results) -> list[Verdict]:
    """Return the verdicts, in the order of the pipeline."""
    return [verdict for judge in VERDICTS if (verdict := judge(results))]


def force_drawn(results: Results) -> list[str]:
    """Return the recording of the first figure, if that shows forces."""
    return _drawn(results, "forces")


def current_drawn(results: Results) -> list[str]:
    """Return the recording of the first figure, if that shows currents."""
    return _drawn(results, "currents")


def torque_drawn(results: Results) -> list[str]:
    """Return the recording of the first figure, if that shows torques."""
    return _drawn(results, "torques")


def _drawn(results: Results, wanted: str) -> list[str]:
    """Return the recording of the first figure, if that is the wanted one."""
    kind, name = next(_figures(results), ("", ""))
    return [name] if kind == wanted else []


def _figures(results: Results) -> Iterator[tuple[str, str]]:
    """Yield figures and their recordings, the most informative first.

    Forces beside a sensor in contact; currents in motion, if possible without a load; torques in
    motion; forces without a sensor.
    """
    for name in results.shown([*force.errors_in_contact(results)["recording"]]):
        yield "forces", name
    carrying = {*loaded(results)["recording"]}
    for name in sorted(predicted(results), key=carrying.__contains__):
        if results.moving(name):
            yield "currents", name
    for name in compared(results):
        if results.moving(name):
            yield "torques", name
    for name in results.shown([*touched(results), *results.tables["contacts"]["recording"]]):
        yield "forces", name
