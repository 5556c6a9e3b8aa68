"""Real recordings as the force estimates need them: external torque, Jacobian, sensor."""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import jacobian, link_frames
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.force.external_torque import (
    States,
    external_torque,
    joint_states,
    unbroken,
    without_edges,
)
from ur5lib.force.hypotheses import ContactPrior
from ur5lib.force.residual_model import ResidualModel, Stretch, fit_residual_model
from ur5lib.force.sensor import SensorOffset, fit_offset, move_to_frame_6, wrench_of_environment
from ur5lib.force.template import Run, repeat_aware
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench
from ur5lib.identification.currents import CurrentFit, fit_currents, predict
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record
from ur5lib.identification.torque_constants import standstill_ratio, torque_constant_prior
from ur5lib.intake import take_in
from ur5lib.robots.description import Robot
from ur5lib.signals.clocks import clock_from_stamps
from ur5lib.signals.lowpass import by_segment, zero_phase_lowpass
from ur5lib.signals.motion import differentiate
from ur5lib.signals.resampling import resample
from ur5lib.study import Recording
from ur5lib.tables import Array, channel, period

CUTOFF = 2.0  # Hz, of currents and external torques
SENSOR = ["ft_fx", "ft_fy", "ft_fz", "ft_tx", "ft_ty", "ft_tz"]
PRIOR = ContactPrior()


def smooth(values: Array, record: Record) -> Array:
    lowpass = partial(zero_phase_lowpass, rate=1 / record.period, order=4, cutoff=CUTOFF)
    return by_segment(lowpass, values, record.segment)


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


def take(recording: Recording, robot: Robot, model: str) -> Taken:
    intake = take_in(recording.model_dump(), robot, max_gap=0.1)
    table = intake.robot
    step, segment = period(table), table["segment"].to_numpy()
    lowpass = partial(zero_phase_lowpass, rate=1 / step, order=4, cutoff=10.0)
    names = ("actual_q", "actual_qd")
    q, qd = (by_segment(lowpass, channel(table, name), segment) for name in names)
    qdd = by_segment(partial(differentiate, period=step), qd, segment)
    arm = build_arm(robot, model)
    state = [torch.from_numpy(x) for x in (q, qd, qdd)]
    torque = inverse_dynamics(arm, *state).numpy()
    current = channel(table, "actual_current")
    target = [channel(table, name) for name in ("target_moment", "target_current")]
    force = intake.sensors.get("force")
    aligned = None if force is None else resample(force, clock_from_stamps(0, 0), table["time"])
    return Taken(
        record=Record(recording.name, step, segment, q, qd, torque, current),
        ratio=standstill_ratio(*target, qd),
        jacobian=jacobian(arm, state[0]).numpy(),
        rotation=link_frames(arm, state[0])[0][:, -1].numpy(),
        reading=None if aligned is None else aligned[SENSOR].to_numpy(),
        controller=channel(table, "actual_TCP_force") if "actual_TCP_force_0" in table else None,
    )


@dataclass(frozen=True)
class Fitted:
    """What contact-free recordings tell: torque constants and friction, and what they leave."""

    fit: CurrentFit
    model: ResidualModel

    def torque(self, taken: Taken) -> Array:
        return external(self.fit, taken)

    def run(self, taken: Taken) -> Run:
        record = taken.record
        return Run(record.q, record.qd, self.torque(taken), taken.states, record.segment)

    def estimate(self, taken: Taken) -> WrenchEstimate:
        record = taken.record
        grid = (taken.states, record.segment, record.period)
        return estimate_wrench(self.torque(taken), taken.jacobian, *grid, self.model, PRIOR)

    def repeated(self, taken: Taken, contact_free: list[Taken]) -> WrenchEstimate:
        record = taken.record
        runs = [self.run(free) for free in contact_free]
        found = repeat_aware(self.run(taken), runs, self.model, record.period, CUTOFF)
        assert found is not None
        grid = (found.states, record.segment, record.period)
        return estimate_wrench(found.torque, taken.jacobian, *grid, found.model, PRIOR)


def external(fit: CurrentFit, taken: Taken) -> Array:
    record = taken.record
    constant = np.array([1 / joint.estimate.coefficients[0] for joint in fit.joints])
    currents = (smooth(x, record) for x in (record.current, predict(fit, record)))
    torque = external_torque(constant, *currents)
    return without_edges(torque, record.segment, round(0.5 / CUTOFF / record.period))


def fitted(contact_free: list[Taken], robot: Robot) -> Fitted:
    fit = fit_currents([taken.record for taken in contact_free], smooth, prior(contact_free, robot))
    stretches: list[Stretch] = []
    for taken in contact_free:
        torque = external(fit, taken)
        rows = unbroken(taken.record.segment)
        stretches += [(torque[part], taken.states[part]) for part in rows]
    return Fitted(fit, fit_residual_model(stretches, contact_free[0].record.period, CUTOFF))


def prior(contact_free: list[Taken], robot: Robot) -> Prior:
    motors = [robot.motor(joint) for joint in range(1, 7)]
    maker = np.array([101 * (motor.torque_constant or np.nan) for motor in motors])
    told = [column[np.isfinite(column)] for column in np.stack([t.ratio for t in contact_free]).T]
    controller = np.array([np.median(one) if len(one) else np.nan for one in told])
    inverse = torque_constant_prior(maker, controller, robot.joints, (0.3, 0.1, 0.1))
    return Prior(inverse, np.array([motor.torque_max for motor in motors]))
