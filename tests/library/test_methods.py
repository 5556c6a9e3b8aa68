"""The page of methods: the numbers that it states are those of the program."""

import re
from collections.abc import Iterator

import pytest

from tests.conftest import PROJECT
from ur5lib.force import (
    contact_figures,
    contact_wrench,
    detection,
    external_torque,
    force_input,
    gate,
    grasp,
    missed_contacts,
    residual_model,
    sensor,
    wrench_estimate,
)
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.identification import (
    base_parameters,
    current_regression,
    currents,
    joint_regression,
    payload,
    prior,
    regression,
    samples,
)
from ur5lib.robots import friction
from ur5lib.signals import clock, device_clock
from ur5lib.smoothing import noise
from ur5lib.steps import fit_residuals as residual_fit
from ur5lib.thesis import current_based as thesis
from ur5lib.thesis import gains
from ur5lib.timeseries import segments
from ur5lib.timeseries.arrays import Array

PRIOR = ContactPrior()
COUNTED = {10: "ten", 8: "eight", 5: "five", 4: "four", 3: "three", 2: "two"}


def percent(share: float) -> str:
    return f"{round(100 * share, 6):g} %"


def listed(values: Array | tuple[float, ...]) -> str:
    return ", ".join(f"{round(value, 6):g}" for value in values)


def statements() -> Iterator[str]:
    """What the page says, with the program's numbers."""
    # clocks
    yield f"low-passed at {device_clock.BAND:g} Hz"
    yield f"explain less than {percent(device_clock.EXPLAINED)} of the gyroscope's variance"
    yield f"jackknife over {COUNTED[device_clock.BLOCKS]} blocks of time"
    yield f"widened by {1e3 * device_clock.LATENCY:g} ms for latencies"
    yield f"by {1e3 * clock.WANDER:g} ms of wander over the recording"
    yield f"counts as 0 ± {1e6 * clock.UNKNOWN_DRIFT:g} ppm"
    # motion and the IMU
    yield f"in windows of {noise.WINDOW:g} s"
    yield f"jackknife over blocks of {segments.BLOCK:g} s. Without β"
    # identification
    yield f"within the {percent(gains.LEVEL)} point of F(2, n − 2)"
    yield f"narrower than a factor of {gains.KNOWN:g}."
    yield f"if less than {percent(base_parameters.LARGEST_SHARE)} of its variance"
    yield f"over {friction.PRESLIDING:.0e} rad".replace("e-0", "e-")
    yield f"load-dependent friction {friction.TERMS['load'].expected(1.0):g} Nm/Nm"
    for share, std in (prior.COULOMB, prior.VISCOUS):
        yield f"({100 * share:g} ± {100 * std:g}) % T"
    yield f"(0 ± {100 * prior.BIAS:g}) % T"
    yield "{:g} ± {:g}".format(*prior.LOAD)
    share = friction.TERMS["periodic"].expected(1.0)
    yield f"once per turn, {percent(share)} of the motor's largest torque"
    yield f"with fewer than {COUNTED[samples.FEW]} paths"
    yield f"over stretches of {samples.STRETCH * segments.BLOCK:g} s"
    yield f"over blocks of {segments.BLOCK:g} s alone"
    yield f"s₀ = −{-joint_regression.HELD:g} c"
    yield f"σ₀ = {percent(prior.NOISE)} of the largest torque"
    yield f"counts as n₀ = {regression.USUAL:g} blocks"
    yield f"{percent(currents.OTHER_DAYS)} of the predicted friction"
    yield f"less than {joint_regression.FEWEST * samples.STEP:g} s"
    yield (
        f"u = {current_regression.UNSEEN_MOVING:g} c in motion and "
        f"{current_regression.UNSEEN_RESTING:g} c at rest"
    )
    yield f"with more than {COUNTED[current_regression.FOLDS]} paths"
    yield f"{percent(payload.GEARS)} of the mass for the gears"
    yield f"each {'third' if payload.PARTS == 3 else payload.PARTS} of the run"
    yield f"prior width {percent(payload.JOINTS)})"
    yield (
        f"loads (gears {percent(payload.GEARS)}, joints {percent(payload.JOINTS)}, uncertainty "
        f"{percent(payload.LEFT)})"
    )
    # residuals
    five, three, one = (f"{residual_model.few_paths(paths):.2g}" for paths in (5, 3, 1))
    yield f"the number of paths: {five} for five, {three} for three."
    yield f"multiply its bands by {one},"
    yield f"**One or two paths** count as {COUNTED[samples.LEAST_PATHS]};"
    # contacts
    yield f"| typical contact | {PRIOR.force:g} N |"
    yield f"| its lever | {100 * PRIOR.lever:g} cm |"
    yield f"| magnitudes of the gate | {listed(PRIOR.sizes)} N |"
    yield f"| duration of contacts | {PRIOR.duration:g} s |"
    yield f"| of pauses | {PRIOR.pause:g} s |"
    yield f"| load friction besides the fit's | {percent(PRIOR.load_friction)} |"
    yield f"| friction of a run | {percent(PRIOR.friction_std)} |"
    yield f"(share of the breakaway torque) | {PRIOR.stiction:g} |"
    yield f"| in motion | {PRIOR.rubbing:g} |"
    yield f"| hunting (shares) | {listed(PRIOR.hunting)} |"
    yield f"| settling | {PRIOR.settling:g} s |"
    yield f"| mean of what stiction takes | 1/{1 / force_input.MEAN:g} |"
    yield f"| least deviation at rest | {gate.HELD:g} |"
    yield f"| weight of the typical lever | {contact_wrench.LEVERS:g} samples |"
    yield f"| weight of the typical contact | {contact_wrench.WEIGHT:g} |"
    yield f"| gate closes (opens at {wrench_estimate.OPENS:g}) | {wrench_estimate.CLOSES:g} |"
    yield f"| margin | {wrench_estimate.MARGIN:g} s |"
    yield f"| κ | {missed_contacts.MISSED_TO:g} |"
    yield f"| blur | {contact_wrench.BLUR:g} s |"
    yield f"the factor {residual_fit.PAST_ALONE:g} on errors of the past alone"
    yield f"κ is {missed_contacts.MISSED_TO:g}."
    yield f"a force that does not count as contact ({PRIOR.quiet:g} N)"
    yield (
        f"(a stop counts after {external_torque.STOP:g} s and relaxes for "
        f"{external_torque.RELAXING:g} s, friction of a stopped joint renews within "
        f"{external_torque.RELAXING:g} s)"
    )
    yield f"contain a lever of {100 * contact_wrench.UNTOLD:g} cm"
    yield f"counts as {contact_wrench.LEVERS:g} independent samples"
    yield f"the prior standard deviation is {percent(PRIOR.friction_std)}"
    yield (
        "changes within half a second"
        if residual_model.SHORT == 0.5
        else f"changes within {residual_model.SHORT:g} s"
    )
    # loads, sensor, detection, figures
    yield f"A contact of at least {grasp.SHORTEST:g} s counts as a load"
    yield f"a weight explains {percent(grasp.EXPLAINED)} of its squared torque"
    yield f"within {COUNTED[int(sensor.OUTSIDE)]} standard deviations"
    yield f"below −{-sensor.OPPOSITE:g} along an axis"
    yield f"carries {percent(sensor.SHARE)} of the squared force"
    yield f"where they fall by {detection.HYSTERESIS:g} more"
    yield f"a contact reaches {detection.TOUCH:g}, {detection.CONTACT:g}, 10 or 15 N"
    yield f"while the reading exceeds {detection.RELEASE:g} N"
    yield f"above {detection.CONTACT:g} N at the compensated sensor"
    yield (
        f"below {detection.FREE:g} N and {detection.CLEAR:g} s away from any sample "
        f"of {detection.TOUCH:g} N"
    )
    yield f"from {contact_figures.DRAWS} resamples of whole contacts"
    yield f"{1e3 * thesis.PUBLISHED_JACOBIAN_LAG:g} ms earlier, as in the published script"


STATEMENTS = [*statements()]


@pytest.mark.parametrize("statement", STATEMENTS, ids=map(str, range(len(STATEMENTS))))
def test_the_page_states_the_numbers_of_the_program(statement: str) -> None:
    page = re.sub(r"\s+", " ", (PROJECT / "docs" / "methods.md").read_text())
    assert statement in page


def test_no_paragraph_is_long() -> None:
    """At most 120 words; tables and equations are none."""
    page = (PROJECT / "docs" / "methods.md").read_text()
    paragraphs = re.split(r"\n\n|\n- ", page)
    long = [own for own in paragraphs if len(own.split()) > 120 and own[0] not in "| "]
    assert long == []
