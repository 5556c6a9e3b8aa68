"""All that a recording shows against what the study declares of it, for `ur5 check` and a run."""

from collections.abc import Iterator, Mapping

from ur5lib.checks.channels import (
    fast_between_samples,
    no_motion,
    too_short,
    unfiltered,
    unmoved,
)
from ur5lib.checks.checked import MIN_BLOCKS, Checked
from ur5lib.checks.contacts import unfelt_contacts
from ur5lib.checks.delays import as_warning, delayed_currents, delayed_joint
from ur5lib.checks.doubts import doubts_by_joint
from ur5lib.checks.load_changes import changed_loads
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.checks.torques import given_load
from ur5lib.checks.unchecked import unchecked
from ur5lib.records.accepted import accepting
from ur5lib.records.quality import Contradictions, Finding
from ur5lib.tables import channel


def contradictions(
    checked: Checked,
    doubts: list[Finding],
    sensed: bool,
    cutoffs_hz: Mapping[str, float],
    accepted: Mapping[str, str],
    only_stops: bool = False,
) -> Contradictions:
    """Return the stop signs of a recording, and its doubts: those given, then further ones.

    sensed: whether it has a force sensor; cutoffs_hz: of all low-pass filters; accepted: why the
    study overrules stop signs, by kind; only_stops: leave out further doubts.
    """
    doubts = [*doubts, *_of_samples(checked, cutoffs_hz), *checked.odd_targets.values()]
    signs = stop_signs(checked, accepted)
    stops = [one for one in signs if one.severity == "stop"]
    doubts += [one for one in signs if one not in stops]
    if not stops and not only_stops:  # from a stop sign, others would follow
        doubts += possible_delays(checked)
        doubts += given_load(checked)
        doubts += load_without_targets(checked)
        doubts += scaled_current(checked)
        doubts += contacts_felt(checked, sensed)
        if not checked.fitted and checked.shows_currents():
            doubts += changed_loads(checked.means, checked.loaded, fitted=False)
        doubts += unchecked(checked)
    return accepting(Contradictions(stops, doubts), accepted)


def possible_delays(checked: Checked) -> list[Finding]:
    """Return the warnings of a delay of all efforts, or of one joint's, that is not certain:
    friction may explain it as well, or it was found in torques of sensors that feel no friction.
    """
    name, delays = checked.arm.measured.channel, checked.delays or checked.sensed_delays
    if delays is None or len(checked.means.q) < MIN_BLOCKS:
        return []
    rubs = checked.driven and checked.delays is not None
    found = [*delayed_currents(delays, rubs, name)]
    if not found:
        found += delayed_joint(delays, rubs, name, checked.robot)
    return [as_warning(one) for one in found]


def load_without_targets(checked: Checked) -> list[Finding]:
    """Return the warning of a load that the currents of a `fit` recording show without targets. Of
    other recordings, a run estimates the load.
    """
    if not checked.fitted or checked.motion is None or not checked.driven:
        return []
    return [*checked.motion.undeclared_load()]


def scaled_current(checked: Checked) -> list[Finding]:
    """Return the warning of a joint with a current that is too small compared with the others'."""
    if checked.motion is None or not checked.driven or checked.contact is not None:
        return []
    return [*checked.motion.scaled_current()]


def _of_samples(checked: Checked, cutoffs_hz: Mapping[str, float]) -> Iterator[Finding]:
    """Yield what a recording of this length and rate, or with joints at rest, cannot show."""
    segment, step, cutoff = checked.robot["segment"].to_numpy(), checked.step, checked.cutoff
    positions = channel(checked.robot, "actual_q")
    yield from unfiltered(cutoffs_hz, step)
    yield from too_short(segment, step, cutoff)
    yield from fast_between_samples(positions, segment, step, checked.arm.velocity_limits())
    if checked.means.has_efforts():
        yield from (no_motion if checked.fitted else unmoved)(positions)


def contacts_felt(checked: Checked, sensed: bool) -> Iterator[Finding]:
    """Yield the warning of a contact that the currents of a `fit` recording show, else the note of
    how large one must be to be noticed.

    sensed: whether there is a force sensor, which notices weaker ones, so that the note is left
    out.
    """
    if not checked.fitted or not checked.means.has_efforts():
        return
    contact = checked.contact
    if contact is not None:
        yield contact.finding(contact.joint in doubts_by_joint(checked.doubted_links))
    elif not sensed and checked.arm.tells_gravity():
        yield unfelt_contacts(checked.arm)
