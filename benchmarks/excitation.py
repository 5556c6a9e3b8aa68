"""What designed trajectories are worth, beside random ones and one of way-points.

For each arm: time, log det and condition numbers of a designed trajectory, of the best of many
random ones that keep the same limits, and of way-points that move one joint after the other, as
the thesis's `_No6` does. Then the errors on unseen motions after a fit to each, in memory: the
problem's own equations with their noise. `--cells` designs in random cells instead, and counts the
trajectories that keep all limits at 1 kHz.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.harness.options import options_of
from benchmarks.harness.timing import timed
from ur5lab.collisions import Box, Surroundings
from ur5lab.excitation.design import CHECK_RATE, Effort, design, free_postures, random_path
from ur5lab.excitation.objective import STATE_STEP, Task, Worth
from ur5lab.excitation.trajectory import WorkCell
from ur5lab.excite import ExciteOptions, earlier, task_of
from ur5lib.errors import InputError
from ur5lib.excitation.problem import INDEPENDENT_STEP, DesignProblem
from ur5lib.robots.description import load_robot, robot_names, robot_path
from ur5lib.stand.plan import POSTURE, Movej
from ur5lib.stand.trajectories import INITIAL_REST, plan_targets
from ur5lib.timeseries.arrays import Array

ROBOTS = ("ur5", "ur5e")
SECONDS, RANDOM = 20.0, 1000
USUAL, QUICK, OF_CELLS = Effort(), Effort(1, 3, ((1e3, 5),)), Effort(1, 3, ((1e3, 6),))
TURN = 0.8  # rad; motion of each joint from the posture, one after the other
MISJUDGED = 0.2  # standard deviation of truth - nominal, in those of the prior
UNSEEN, FITS = 5, 20  # motions, and draws of truth and noise
ROUNDS = 6  # of Gauss and Newton's
CELL_SECONDS = 5.0


States = tuple[Array, Array]  # of a recording every STATE_STEP: Y (N, n, 11 n), q̇ (N, n)


def main() -> None:
    """Print the table of each arm, or the count of cells."""
    options = options_of(__doc__)
    options.add_argument("--random", type=int, default=RANDOM, help="random trajectories")
    options.add_argument("--cells", type=int, default=0, help="random cells to design in")
    given = options.parse_args()
    if given.cells:
        return print_cells(given.cells)
    effort, count = (QUICK, 3) if given.quick else (USUAL, given.random)
    for robot in ROBOTS[-1:] if given.quick else ROBOTS:
        compared(robot, usual_task(robot, SECONDS), effort, count)


def usual_task(robot: str, seconds: float) -> Task:
    """Return the task to identify an arm's model by a motion of some seconds."""
    options = ExciteOptions(robot, seconds, "model", None, None, None, 0)
    return task_of(options, *earlier(options))


def compared(robot: str, task: Task, effort: Effort, count: int) -> None:
    """Print the information of each trajectory, and the errors after a fit to it."""
    took, found = timed(lambda: design(task, 0, effort))
    ours = task.regressor(found.path)
    rivals = random_motions(task, count)
    motions = {"designed": ours, "way-points": one_joint_after_the_other(task)}
    print(f"\n{robot}, {SECONDS:g} s, designed in {took:.0f} s")
    print(f"{'':>24}{'log det':>9}{'cond. W':>9}{'cond. J':>10}")
    rows = {name: worth(task, motion) for name, motion in motions.items()}
    best = np.array([worth(task, motion) for motion in rivals])
    rows[f"best of {count} random"] = np.append(best[:, 0].max(), best[:, 1:].min(axis=0))
    for name, (log_det, of_regressor, of_all) in rows.items():
        print(f"{name:>24}{log_det:>9.1f}{of_regressor:>9.3g}{of_all:>10.3g}")
    print("error on unseen motions after a fit: torque [Nm], current [share of its noise]")
    errors = {name: unseen_error(task, motion) for name, motion in motions.items()}
    for name, (torque, current) in errors.items():
        print(f"{name:>24}{torque:>9.4f}{current:>9.4f}")
    lower = 1 - errors["designed"] / errors["way-points"]
    print(f"designed: {lower[0]:.0%} lower in torque, {lower[1]:.0%} in current than way-points")


def random_motions(task: Task, count: int) -> Iterator[States]:
    """Yield random motions that keep the limits, each joint as fast as it may be."""
    random = np.random.default_rng(1)
    postures = free_postures(task.cell, random)
    for _ in range(count):
        yield task.regressor(random_path(task, random, postures))


def one_joint_after_the_other(task: Task) -> States:
    """Return the states of a motion that moves each joint in turn and back, over and over."""
    turned = [np.add(POSTURE, TURN * axis) for axis in np.eye(6)]
    turns = [point for own in turned for point in (POSTURE, own)]
    plan = Movej(kind="movej", way_points=[tuple(map(float, point)) for point in turns])
    targets = plan_targets(plan, task.cell.robot, INITIAL_REST + np.arange(0, SECONDS, STATE_STEP))
    return task.cell.model.regressor(targets.q, targets.qd, targets.qdd), targets.qd


def worth(task: Task, motion: States) -> Array:
    """Return log det M, and the condition numbers of the regressor and of the whole problem."""
    found = Worth.of_states(task, *motion)
    return np.array([found.log_det, found.regressor_condition, found.condition])


def unseen_error(task: Task, motion: States) -> Array:
    """Return RMS errors (2,) of torque [Nm] and current [noise] on motions that no fit has seen."""
    problem, random = task.problem, np.random.default_rng(2)
    spread = MISJUDGED * np.linalg.cholesky(np.linalg.inv(problem.prior))
    unseen = [*random_motions(task, UNSEEN)]
    squares = []
    for _ in range(FITS):
        truth = problem.theta + spread @ random.normal(size=len(problem.theta))
        Y, qd = thinned(*motion)
        measured = problem.measured(truth, Y, qd) + random.normal(size=(len(Y), 12))
        fitted = fit(problem, Y, qd, measured)
        for states in unseen:
            error = problem.measured(fitted, *states) - problem.measured(truth, *states)
            torque = error[:, :6] * problem.noise.torque
            squares.append([np.mean(torque**2), np.mean(error[:, 6:] ** 2)])
    return np.sqrt(np.mean(squares, axis=0))


def thinned(Y: Array, qd: Array) -> tuple[Array, Array]:
    """Return samples so far apart that their errors are independent."""
    every = round(INDEPENDENT_STEP / STATE_STEP)
    return Y[::every], qd[::every]


def fit(problem: DesignProblem, Y: Array, qd: Array, measured: Array) -> Array:
    """Return the parameters (P,) by Gauss-Newton from measurements (N, 12) and the prior."""
    theta = problem.theta
    for _ in range(ROUNDS):
        J = problem.rows(theta, Y, qd).reshape(-1, len(theta))
        residual = (measured - problem.measured(theta, Y, qd)).ravel()
        right = J.T @ residual + problem.prior @ (problem.theta - theta)
        theta = theta + np.linalg.solve(J.T @ J + problem.prior, right)
    return theta


def print_cells(count: int) -> None:
    """Print the number of random cells' trajectories that keep all limits at 1 kHz, and why others
    fail.
    """
    kept, refused, broken = 0, 0, 0
    for seed in range(count):
        try:
            kept_all = keeps_limits(seed)
        except InputError as error:
            refused += 1
            print(f"cell {seed}: {error}")
        else:
            kept, broken = kept + kept_all, broken + (not kept_all)
    print(
        f"{count} cells: {kept} keep all limits at 1 kHz, {refused} leave no room, {broken} break"
    )


def keeps_limits(seed: int) -> bool:
    """Return whether the trajectory of a random cell keeps all limits at 1 kHz."""
    task = random_task(np.random.default_rng(seed))
    path = design(task, seed, OF_CELLS).path
    return not task.cell.margins(path.sampled(CHECK_RATE)[1]).broken()


def random_task(random: np.random.Generator) -> Task:
    """Return the task of a random arm among random obstacles, with random shares of its limits."""
    robot = str(random.choice(robot_names()))
    task = usual_task(robot, CELL_SECONDS)
    things = Surroundings(
        table=float(random.uniform(-0.3, 0.0)) if random.random() < 0.7 else None,
        boxes=[random_box(random) for _ in range(random.integers(4))],
    )
    cell = WorkCell.around(load_robot(robot_path(robot)), things)
    limits = replace(
        cell.limits,
        velocity=cell.limits.velocity * random.uniform(0.2, 1.5),
        acceleration=cell.limits.acceleration * random.uniform(0.1, 1.0),
        position=cell.limits.position * random.uniform(0.3, 1.0, 6),
        clearance=float(random.uniform(0.0, 0.06)),
    )
    return replace(task, cell=replace(cell, limits=limits))


def random_box(random: np.random.Generator) -> Box:
    """Return a box of up to a metre, beside or above the arm."""
    center, size = random.uniform(-1.2, 1.2, 3), random.uniform(0.05, 1.0, 3)
    return Box(center=tuple(map(float, center)), size=tuple(map(float, size)))


if __name__ == "__main__":
    main()
