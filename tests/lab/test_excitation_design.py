"""Designed trajectories: gradients, limits, optimality, what they promise, and bands after them."""

import functools
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Text

from benchmarks.excitation import (
    STATE_STEP,
    fit,
    keeps_limits,
    one_joint_after_the_other,
    random_motions,
    thinned,
    unseen_error,
    worth,
)
from tests.slow_noise import slow_noise
from ur5lab.collisions import Box, Surroundings
from ur5lab.excitation.design import (
    Design,
    Effort,
    design,
    feasible_path,
    free_postures,
    random_path,
)
from ur5lab.excitation.figure import excitation_figure
from ur5lab.excitation.objective import QUESTIONS, Objective, Task
from ur5lab.excitation.trajectory import Path, WorkCell
from ur5lab.excite import ExciteOptions, earlier, task_of
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.excitation.outlook import Bands, Earlier, Outlook
from ur5lib.excitation.problem import (
    CORRELATION_TIME,
    INDEPENDENT_STEP,
    LOAD_WIDTH,
    PREDICTED_ACCELERATION,
    PREDICTED_SPEED,
    TORQUE_NOISE,
    nominal_maps,
    random_states,
)
from ur5lib.identification.current_regression import expected_fit
from ur5lib.identification.current_samples import prior_of
from ur5lib.identification.currents import SEASON, friction_std, parameters
from ur5lib.report.figures.house_style import REPORT_FONT_SIZE
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

TABLE = -0.05  # m
SHORT = Effort(1, 0, ((1e2, 30), (1e4, 20)))
RANDOM, CELLS, SEEDS = 10, 6, 1000


@functools.cache
def task(robot: str = "ur5e", question: str = "model", seconds: float = 10.0) -> Task:
    options = ExciteOptions(robot, seconds, question, None, TABLE, None, 0)
    return task_of(options, *earlier(options))


@functools.cache
def designed() -> Design:
    return design(task(), 0, SHORT)


def test_letters_of_the_figure_can_be_read_in_print() -> None:
    figure = excitation_figure(designed()).figure
    texts = figure.findobj(Text)
    assert min(text.get_fontsize() for text in texts) >= REPORT_FONT_SIZE


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_gradient_is_that_of_finite_differences(question: str) -> None:
    """Of criterion and penalty, where limits are broken: the path is wide enough to break all."""
    own = task("ur5", question, 6.0)
    limits = replace(own.cell.limits, singular_value=0.2)
    check_gradient(replace(own, cell=replace(own.cell, limits=limits)), 1.4)


def check_gradient(own: Task, factor: float) -> None:
    """At a random path, enlarged by a factor so that it breaks limits."""
    random, weight = np.random.default_rng(1), 100.0
    objective = Objective(own)
    path = random_path(own, random, free_postures(own.cell, random))
    x = objective.variables(path) * factor
    _, gradient = objective(x, weight)
    for _ in range(3):
        way, step = random.normal(size=len(x)), 1e-6
        ends = [objective(x + sign * step * way, weight)[0] for sign in (-1, 1)]
        assert gradient @ way == pytest.approx((ends[1] - ends[0]) / (2 * step), rel=1e-4, abs=1e-4)


def test_a_path_becomes_variables_and_back() -> None:
    objective = Objective(task())
    path = objective.path(np.random.default_rng(0).normal(size=6 + 6 * 9))
    again = objective.path(objective.variables(path))
    np.testing.assert_allclose(again.coefficients, path.coefficients, atol=1e-12)
    np.testing.assert_array_equal(again.posture, path.posture)


def test_the_trajectory_begins_and_ends_at_rest() -> None:
    states = designed().path.at(np.array([0.0, 10.0]))
    np.testing.assert_allclose(states.q, designed().path.posture + np.zeros((2, 6)), atol=1e-9)
    assert np.abs(states.qd).max() < 1e-9
    assert np.abs(states.qdd).max() < 1e-9


def test_all_limits_are_kept_at_1_khz() -> None:
    assert designed().margins.broken() == []
    margins = task().cell.margins(designed().path.sampled(1000)[1])
    assert margins.broken() == []
    assert max(share.max() for share in margins.used.values()) > 0.9  # and used


@pytest.mark.slow
@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in range(1, CELLS))]
)
def test_trajectories_of_random_cells_keep_all_limits(seed: int) -> None:
    try:
        kept = keeps_limits(seed)
    except InputError as error:
        kept = "room" in str(error)
    assert kept


@pytest.mark.slow
def test_the_search_tells_as_many_iterations_as_its_effort_has() -> None:
    effort, steps = Effort(2, 3, ((1e2, 4), (1e3, 2))), list[int]()
    design(task(seconds=5.0), 0, effort, steps.append)
    assert sum(steps) == effort.iterations() == 12


def test_the_same_seed_gives_the_same_trajectory() -> None:
    own, effort = task("ur5", "model", 6.0), Effort(2, 2, ((1e2, 3),))
    first, again, other = (design(own, seed, effort).path.coefficients for seed in (0, 0, 1))
    np.testing.assert_array_equal(again, first)
    assert not np.allclose(other, first)


def test_it_is_better_than_the_best_of_random_ones() -> None:
    log_det, condition, _ = worth(task(), task().regressor(designed().path))
    random = np.array([worth(task(), motion) for motion in random_motions(task(), RANDOM)])
    assert log_det > random[:, 0].max() + 20
    assert condition < random[:, 1].min()


@pytest.mark.slow
def test_unseen_motions_are_predicted_better_than_after_way_points() -> None:
    ours = unseen_error(task(), task().regressor(designed().path))
    assert (ours < 0.7 * unseen_error(task(), one_joint_after_the_other(task()))).all()


@pytest.mark.slow
def test_predicted_standard_errors_are_those_observed() -> None:
    """Of all parameters that the recording determines, in physical units.

    What is expected before the recording is off by as much as the prior says, at random.
    """
    problem, random = task().problem, np.random.default_rng(3)
    Y, qd = thinned(*task().regressor(designed().path))
    true = problem.measured(problem.theta, Y, qd)
    spread = np.linalg.cholesky(np.linalg.inv(problem.prior))

    def fitted_once() -> Array:
        expected = problem.theta + spread @ random.normal(size=len(spread))
        return physical(
            fit(replace(problem, theta=expected), Y, qd, true + random.normal(size=true.shape))
        )

    fitted = np.array([fitted_once() for _ in range(SEEDS)])
    information = problem.prior + problem.information(Y, qd, 2 * STATE_STEP)
    predicted = problem.standard_errors(information)
    determined = predicted < 0.1 * problem.standard_errors(problem.prior)
    # half of the central 68 %: single draws leave the range in which the problem is linear
    low, high = np.percentile(fitted, [15.9, 84.1], axis=0)
    ratio = ((high - low) / 2 / predicted)[determined]
    assert determined.sum() > 50
    assert np.abs(ratio - 1).max() < 0.2


def physical(theta: Array) -> Array:
    """Parameters θ with torque constants, offsets and friction in their own units."""
    values = theta.copy()
    maps = values[task().problem.of_currents].reshape(6, 5)
    maps[:, 1:] /= maps[:, :1]
    maps[:, 0] = 1 / maps[:, 0]
    values[task().problem.of_currents] = maps.ravel()
    return values


@pytest.mark.slow
def test_each_question_is_answered_best_by_its_own_design() -> None:
    """Of payload and friction, which ask for the most different motions."""
    tasks = [task("ur5e", question, 6.0) for question in ("payload", "friction")]
    paths = [design(one, 0, Effort(1, 0, ((1e3, 20),))).path for one in tasks]
    for asked, own, other in zip(tasks, paths, paths[::-1], strict=True):
        values = [asked.criterion(asked.information(path))[0] for path in (own, other)]
        assert values[0] > values[1]


# Where there is no room


def test_a_box_around_the_arm_leaves_no_room() -> None:
    cage = Surroundings(boxes=[Box(center=(0.0, 0.0, 0.5), size=(3.0, 3.0, 3.0))])
    cell = WorkCell.around(load_robot(robot_path("ur5e")), cage)
    with pytest.raises(InputError, match=r"no room to move: in 100% .* link_\d come within 0.03 m"):
        free_postures(cell, np.random.default_rng(0))


def test_a_posture_that_breaks_a_limit_is_told() -> None:
    folded = Path(np.zeros(6), np.full((24, 6), 1e-3), 10.0)
    with pytest.raises(
        InputError, match=r"no motion about the posture keeps the limits .*singular"
    ):
        feasible_path(task().cell, folded)


def test_nominal_noise_is_as_wrong_as_errors_that_last() -> None:
    """The offset of a joint at rest, the mean of errors that are independent every second.

    They are an autoregression whose sum of correlations is that; its mean is as uncertain as is
    predicted, where noise of the same size that is independent every 0.1 s would be a third.
    """
    count = 600  # samples of a minute
    inflated = nominal_maps(load_robot(robot_path("ur5e"))).noise.torque[0] / TORQUE_NOISE
    similar = (CORRELATION_TIME / INDEPENDENT_STEP - 1) / (CORRELATION_TIME / INDEPENDENT_STEP + 1)
    noise = slow_noise(0, (2000, count), similar)
    assert inflated / np.sqrt(count) == pytest.approx(noise.mean(axis=1).std(), rel=0.06)


# Bands that another recording leaves

SECONDS = 20.0
BANDS = ("force", "current", "mass")


def outlook(recordings: int) -> Outlook:
    """Of a UR5e that was fitted to as many recordings, which told what other arms have."""
    arm = load_robot(robot_path("ur5e"))
    fit = expected_fit(prior_of(arm, []))
    return Outlook(arm, Earlier(fit, parameters(fit), None, recordings, []))


@pytest.fixture(scope="module")
def of_five() -> list[Bands]:
    own = outlook(recordings=5)
    return own.ranked(own.candidates(SECONDS))


def test_no_recording_widens_a_band_and_the_best_comes_first(of_five: list[Bands]) -> None:
    now, *others = of_five
    assert now.after == "now"
    assert [row.force for row in others] == sorted(row.force for row in others)
    for row in others:
        assert all(getattr(row, name) < getattr(now, name) for name in BANDS)


def test_a_load_s_mass_is_weighed_by_each_current() -> None:
    """Σ (∂i/∂p)ᵀ ∂i/∂p over its variance, of one error a second in twenty, where θ is known."""
    own = outlook(recordings=5)
    arm, problem = load_robot(robot_path("ur5e")), own.problem
    q, qd, qdd = random_states(arm, PREDICTED_SPEED, PREDICTED_ACCELERATION)
    Y = LinkModel(arm, arm.fullest_model()).regressor(q, qd, qdd)
    loaded = replace(problem, theta=np.append(problem.theta, np.zeros(10)), has_payload=True)

    def currents(load: Array) -> Array:
        theta = np.append(problem.theta, load)
        return loaded.measured(theta, Y, qd)[:, problem.joints :] * problem.noise.current

    steps = 1e-6 * np.eye(10)
    slopes = np.stack([(currents(s) - currents(-s)) / 2e-6 for s in steps], axis=2)  # (N, n, 10)
    fit = expected_fit(prior_of(arm, []))
    within = np.array([joint.band_moving for joint in fit.joints]) / NORMAL95
    variance = within**2 + (friction_std(SEASON) * problem.friction_current(Y, qd)) ** 2
    rows = (slopes / np.sqrt(variance)[..., None]).reshape(-1, 10)
    told = np.diag(LOAD_WIDTH**-2.0) + rows.T @ rows * 20 / len(Y)
    known = own.bands(1e14 * np.eye(len(own.information)))
    assert known.mass == pytest.approx(NORMAL95 * np.sqrt(np.linalg.inv(told)[0, 0]), rel=1e-4)


def test_what_is_known_of_parameters_narrows_to_what_recordings_differ_in() -> None:
    own = outlook(recordings=5)
    told = np.eye(len(own.information))
    sure, surer = (own.bands(own.information + size * told) for size in (1e12, 1e14))
    assert sure.force == pytest.approx(surer.force, rel=1e-3)
    assert sure.force < own.bands(own.information).force
