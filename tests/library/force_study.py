"""Real recordings as the force estimates need them: external torque, Jacobian, sensor.

As the workflow has them, but for a plainer smoothing of the motion.
"""

from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path

import numpy as np
import torch
import yaml
from ur5lib.pipeline.left_over import left_over

from tests.conftest import PROJECT
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import States, joint_states
from ur5lib.force.residual_model import ResidualModel, Stretch, few_paths, fit_residual_model
from ur5lib.force.sensor import SensorOffset, fit_offset, move_to_frame_6, wrench_of_environment
from ur5lib.force.template import ForceInput, repeat_aware
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench
from ur5lib.identification.currents import (
    CurrentFit,
    breakaway_torque,
    fit_currents,
    fit_without_each_path,
    predict,
    torque_constants,
)
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record, record_paths
from ur5lib.identification.torque_constants import standstill_ratio, torque_constant_prior
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import Robot
from ur5lib.signals.clocks import Clock
from ur5lib.signals.host_drifts import read_clock
from ur5lib.signals.resampling import resample
from ur5lib.study.check import look_through, settled
from ur5lib.study.model import Recording, Study
from ur5lib.study.reading import parse_study
from ur5lib.tables import channel, period
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment, unbroken

CUTOFF = 2.0  # Hz, of currents and external torques
SENSOR = ["ft_fx", "ft_fy", "ft_fz", "ft_tx", "ft_ty", "ft_tz"]
PRIOR = ContactPrior()


def smooth(values: Array, record: Record) -> Array:
    lowpass = partial(zero_phase_lowpass, rate=1 / record.period, order=4, cutoff=CUTOFF)
    return by_segment(lowpass, values, record.segment)


def thesis_study(folder: Path) -> Study:
    """The thesis's study, with what each recording carries, read from a folder."""
    path = PROJECT / "workflow" / "studies" / "thesis.yaml"
    raw = yaml.safe_load(path.read_text()) | {"reference": None}
    for recording in raw["recordings"]:
        recording["folder"] = str(folder / recording["name"])
    return parse_study({k: v for k, v in raw.items() if v is not None}, str(path))


def sensor_clocks(study: Study) -> dict[str, Clock]:
    """How each force sensor's clock runs, as the workflow has it: by stamps and by its host."""
    looked = {recording.name: look_through(recording, study) for recording in study.recordings}
    found = settled(study, *({name: own[k] for name, own in looked.items()} for k in (0, 1)))
    return {name: read_clock(own["force"]) for name, own in found.items() if "force" in own}


@dataclass(frozen=True)
class Taken:
    """A recording: its motion and currents, Jacobian, R_6, sensor and controller's estimate."""

    record: Record
    ratio: Array
    jacobian: Array
    rotation: Array
    reading: Array | None
    controller: Array | None

    @cached_property
    def states(self) -> States:
        return joint_states(self.record.qd, self.record.segment, self.record.period)

    def sensor(self, robot: Robot) -> tuple[Array, SensorOffset]:
        """Environment on arm, base axes, at the origin of frame 6; and what was taken off."""
        assert self.reading is not None
        assert robot.mounting is not None
        gravity = np.array(robot.gravity)
        offset = fit_offset(self.reading, self.rotation, self.record.period, gravity)
        free = self.reading - offset.reading(self.rotation, gravity)
        wrench = wrench_of_environment(free, self.rotation)
        position = np.array(robot.mounting.force_sensor)
        return move_to_frame_6(wrench, self.rotation, position), offset


def take(recording: Recording, robot: Robot, model: str, clock: Clock | None = None) -> Taken:
    """A recording, and its force sensor by the given clock; what it is known to carry counts."""
    intake = read_and_repair(recording.model_dump(), robot, max_gap=0.1)
    table = intake.robot
    step, segment = period(table), table["segment"].to_numpy()
    lowpass = partial(zero_phase_lowpass, rate=1 / step, order=4, cutoff=10.0)
    names = ("actual_q", "actual_qd")
    q, qd = (by_segment(lowpass, channel(table, name), segment) for name in names)
    qdd = by_segment(partial(differentiate, period=step), qd, segment)
    arm = build_arm(robot.carrying(recording.known_payload()), model)
    torque = inverse_dynamics(arm, *(torch.from_numpy(x) for x in (q, qd, qdd))).numpy()
    rotation, _, jacobian = flange_kinematics(robot, q)
    target = [channel(table, name) for name in ("target_moment", "target_current")]
    aligned = clock and resample(intake.sensors["force"], clock, table["time"].to_numpy())
    current = channel(table, "actual_current")
    return Taken(
        record=Record(recording.name, step, segment, q, qd, torque, current),
        ratio=standstill_ratio(*target, qd),
        jacobian=jacobian,
        rotation=rotation,
        reading=None if aligned is None else aligned[SENSOR].to_numpy(),
        controller=channel(table, "actual_TCP_force") if "actual_TCP_force_0" in table else None,
    )


@dataclass(frozen=True)
class Fitted:
    """What contact-free recordings tell: torque constants and friction, and what they leave.

    unseen: fits that have not seen a recording's path, by its name.
    """

    fit: CurrentFit
    unseen: dict[str, CurrentFit]
    model: ResidualModel

    def torque(self, taken: Taken) -> Array:
        """External torque, by a fit that has not seen the path."""
        return external(self.unseen.get(taken.record.name, self.fit), taken)

    def run(self, taken: Taken) -> ForceInput:
        record = taken.record
        grid = taken.states, record.segment, record.period
        return ForceInput(record.q, record.qd, self.torque(taken), *grid)

    def estimate(
        self, taken: Taken, extra: Array | float = 0.0, prior: ContactPrior = PRIOR
    ) -> WrenchEstimate:
        """The estimate as it is by default; extra: (N, 6) [Nm], put onto the external torque."""
        grid = (taken.states, taken.record.segment, taken.record.period)
        torque = self.torque(taken) + extra
        return estimate_wrench(torque, taken.jacobian, *grid, self.model, prior)

    def repeated(self, taken: Taken, contact_free: list[Taken]) -> WrenchEstimate | None:
        """The repeat-aware estimate; None where none of the runs is of the same trajectory."""
        runs = [self.run(free) for free in contact_free]
        found = repeat_aware(self.run(taken), runs, self.model, CUTOFF)
        if found is None:
            return None
        grid = (found.states, taken.record.segment, taken.record.period)
        return estimate_wrench(found.torque, taken.jacobian, *grid, found.model, PRIOR)


def external(fit: CurrentFit, taken: Taken) -> Array:
    record = taken.record
    return left_over(record, predict(fit, record), torque_constants(fit), smooth, CUTOFF)


def fitted(contact_free: list[Taken], robot: Robot) -> Fitted:
    """As `fit_friction` and `fit_residuals` do: who judges has seen no such path."""
    records, known = [taken.record for taken in contact_free], prior(contact_free, robot)
    fit = fit_currents(records, smooth, known)
    left_out = fit_without_each_path(records, smooth, known)
    unseen = {name: own for names, own in left_out for name in names}
    stretches = [
        Stretch(torque[rows], taken.states[rows], taken.record.period)
        for taken in contact_free
        for torque in [external(unseen.get(taken.record.name, fit), taken)]
        for rows in unbroken(taken.record.segment)
    ]
    model = fit_residual_model(stretches, CUTOFF, breakaway_torque(fit))
    paths = int(record_paths(records).max()) + 1
    return Fitted(fit, unseen, model.wider(few_paths(paths)))


def prior(contact_free: list[Taken], robot: Robot) -> Prior:
    motors = [robot.motor(joint) for joint in range(1, 7)]
    maker = np.array([101 * (motor.torque_constant or np.nan) for motor in motors])
    told = [column[np.isfinite(column)] for column in np.stack([t.ratio for t in contact_free]).T]
    controller = np.array([np.median(one) if len(one) else np.nan for one in told])
    inverse = torque_constant_prior(maker, controller, robot.joints, (0.3, 0.1, 0.1))
    return Prior(inverse, np.array([motor.torque_max for motor in motors]))
