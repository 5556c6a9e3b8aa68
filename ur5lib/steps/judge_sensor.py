"""The force sensor's wrench, and every estimate of the contact wrench beside it."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ur5lib.force.contact_figures import contact_errors, figures_by_contact
from ur5lib.force.detection import sensed_contact
from ur5lib.force.estimators import LEADING, UNGATED
from ur5lib.force.published import controller_estimate
from ur5lib.force.sensor import (
    measured_columns,
    mounting_doubt,
    move_to_frame_6,
    offset_doubt,
    opposite_axes,
    wrench_of_environment,
)
from ur5lib.records.force_errors import ByPeriod, Compared, Figures
from ur5lib.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.records.signals import Signals
from ur5lib.records.table import WRENCH
from ur5lib.robots.description import Robot
from ur5lib.steps.evidence import Evidence
from ur5lib.steps.sensor_reading import SensorReading, by_own_clock, moved_tool, sensor_reading
from ur5lib.timeseries.arrays import Array

Estimates = dict[str, tuple[Array, Array | None]]  # wrench and its standard deviation, (N, 6)


def compare_with_sensor(evidence: Evidence) -> tuple[SensorWrenches, Compared]:
    """Return the force sensor's wrench, and every estimate beside it; both empty without one."""
    signals, kinematics, forces = evidence.signals, evidence.kinematics, evidence.forces
    near = kinematics.smallest_singular_value < evidence.min_singular_value
    compared = Compared(
        force_sensor=signals.force_sensor is not None,
        share_near_singularity=float(near.mean()),
        std=band_widths(forces),
    )
    if signals.force_sensor is None:
        return SensorWrenches(time=signals.time, segment=signals.segment), compared
    robot = evidence.robot.with_force_sensor(*evidence.mounting)
    reading = read_sensor(evidence, robot)
    sensor = sensor_wrenches(robot, signals, reading, kinematics.rotation)
    estimates = compared_estimates(robot, signals, reading, published_forces(evidence), forces)
    if (torque := evidence.currents.external_torque) is not None and forces.wrench:
        known = torque, kinematics.jacobian, evidence.min_singular_value
        estimates["compensated"] = estimates["compensated"] | {UNGATED: (ungated(*known), None)}
    return sensor, beside_sensor(compared, reading, sensor, estimates, kinematics.rotation)


def published_forces(evidence: Evidence) -> PublishedForces:
    """Return the published estimates, in a study without published values the controller's alone;
    none where the recording contradicts the study.
    """
    if evidence.published is not None:
        return evidence.published
    signals = evidence.signals
    stopped = evidence.premises.contradictions.stop_signs or evidence.friction.stopped
    stated = {} if stopped else controller_estimate(evidence.arm, signals)
    return PublishedForces(
        time=signals.time, segment=signals.segment, printed=stated, corrected=stated
    )


def read_sensor(evidence: Evidence, robot: Robot) -> SensorReading:
    """Return the reading of the arm's own sensor, or of one with a clock of its own."""
    signals, window = evidence.signals, evidence.bias_window_s
    moved = moved_tool(robot, evidence.kinematics, evidence.motion)
    start = evidence.quality.starts.get("force")
    if start is None:
        whole = signals.ft_raw_wrench is not None  # else, the controller takes its tool off
        tool = evidence.premises.load.payload if whole else None
        return sensor_reading(robot, signals, moved, window, tool=tool)
    clock_std = evidence.alignment.clocks["force"].end_std
    return by_own_clock(robot, signals, moved, window, clock_std, evidence.force, start)


def sensor_wrenches(
    robot: Robot, signals: Signals, reading: SensorReading, rotation: Array
) -> SensorWrenches:
    """Return the sensor's wrench of the environment on the arm, by kind; rotation: (N, 3, 3)."""
    position = np.array(robot.mounting.force_sensor)

    def at_flange(free: Array) -> Array:
        return move_to_frame_6(wrench_of_environment(free, rotation), rotation, position)

    wrenches = {
        "printed": wrench_of_environment(reading.placed, rotation),
        "corrected": at_flange(reading.placed - reading.start_bias),
        "compensated": at_flange(reading.values - reading.untouched),
    }
    if not reading.own_clock:
        del wrenches["printed"]
    return SensorWrenches(time=signals.time, segment=signals.segment, wrench=wrenches)


def ungated(torque: Array, jacobian: Array, min_singular_value: float) -> Array:
    """Return the wrench (N, 6) [N, Nm] by least squares of the external torques (N, n) [Nm], in and
    out of contact: the simplest rival of an estimate that knows when nothing touches the arm.

    jacobian: (N, 6, n), of which directions with smaller singular values are left out.
    """
    left, size, right = np.linalg.svd(jacobian.mT, full_matrices=False)
    inverse = np.where(size > min_singular_value, 1 / size, 0.0)
    wrench: Array = np.matvec(right.mT, inverse * np.matvec(left.mT, torque))
    return wrench


def compared_estimates(
    robot: Robot,
    signals: Signals,
    reading: SensorReading,
    published: PublishedForces,
    forces: Forces,
) -> dict[str, Estimates]:
    """Return the estimates that each kind of reference is compared with.

    With a sensor in the arm's wrist, the controller's own force F^u is this sensor's reading; only
    its raw reading, or another sensor with a clock of its own, is compared with it.
    """
    other = signals.ft_raw_wrench is not None or reading.own_clock
    itself = set() if other or not robot.wrist_sensor else {"Fu"}
    found: dict[str, Estimates] = {}
    for kind, own in (("printed", published.printed), ("corrected", published.corrected)):
        found[kind] = {name: (wrench, None) for name, wrench in own.items() if name not in itself}
    found["corrected"] |= {name: (own, forces.std.get(name)) for name, own in forces.wrench.items()}
    return found | {"compensated": found["corrected"]}


def beside_sensor(
    found: Compared,
    reading: SensorReading,
    sensor: SensorWrenches,
    compared: Mapping[str, Estimates],
    rotation: Array,
) -> Compared:
    """Return a comparison with the offsets taken off the reading, doubts about them and the
    mounting, what the sensor felt, and the errors beside it.

    What is in contact and what is free follows from the sensor less bias and tool weight. Beside a
    sensor without moments, forces alone are compared. compared: of `compared_estimates`.
    """
    own, best = reading.offset, sensor.wrench["compensated"]
    force = np.linalg.norm(best[:, :3], axis=1)
    columns = measured_columns(best)
    opposite = list[str]()
    if LEADING in compared["compensated"]:
        estimated, _ = compared["compensated"][LEADING]
        opposite = opposite_axes(best[:, :3], estimated[:, :3], rotation)

    def errors(wrench: Array, std: Array | None, reference: Array) -> ByPeriod:
        band = None if std is None else std[:, columns]
        given = wrench[:, columns], band, reference[:, columns]
        return by_component(figures_by_contact(*given, force, sensor.period))

    return replace(
        found,
        offset=reading.account(),
        offset_doubt=offset_doubt(own, reading.each),
        mounting_doubt=mounting_doubt(own, opposite),
        felt=sensed_contact(force, sensor.time),
        errors={
            kind: {name: errors(*estimate, reference) for name, estimate in compared[kind].items()}
            for kind, reference in sensor.wrench.items()
        },
        contacts={
            name: [*contact_errors(wrench[:, :3], best[:, :3], sensor.time)]
            for name, (wrench, _) in compared["compensated"].items()
        },
    )


def by_component(figures: dict[str, dict[str, Array]]) -> ByPeriod:
    """Return figures, (6,) or of the force (3,), with the names of their components, by period."""
    return {
        during: {name: dict(zip(WRENCH, values, strict=False)) for name, values in part.items()}
        for during, part in figures.items()
    }


def band_widths(forces: Forces) -> Figures:
    """Return the median standard deviation of each estimate, by component."""
    return {
        name: dict(zip(WRENCH, np.nanmedian(std, axis=0).tolist(), strict=True))
        for name, std in forces.std.items()
    }
