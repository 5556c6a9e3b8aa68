"""The page of methods: the numbers that it states are those of the program."""

import re
from collections.abc import Iterator

import pytest

from benchmarks.harness.markdown import read_page
from benchmarks.harness.scaled_constants import CONSTANTS, told, value
from tests.conftest import PROJECT
from ur5lib.force import (
    contact_figures,
    contact_prior,
    contact_wrench,
    gate,
    grasp,
    missed_contacts,
    residual_model,
    sensed_contact,
    sensor,
    thresholds,
    while_shut,
    wrench_estimate,
)
from ur5lib.force.contact_prior import ContactPrior, typical_force
from ur5lib.identification import (
    base_parameters,
    current_regression,
    currents,
    joint_regression,
    payload,
    prior,
    regression,
    samples,
    selection,
)
from ur5lib.records import clocks, contact_place
from ur5lib.robots import friction
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.signals import clock, device_clock
from ur5lib.smoothing import noise
from ur5lib.timeseries import segments
from ur5lib.timeseries.arrays import Array

PRIOR = ContactPrior(15.0)
COUNTED = {10: "ten", 8: "eight", 5: "five", 4: "four", 3: "three", 2: "two"}


def percent(share: float) -> str:
    return f"{round(100 * share, 6):g} %"


def listed(values: Array | tuple[float, ...]) -> str:
    return ", ".join(f"{round(value, 6):g}" for value in values)


def statements() -> Iterator[str]:
    """What the page says, with the program's numbers."""
    # clocks
    yield f"low-passed at {device_clock.BAND_LIMIT:g} Hz"
    explained = percent(device_clock.MIN_EXPLAINED_SHARE)
    yield f"explain less than {explained} of the gyroscope's variance"
    yield f"jackknife over {COUNTED[device_clock.JACKKNIFE_BLOCKS]} blocks of time"
    yield f"widened by {1e3 * device_clock.LATENCY_STD:g} ms for latencies"
    yield f"by {1e3 * clock.CLOCK_WANDER:g} ms of wander over the recording"
    yield f"counts as 0 ± {1e6 * clocks.UNKNOWN_DRIFT_STD:g} ppm"
    # motion and the IMU
    yield f"in windows of {noise.NOISE_WINDOW:g} s"
    yield f"jackknife over blocks of {segments.BLOCK_DURATION:g} s. Without β"
    # identification
    yield f"if less than {percent(base_parameters.MAX_PRIOR_VARIANCE_SHARE)} of its variance"
    yield f"over {friction.PRESLIDING_DISTANCE:.0e} rad".replace("e-0", "e-")
    percents = map(percent, (selection.MIN_SHARE, selection.MIN_SHARE_AT_REST))
    yield "falls by {} (at rest {}) and by two standard errors".format(*percents)
    assert selection.MIN_DEVIATIONS == 2
    yield f"it is 0 ± {friction.TERMS['velocity_root'].expected(1.0):g} of the largest torque"
    yield f"load-dependent friction {friction.TERMS['load'].expected(1.0):g} Nm/Nm"
    for share, std in (prior.COULOMB_PRIOR, prior.VISCOUS_PRIOR):
        yield f"({100 * share:g} ± {100 * std:g}) % T"
    yield f"(0 ± {100 * prior.OFFSET_STD_SHARE:g}) % T"
    yield "{:g} ± {:g}".format(*prior.LOAD_PRIOR)
    share = friction.TERMS["periodic"].expected(1.0)
    yield f"once per turn, {percent(share)} of the motor's largest torque"
    yield f"with fewer than {COUNTED[samples.MIN_UNITS]} paths"
    yield f"over stretches of {samples.BLOCKS_PER_STRETCH * segments.BLOCK_DURATION:g} s"
    yield f"over blocks of {segments.BLOCK_DURATION:g} s alone"
    yield f"s₀ = −{-joint_regression.HELD_FRICTION_SHARE:g} c"
    yield f"σ₀ = {percent(prior.CURRENT_NOISE_SHARE)} of the largest torque"
    yield f"counts as n₀ = {regression.USUAL_NOISE_BLOCKS:g} blocks"
    yield f"σ² = {currents.SAME_DAY_STD:g}² + {currents.DAILY_STD:g}² d"
    yield f"{currents.SEASON:g} days where a date is unknown"
    yield f"less than {joint_regression.MIN_SAMPLES * samples.INDEPENDENT_STEP:g} s"
    moving, turning, standing, _ = current_regression.UNSEEN_ERRORS
    yield f"u = {moving:g} c in motion, {turning:g} c reversing and {standing:g} c at rest"
    yield f"with more than {COUNTED[current_regression.MAX_FOLDS]} paths"
    yield f"{percent(payload.GEAR_EFFICIENCY_STD)} of the mass for the gears"
    yield f"each {'third' if payload.RUN_PARTS == 3 else payload.RUN_PARTS} of the run"
    yield f"prior width {percent(payload.UNSCALED_TORQUE_ERROR)})"
    yield (
        f"loads (gears {percent(payload.GEAR_EFFICIENCY_STD)}, "
        f"joints {percent(payload.UNSCALED_TORQUE_ERROR)}, "
        f"uncertainty {percent(payload.SCALED_TORQUE_ERROR)})"
    )
    # residuals
    five, three, one = (f"{residual_model.few_paths(paths):.2g}" for paths in (5, 3, 1))
    joints = COUNTED[residual_model.JOINTS_OF_A_FORCE]
    yield f"Since {joints} joints decide a component of a force"
    yield f"{five} for five paths, {three} for three."
    yield f"multiply its bands by {one},"
    yield f"**One or two paths** count as {COUNTED[samples.MIN_PATHS]};"
    yield f"at rest are by {friction.USUAL_AT_REST:g} those without any recording"
    # contacts
    typical = contact_prior.TYPICAL_LOAD_SHARE
    yield f"A typical contact has {typical:g} of the weight of the rated payload"
    forces = [typical_force(load_robot(robot_path(name))) for name in ("ur3", "ur5", "ur10e")]
    yield "a UR3 {:.0f} N, a UR5 {:.0f} N, a UR10e {:.0f} N".format(*forces)
    for name, own in CONSTANTS.items():
        yield f"| {name} | {told(value(own))} | {own.of} | {own.chosen} |"
    known, unknown = 100 * contact_place.TOOL_RADIUS, 100 * contact_place.WRIST_RADIUS
    yield f"within {known:g} cm, which counts as {contact_place.TOOL_WEIGHT:g} samples"
    yield f"within {unknown:g} cm, which counts as one"
    assert contact_place.WRIST_WEIGHT == 1
    yield f"in motion {residual_model.RUBBING_SHARE:g} of the deviation that the fits show"
    yield f"takes {residual_model.USUAL_RUBBING:g} of the breakaway torque in motion"
    smoothing = wrench_estimate.REST_SMOOTHING_PERIODS
    yield f"a normal weight of {smoothing:g} periods of"
    yield f"of {wrench_estimate.FEW_PATHS_SMOOTHING_PERIODS:g} where few paths were fitted"
    yield f"{wrench_estimate.PRESS_AS_FORCE:g} of it is added to F"
    yield f"{wrench_estimate.PRESS_AS_DOUBT:g} of it to the band"
    yield f"{contact_wrench.PRIOR_SHARE:g} of the deviation that P leaves"
    rests = f"in rests of up to {while_shut.SHORT_REST:g} s the whole background"
    yield f"{rests}, from {while_shut.LONG_REST:g} s on the change alone"
    yield f"κ is {missed_contacts.MISSED_DEVIATIONS:g}."
    yield f"as contact (its torque is {gate.QUIET_SHARE:g} of the fast error)"
    yield f"the prior P is 0 ± {contact_wrench.STATIC_FORCE:g} typical forces"
    yield f"contain a lever of {100 * contact_wrench.UNRESOLVED_LEVER:g} cm"
    yield f"the prior standard deviation is {percent(PRIOR.friction_std)}"
    yield (
        "changes within half a second"
        if residual_model.SHORT_LAG == 0.5
        else f"changes within {residual_model.SHORT_LAG:g} s"
    )
    # loads, sensor, detection, figures
    yield f"A contact of at least {grasp.MIN_GRASP_DURATION:g} s counts as a load"
    yield f"a weight explains {percent(grasp.MIN_SHARE_EXPLAINED_BY_LOAD)} of its squared torque"
    yield f"within {COUNTED[int(sensor.CONTACT_DEVIATIONS)]} standard deviations"
    yield f"below −{-sensor.OPPOSITE_CORRELATION:g} along an axis"
    yield f"carries {percent(sensor.MIN_AXIS_POWER_SHARE)} of the squared force"
    yield f"where they fall by {thresholds.ALARM_HYSTERESIS:g} more"
    touched, in_contact = sensed_contact.TOUCH_FORCE, sensed_contact.CONTACT_FORCE
    yield f"a contact reaches {touched:g}, {in_contact:g}, 10 or 15 N"
    yield f"while the reading exceeds {sensed_contact.RELEASE_FORCE:g} N"
    yield f"above {in_contact:g} N at the compensated sensor"
    yield (
        f"below {sensed_contact.FREE_FORCE:g} N and {sensed_contact.CONTACT_CLEARANCE:g} s away "
        f"from any sample of {touched:g} N"
    )
    yield f"from {contact_figures.CONTACT_RESAMPLES} resamples of whole contacts"


STATEMENTS = [*statements()]


@pytest.mark.parametrize("statement", STATEMENTS, ids=map(str, range(len(STATEMENTS))))
def test_the_page_states_the_numbers_of_the_program(statement: str) -> None:
    page = re.sub(r"\s+", " ", read_page(PROJECT / "docs" / "methods.md"))
    assert statement in page


def test_no_paragraph_is_long() -> None:
    """At most 120 words; tables and equations are none."""
    page = (PROJECT / "docs" / "methods.md").read_text()
    paragraphs = re.split(r"\n\n|\n- ", page)
    long = [own for own in paragraphs if len(own.split()) > 120 and own[0] not in "| "]
    assert long == []


def test_each_source_is_in_the_bibliography() -> None:
    """By its DOI, which the text links."""
    page = (PROJECT / "docs" / "methods.md").read_text()
    bibliography = (PROJECT / "paper" / "references.bib").read_text()
    cited = re.findall(r"https://doi\.org/(\S+?)\)(?=[\s;,.)])", page)
    assert len(cited) > 20
    assert [doi for doi in cited if f"doi = {{{doi}}}" not in bibliography] == []
