"""The figure of the first screen, and the recording with the largest relative force error."""

from collections.abc import Iterator

from ur5lib.report.results import Results
from ur5lib.report.views import contacts, currents, models


def first_figure(results: Results) -> dict[str, str]:
    """Return kind and recording of the first figure, {} if no figure over time is drawn."""
    return next(({"kind": kind, "recording": name} for kind, name in _figures(results)), {})


def worst_force(results: Results) -> list[str]:
    """Return the drawn recording with the largest relative error of the force, else []."""
    rows = results.rows("error_parts").sort_values("share", ascending=False)
    return results.shown([*rows["recording"]], 1)


def _figures(results: Results) -> Iterator[tuple[str, str]]:
    """Yield (kind of figure, recording), the most informative first.

    Forces with a sensor in contact; currents in motion, if possible without a load; torques in
    motion; forces without a sensor; currents of the fit.
    """
    for name in results.shown([*contacts.decided(results)["recording"]]):
        yield "forces", name
    carrying = {*results.loaded()}
    for name in sorted(currents.predicted(results), key=carrying.__contains__):
        if results.moving(name):
            yield "currents", name
    for name in models.compared(results):
        if results.moving(name):
            yield "torques", name
    for name in results.shown(
        [*contacts.touched(results), *results.tables["contacts"]["recording"]]
    ):
        yield "forces", name
    fitted = results.rows("current_rmse", model="fitted")["recording"]
    for name in results.shown(results.with_role("fit", fitted)):
        yield "currents", name
