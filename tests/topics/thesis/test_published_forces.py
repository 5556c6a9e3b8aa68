"""The thesis's force estimates, and the sensor, against a wrench that is known."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
import pytest

from tests.made_records import motion_of, signals_of, torques_of
from tests.steps.made_recording import Known, aligned, known_of, premises
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import Remark
from ur5lib.force.controller import further_or_controller
from ur5lib.records.clocks import SettledClock
from ur5lib.records.codes import CauseCode
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.force_errors import Compared, ForceError
from ur5lib.records.forces import FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.quality import Quality, StartOffset, contradiction
from ur5lib.records.signals import SENSOR_COLUMNS
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.clock import STAMPS_METHOD
from ur5lib.steps.judge_sensor import judge_sensor
from ur5lib.timeseries.lowpass import Butterworth
from ur5lib.topics.thesis.current_based import friction_torque
from ur5lib.topics.thesis.rebuild_thesis import rebuild_thesis

PERIOD, COUNT = 0.008, 2500
TIME = np.arange(COUNT) * PERIOD
START = 0.5  # s, by which the sensor starts later by its stamps
BIAS = np.array([-5.0, 2.0, -1.0, 0.1, 0.4, -0.1])
FORCE = np.array([10.0, -5.0, 8.0])
LOWPASS = Butterworth(5, 1.454)


def truth() -> tuple[np.ndarray, ...]:
    """A slow, singularity-free motion; between 3 and 9 s, a force pushes at the
    origin of frame 6."""
    angle = 0.4 * TIME[:, None] + np.arange(6)
    home = np.array([0.3, -1.2, 1.1, -0.9, 1.4, 0.2])
    q, qd, qdd = home + 0.2 * np.sin(angle), 0.08 * np.cos(angle), -0.032 * np.sin(angle)
    pushed = (TIME > 3.0) & (TIME < 9.0)
    wrench = np.where(pushed[:, None], np.append(FORCE, [0, 0, 0]), 0.0)
    return q, qd, qdd, wrench


@dataclass(frozen=True)
class Results:
    """What the steps make of it."""

    known: Known
    published: FurtherForces
    sensor: SensorWrenches
    compared: Compared

    def error(self, kind: str, estimate: str, component: str = "Fx") -> ForceError:
        """Over all samples."""
        about = kind, estimate, "all", component
        (row,) = (
            row
            for row in self.compared.errors
            if (row.kind, row.estimate, row.during, row.component) == about
        )
        return row


def rebuilt(known: Known) -> FurtherForces:
    published: FurtherForces = known.run(rebuild_thesis).further
    return published


@pytest.fixture(scope="module")
def results(ur5: Robot) -> Results:
    q, qd, qdd, wrench = truth()
    torque = LinkModel(ur5, "C").inverse_dynamics(q, qd, qdd)
    rotation, origin, J = flange_kinematics(ur5, q)

    constants = ur5.current_to_torque
    total = torque + friction_torque(qd, ur5.friction) - np.einsum("nij,ni->nj", J, wrench)
    current = (total - constants.offset) / constants.torque_constant
    # The sensor sits 28.6 mm out and reads the hand on the arm.
    lever = rotation @ np.array(ur5.mounting.force_sensor)
    moment = wrench[:, 3:] - np.cross(lever, wrench[:, :3])
    reading = np.concatenate(
        [np.einsum("nji,nj->ni", rotation, half) for half in (wrench[:, :3], moment)], axis=1
    )
    read = {"actual_current": current, "force_sensor": reading + BIAS}
    sent = {"target_qd": qd, "actual_TCP_force": -wrench + 1.0}
    columns = dict(zip(SENSOR_COLUMNS["force"], (reading + BIAS).T, strict=True))
    clock = SettledClock(START, 0.001, None, None, STAMPS_METHOD, warning=None, end_std=0.001)
    known = known_of(
        ur5,
        signals_of(TIME, q, **read, **sent),
        motion_of(TIME, q, qd, qdd),
        Kinematics.of(TIME, rotation, origin, J),
        torques=torques_of(TIME, {"C": torque}, {"C": torque}),
        force=pd.DataFrame({"time": TIME - START} | columns),
        quality=Quality(starts={"force": StartOffset(START, 0.001)}),
        alignment=aligned({"force": clock}),
        lowpass=LOWPASS,
    )
    published = rebuilt(known)
    return Results(known, published, *known.but(further=published).run(judge_sensor))


def test_the_corrected_estimate_finds_the_force(results: Results) -> None:
    """Away from the push's edge, which the filter rounds."""
    settled = (TIME > 5) & (TIME < 7)
    estimate = results.published.corrected["F*"][settled]
    np.testing.assert_allclose(estimate, truth()[3][settled], atol=0.1)


@pytest.mark.parametrize(
    "contradicting",
    [
        {"friction": Friction(stopped=Remark(CauseCode.CONTRADICTING_CONSTANTS, "wrong"))},
        {"premises": premises(contradiction(CauseCode.EXCHANGED_JOINTS, "", "wrong"))},
    ],
)
def test_no_force_is_stated_where_fit_or_recording_contradicts_the_arm(
    results: Results, contradicting: dict
) -> None:
    """Nor that of the controller, in a study without published values."""
    known = results.known.but(**contradicting)
    withheld = rebuilt(known)
    assert withheld.corrected == withheld.printed == {}
    beside = known.run(judge_sensor).compared.errors
    assert beside == []


def test_without_published_values_the_controller_s_estimate_stands_alone(results: Results) -> None:
    known = results.known
    stated = further_or_controller(None, known.arm, known.signals, withheld=False).corrected
    assert stated.keys() == {"Fu"}
    np.testing.assert_array_equal(stated["Fu"], results.published.corrected["Fu"])
    rows = known.run(judge_sensor).compared.errors
    assert {row.estimate for row in rows if row.kind == "corrected"} == {"Fu"}


def test_without_friction_the_estimate_is_off(results: Results) -> None:
    assert results.error("corrected", "F").mae > 5


def test_errors_in_contact_are_of_use_but_where_a_fit_has_used_the_recording(
    results: Results,
) -> None:
    known = results.known.but(further=results.published)
    for role, use in (("contact", {("yes", "")}), ("fit", {("no", "fitted")})):
        rows = known.but(role=role).run(judge_sensor).compared.errors
        assert {(row.use, row.reason) for row in rows if row.use is not None} == use


def test_the_sensor_is_put_right(results: Results) -> None:
    offset = results.compared.offset
    assert offset is not None
    np.testing.assert_allclose(offset.start_bias, BIAS, atol=1e-6)
    np.testing.assert_allclose(offset.bias, BIAS, atol=1e-3)
    away = np.abs(np.abs(TIME - 6) - 3) > 0.3  # from the push's edges, at which resampling rings
    corrected = results.sensor.wrench["corrected"]
    np.testing.assert_allclose(corrected[away], truth()[3][away], atol=1e-2)
    np.testing.assert_allclose(results.sensor.wrench["compensated"], truth()[3], atol=1e-2)
    assert results.compared.mounting_doubt is None


def test_the_printed_kind_keeps_the_bias_and_the_delay(results: Results) -> None:
    published = results.published
    assert results.error("printed", "Fu").zero_mae > 1
    rising = np.argmax(published.corrected["F*"][:, 2] > 4) * PERIOD
    late = np.argmax(published.printed["F*"][125:, 2] > 4) * PERIOD + 1
    assert late - rising == pytest.approx(0.35, abs=0.1)


def test_an_estimate_of_zero_stands_beside(results: Results) -> None:
    expected = np.abs(truth()[3]).mean(0)[:3]
    zeros = [results.error("corrected", "F*", axis).zero_mae for axis in ("Fx", "Fy", "Fz")]
    np.testing.assert_allclose(zeros, expected, rtol=2e-3)
    assert results.error("corrected", "Fu").mae == pytest.approx(1.0)
