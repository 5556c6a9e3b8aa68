"""What each recording serves, and what not, with the reason."""

from collections.abc import Iterator

from ur5lib.records.quality import UNUSUAL_FRICTION
from ur5lib.report.page.sentences import say
from ur5lib.report.results import AT_REST, Results
from ur5lib.report.views.contacts import doubted_biases, errors_in_contact
from ur5lib.report.views.currents import loaded
from ur5lib.report.views.forces import searched


def uses(results: Results) -> dict[str, str]:
    """Return a sentence for each recording: usable for what, for what not, and why."""
    served, refused = dict(_served(results)), [*_refused(results)]
    found = {}
    for name in results.roles():
        against = [(goal, why) for goal, why, names in refused if name in names]
        without = {goal for goal, _ in against}
        goals = [goal for goal in served if name in served[goal] and goal not in without]
        found[name] = say("recordings.use", goals=goals, against=against)
    return found


def _served(results: Results) -> Iterator[tuple[str, set[str]]]:
    """Yield what recordings serve, with their names."""
    errors, loads = results.rows("current_rmse", model="fitted"), {*loaded(results)["recording"]}
    moving = {name for name in results.roles() if results.moving(name)}
    yield "fit", {*errors.loc[errors["fitted"] == "yes", "recording"], *results.with_role(AT_REST)}
    tested = {*results.with_role("validate", errors["recording"])}
    yield "currents", (tested & moving) - loads
    yield "load", loads
    yield "links", {*results.tables["torque_mae"].dropna(subset="mae")["recording"]} & moving
    yield "force", {*errors_in_contact(results)["recording"]}
    yield "contacts", {*results.with_role("contact", searched(results)["recording"])}
    yield "motion", {*results.tables["acceleration_mae"]["recording"]}


def _refused(results: Results) -> Iterator[tuple[str, str, set[str]]]:
    """Yield what recordings do not serve, the reason, and their names."""
    stopped = {*results.rows("quality", severity="stop")["recording"]}
    yield "all", "stop", stopped
    yield "all", "unread", {*results.unusable()} - stopped
    yield "currents", "loaded", {*results.with_role("validate", loaded(results)["recording"])}
    unsensed = {*results.with_role("contact")} - {*results.tables["sensed"]["recording"]}
    yield "force", "no sensor", unsensed - stopped
    yield "force", "bias", {*doubted_biases(results, [*results.roles()])} - stopped
    yield "force", "friction", {*results.rows("quality", finding=UNUSUAL_FRICTION)["recording"]}
