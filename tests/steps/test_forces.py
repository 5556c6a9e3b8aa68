"""The steps of the force estimates, on made-up torques: loads, rates, alarms."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from tests.current_study import make_record, prior, smooth, with_current, with_noise
from tests.made_records import motion_of, signals_of, stretch, torques_of
from tests.made_tables import record
from tests.made_up_torques import MODEL, Free, between, free_run
from tests.steps.made_recording import CURRENTS_LOWPASS, NO_LOAD, Known, known_of, premises
from ur5lib.channels import TORQUE
from ur5lib.dynamics.link_model import LinkModel, load_regressor
from ur5lib.errors import Remark
from ur5lib.force.estimators import GATED
from ur5lib.force.problem import is_fitted
from ur5lib.force.residual_model import ResidualModel, Residuals, few_paths
from ur5lib.force.touched_link import place_jacobian
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import breakaway_torque, torque_constants
from ur5lib.identification.payload import SCALED_TORQUE_ERROR, PayloadEstimate, judged_load
from ur5lib.identification.samples import CurrentSamples
from ur5lib.identification.validation import least_squares_coefficients
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.carried import Carried
from ur5lib.records.codes import CauseCode
from ur5lib.records.contacts import Contact, Contacts
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import JudgedLoad, Prediction
from ur5lib.records.quality import Contradictions, Finding, contradiction
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.statics import link_frames
from ur5lib.steps.estimate_forces import estimate_forces
from ur5lib.steps.estimate_load import estimate_load
from ur5lib.steps.fit_residuals import fit_residuals, usual_residuals
from ur5lib.steps.judge_contacts import judge_contacts
from ur5lib.steps.predict_currents import predict_currents
from ur5lib.steps.set_threshold import set_threshold
from ur5lib.timeseries.arrays import Array

PERIOD = 0.016


def recording(arm: Robot, run: Free, controller: Array | None = None) -> Known:
    """What is known of a run before its forces; controller: its own wrench from currents (N, 6)."""
    nothing, qdd = 0 * run.q, np.gradient(run.qd, run.time, axis=0)
    return known_of(
        arm,
        signals_of(run.time, run.q, wrench_calc_from_currents=controller),
        motion_of(run.time, run.q, run.qd, qdd),
        Kinematics.of(run.time, run.rotation, nothing[:, :3], run.jacobian),
        currents=Currents(**stretch(run.time), load_doubt=nothing, external_torque=run.torque),
        residuals=Residuals(MODEL),
        friction=Friction(from_=["free"]),
    )


def forces_of(known: Known) -> Forces:
    forces: Forces = known.run(estimate_forces)
    return forces


def load_torque(ur5: Robot, run: Free, mass: float) -> Array:
    """What a load takes of the motors' torque, by inverse dynamics with it and without."""
    payload = Payload(mass=mass, center_of_mass=(0.0, 0.0, 0.08))
    qdd = np.gradient(run.qd, run.time, axis=0)
    models = [LinkModel(ur5.carrying(carried), "C") for carried in (payload, None)]
    loaded, bare = (model.inverse_dynamics(run.q, run.qd, qdd) for model in models)
    return bare - loaded


def test_every_estimate_has_its_band_and_its_odds(ur5: Robot) -> None:
    """But the controller's own wrench, which stands as it was recorded."""
    run, own = free_run(ur5, 0, seconds=16, period=PERIOD, scale=0.1), "controller_currents"
    count = len(run.time)
    wrench = np.arange(6.0) + np.zeros((count, 6))
    forces = forces_of(recording(ur5, run, wrench))
    np.testing.assert_array_equal(forces.wrench[own], wrench)
    assert forces.wrench.keys() - {own} == forces.std.keys()
    assert forces.std.keys() >= {"Fmap", "least_squares"}
    assert forces.log_odds.keys() == forces.wrench.keys() & {*GATED}
    shapes: list[tuple[Mapping[str, Array | None], tuple[int, ...]]] = [
        (forces.wrench, (count, 6)),
        (forces.std, (count, 6)),
        (forces.log_odds, (count,)),
        ({"background": forces.background}, (count, 6)),
    ]
    for arrays, shape in shapes:
        for values in arrays.values():
            assert values is not None
            assert values.shape == shape
            assert np.isfinite(values).all()


# What the arm carries


TWO_KILOGRAMS = PayloadEstimate(np.array([2.0, 0.1, 0.0, 0.0]), np.full(4, 0.05), np.full(3, 2.0))
KILOGRAM = Payload(mass=1.0)
UNLOADED = PayloadEstimate(np.full(4, 0.05), np.full(4, 0.05), np.full(3, 0.05))


@pytest.fixture(scope="module")
def friction() -> Friction:
    records = [with_noise(make_record(seed, seconds=10.0), seed) for seed in range(2)]
    fit = fit_currents(records, smooth, prior())
    return Friction(
        from_=["a", "b"], fit=fit, least_squares=least_squares_coefficients(records), paths=5
    )


@dataclass(frozen=True)
class Loaded:
    """A recording whose arm carries two kilograms; load: their torque, (N, 6) [Nm]."""

    signals: Signals
    motion: Motion
    torques: Torques
    load: Array


@pytest.fixture(scope="module")
def loaded(ur5: Robot) -> Loaded:
    bare = make_record(7, seconds=10.0)
    per_load = load_regressor(ur5, ur5.fullest_model(), bare.q, bare.qd, 0 * bare.qd)
    load = per_load @ TWO_KILOGRAMS.parameters
    current = with_noise(with_current(replace(bare, torque=bare.torque + load)), 7).current
    return Loaded(*tables(replace(bare, current=current)), load)


def tables(record: CurrentSamples) -> tuple[Signals, Motion, Torques]:
    """Of a recording, its torque that of the fullest model."""
    time = record.period * np.arange(len(record.q))
    return (
        signals_of(time, record.q, actual_current=record.current),
        motion_of(time, record.q, record.qd),
        torques_of(time, {}, {"C+rotors": record.torque}),
    )


@dataclass(frozen=True)
class Predicted:
    """What predict_currents says of a load."""

    load: JudgedLoad | None
    currents: Currents

    @property
    def taken_torque(self) -> Array:
        """Of the load that the prediction contains, (N, 6) [Nm], times how each motor feels it."""
        assert self.currents.load_doubt is not None
        return np.nan_to_num(self.currents.load_doubt) / SCALED_TORQUE_ERROR

    def left_on_joint_2(self) -> float:
        """Median external torque [Nm]."""
        assert self.currents.external_torque is not None
        return float(np.nanmedian(np.abs(self.currents.external_torque[:, 1])))


def recording_of(loaded: Loaded, **known: Any) -> AlignedRecording:
    own = {"signals": loaded.signals, "motion": loaded.motion, "torques": loaded.torques}
    usual = {"name": "made", "date": "", "gravity": None, "untouched": None}
    return AlignedRecording(**usual | {"chain": (), "before": {}} | own | known)


def predicted(
    loaded: Loaded,
    friction: Friction,
    arm: Robot,
    role: str = "validate",
    found: PayloadEstimate = TWO_KILOGRAMS,
    unloaded: PayloadEstimate = UNLOADED,
    known: Carried = NO_LOAD,
    signs: Sequence[Finding] = (),
) -> Predicted:
    """What predict_currents makes of two kilograms that were found beside a known load."""
    currents, prediction = predict_currents(
        recording_of(loaded, role=role, premises=premises(*signs, load=known)),
        found,
        {"a": unloaded},
        friction,
        arm,
        CURRENTS_LOWPASS,
    )
    return Predicted(prediction.load, currents)


def test_a_load_that_is_certain_is_taken_into_the_prediction(
    loaded: Loaded, friction: Friction, ur5: Robot
) -> None:
    made, true = predicted(loaded, friction, ur5), np.median(np.abs(loaded.load), axis=0)
    load = made.load
    assert load is not None
    assert load.taken
    assert load.carried == load.mass == 2.0
    taken = np.median(made.taken_torque, axis=0)
    assert taken == pytest.approx(true, rel=0.3, abs=0.01)  # on every joint
    assert taken[1:3] == pytest.approx(true[1:3], rel=0.2)
    assert made.left_on_joint_2() < 0.1 * true[1]
    np.testing.assert_allclose(load.center_of_mass, [0.05, 0, 0])


def test_the_band_of_a_loaded_arm_has_the_doubt_of_its_load(
    loaded: Loaded, friction: Friction, ur5: Robot
) -> None:
    bands = [
        made.currents.band
        for made in (predicted(loaded, friction, ur5), predicted(loaded, friction, ur5, role="fit"))
    ]
    made, bare = (np.nanmedian(own, axis=0) for own in bands if own is not None)
    doubt = SCALED_TORQUE_ERROR * np.median(np.abs(loaded.load), axis=0)
    least = 1.5 * doubt / torque_constants(friction.fit)
    assert (np.sqrt(made**2 - bare**2) > least)[1:3].all()


def test_nothing_is_predicted_beside_a_stop_sign(
    loaded: Loaded, friction: Friction, ur5: Robot
) -> None:
    made = predicted(
        loaded, friction, ur5, signs=[contradiction(CauseCode.EXCHANGED_JOINTS, "", "wrong")]
    )
    assert made.load is None
    assert made.currents.external_torque is None


@pytest.mark.parametrize(
    ("of_fit", "speed", "is_predicted"),
    [(0.02, 1.0, False), (0.1, 1.0, True), (None, 1.0, True), (0.02, 0.0, True)],
)
def test_slow_samples_of_motion_take_a_fit_to_slow_recordings(
    friction: Friction, ur5: Robot, of_fit: float | None, speed: float, is_predicted: bool
) -> None:
    """Bands of a fit at 50 Hz, low-passed, do not hold the noise of a recording at 10 Hz."""
    made = with_noise(make_record(7, seconds=10.0), 7)
    slow = {name: getattr(made, name)[::5] for name in ("q", "qd", "torque", "current", "segment")}
    moved = replace(made, **slow, period=0.1)
    record = replace(moved, q=moved.q[0] + speed * (moved.q - moved.q[0]), qd=speed * moved.qd)
    run = Loaded(*tables(record), 0 * record.q)
    currents = predicted(run, replace(friction, period=of_fit), ur5).currents
    assert (currents.external_torque is not None) == is_predicted


@pytest.mark.parametrize(
    "given",
    [
        {"role": "fit"},  # its payload is taken as it is told
        {"known": Carried(KILOGRAM, "study", None)},  # and so is a declared one
        {"unloaded": replace(UNLOADED, parameters=np.ones(4))},  # bare runs seem to, too
        {"found": replace(TWO_KILOGRAMS, parts=np.array([4.0, 2.0, 0.0]))},
    ],
)
def test_a_load_is_not_taken_where_it_is_told_or_uncertain(
    loaded: Loaded, friction: Friction, ur5: Robot, given: dict[str, Any]
) -> None:
    made = predicted(loaded, friction, ur5, **given)
    assert made.load is not None
    assert not made.load.taken
    assert (made.taken_torque == 0).all()
    assert made.left_on_joint_2() > 0.8 * np.median(np.abs(loaded.load[:, 1]))


def test_what_the_controller_was_told_counts_as_carried(
    loaded: Loaded, friction: Friction, ur5: Robot
) -> None:
    """RTDE says 1 kg, 2 kg hang there beside it."""
    made = predicted(loaded, friction, ur5, known=Carried(KILOGRAM, "rtde", KILOGRAM))
    assert made.load is not None
    assert (made.load.configured, made.load.carried, made.load.taken) == (1.0, 3.0, True)
    true = np.median(np.abs(loaded.load[:, 1]))
    assert np.median(made.taken_torque[:, 1]) == pytest.approx(true, rel=0.2)


def test_a_load_is_told_by_an_arm_that_moves(
    loaded: Loaded, friction: Friction, ur5: Robot
) -> None:
    """At rest, without currents or without a fit, nothing is estimated, and no load is told."""

    def estimated(friction: Friction, **others: Any) -> PayloadEstimate:
        own = replace(loaded, **others)
        return estimate_load(recording_of(own), friction, ur5, CURRENTS_LOWPASS)

    assert estimated(friction).parameters[0] == pytest.approx(2.0, rel=0.1)
    still = replace(loaded.motion, motor_qd=0 * loaded.motion.qd)
    silent = replace(loaded.signals, actual_current=None)
    for nothing in (
        estimated(friction, motion=still),
        estimated(friction, signals=silent),
        estimated(Friction()),
    ):
        assert not nothing.is_known
        made = predicted(loaded, friction, ur5, found=nothing)
        assert made.load is None
        assert (made.taken_torque == 0).all()


def test_without_unloaded_runs_the_mass_stands_alone() -> None:
    """No recording to fit on moves: nothing tells how far runs differ."""
    load = judged_load(TWO_KILOGRAMS, [], paths=5, configured=0.0, may_be_taken=True)
    assert np.isfinite(load.std_error)


# What is left without contact


def residuals_of(arm: Robot, friction: Friction, paths: int, *runs: Free) -> Residuals:
    each = {str(k): recording(arm, run) for k, run in enumerate(runs)}
    currents = {name: own.currents for name, own in each.items()}
    motion = {name: own.motion for name, own in each.items()}
    kinematics = {name: own.kinematics for name, own in each.items()}
    fitted = replace(friction, paths=paths)
    return fit_residuals(fitted, currents, motion, kinematics, arm, None, 2.0)


def torque_model(residuals: Residuals) -> ResidualModel:
    assert residuals.tau_ext is not None
    return residuals.tau_ext


def test_contacts_that_hide_in_all_fits_are_found(ur5: Robot, friction: Friction) -> None:
    """Although, together, they look like the noise of a free arm."""
    runs, force = [], np.array([0.6, 0.0, 0.8])
    for seed in (1, 2, 3):
        run = free_run(ur5, seed, period=PERIOD)
        pushes = sum(between(run.time, start, start + 2.0) for start in (3.0, 8.0, 13.0))
        runs.append(run.pushed(run.wrench(60.0 * np.reshape(pushes, (-1, 1)) * force)))
    found = residuals_of(ur5, friction, 3, *runs)
    assert [*found.contacts] == ["0", "1", "2"]
    free = residuals_of(
        ur5, friction, 3, *(free_run(ur5, seed, period=PERIOD) for seed in (1, 2, 3))
    )
    assert not free.contacts
    assert torque_model(found).spread == pytest.approx(torque_model(free).spread, rel=0.5)


def test_a_contact_that_hides_in_a_fit_is_left_out(ur5: Robot, friction: Friction) -> None:
    """Of the residual model, and of the threshold, with its reason; free runs stay as they are."""
    runs = [free_run(ur5, seed, period=PERIOD) for seed in (1, 2, 3)]
    force = 50.0 * between(runs[0].time, 6.0, 8.0)[:, None] * np.array([0.6, 0.0, 0.8])
    touched = runs[0].pushed(runs[0].wrench(force))
    free, found = (residuals_of(ur5, friction, 3, one, *runs[1:]) for one in (runs[0], touched))
    assert not free.contacts
    assert [*found.contacts] == ["0"]
    ((start, end),) = found.contacts["0"]
    assert (start, end) == pytest.approx((6.0, 8.0), abs=0.5)
    assert [one.code for one in found.remarks if one not in free.remarks] == ["hidden contact"]
    assert torque_model(found).spread == pytest.approx(torque_model(free).spread, rel=0.25)
    odds = np.where(between(runs[0].time, 6.0, 8.0) > 0, 20.0, -5.0)
    forces = {"0": Forces(**stretch(runs[0].time), log_odds={"Fmap": odds})}
    signals = {"0": signals_of(runs[0].time, runs[0].q)}
    assert set_threshold(forces, signals, free, ur5, 1.0)["Fmap"] > 20
    assert set_threshold(forces, signals, found, ur5, 1.0)["Fmap"] == 0


def test_residuals_of_few_paths_are_wider(ur5: Robot, friction: Friction) -> None:
    runs = [free_run(ur5, seed, period=PERIOD) for seed in (1, 2)]
    found = {paths: residuals_of(ur5, friction, paths, *runs) for paths in (1, 2, 5)}
    models = {paths: torque_model(residuals) for paths, residuals in found.items()}
    # other arms stand for those missing of three
    assert models[1].doubt == models[2].doubt == pytest.approx(few_paths(3) / few_paths(5))
    assert models[5].doubt == 1
    # and for all three where there is none
    assert torque_model(usual_residuals(friction.fit, 2.0)).doubt == models[1].doubt
    assert (models[1].spread >= models[2].spread).all()
    assert (models[2].spread >= models[5].spread).all()
    assert (models[1].spread > models[5].spread).any()
    assert found[1].remarks[0].code == "one path of all"
    assert [len(found[paths].remarks) for paths in (1, 2, 5)] == [2, 1, 0]
    np.testing.assert_array_equal(models[5].breakaway, breakaway_torque(friction.fit))


def test_sensed_torques_have_no_usual_error(ur5: Robot, friction: Friction) -> None:
    runs = [free_run(ur5, seed, period=PERIOD) for seed in (1, 2)]
    sensed = replace(friction, effort=TORQUE.quantity)
    one, five = (torque_model(residuals_of(ur5, sensed, n, *runs)) for n in (1, 5))
    assert one.doubt == pytest.approx(few_paths(1) / few_paths(5))
    np.testing.assert_allclose(one.spread, five.spread)


@pytest.mark.parametrize(("seconds", "remarks"), [(8.0, 1), (12.0, 0)])
def test_few_paths_that_hardly_rest_ask_for_rest(
    ur5: Robot, friction: Friction, seconds: float, remarks: int
) -> None:
    """From ten seconds on it is known what a joint holds."""
    resting = free_run(ur5, 2, seconds=seconds, moving=False, period=PERIOD)
    found = residuals_of(ur5, friction, 2, free_run(ur5, 1, period=PERIOD), resting)
    assert len(found.remarks) == remarks


def test_of_a_joint_that_never_moves_other_arms_tell(ur5: Robot, friction: Friction) -> None:
    run = free_run(ur5, 4, period=PERIOD)
    still = replace(run, qd=run.qd * [1, 1, 1, 1, 1, 0])
    found = residuals_of(ur5, friction, 5, still)
    (reason,) = found.remarks
    assert reason.code == "still joints"
    assert "moves joint 6:" in reason.text
    np.testing.assert_array_equal(
        torque_model(found).spread, torque_model(usual_residuals(friction.fit, 2.0)).spread
    )
    # of a sensed torque, they do not
    refused = residuals_of(ur5, replace(friction, effort=TORQUE.quantity), 5, still)
    assert refused.refused == reason
    assert refused.tau_ext is None


def test_without_a_fit_there_are_no_residuals(ur5: Robot) -> None:
    assert residuals_of(ur5, Friction(), 0) == Residuals()


# Alarms


@pytest.mark.parametrize("in_reference", [True, False])
def test_a_threshold_counts_minutes_of_mixed_rates(ur5: Robot, in_reference: bool) -> None:
    """F̂ᵘ pushes thrice, as long as the peaks; it is the controller's, in a study without published
    values.
    """
    forces, signals, published = {}, {}, {}
    for name, period, peaks in (("fast", 0.002, [2.0, 4, 6]), ("slow", 0.01, [3.0, 5, 7])):
        odds = np.full(round(60 / period), -5.0)
        odds[[round(second / period) for second in (10, 30, 50)]] = peaks
        time = period * np.arange(len(odds))
        force = 2 * np.outer(odds + 5, [0, 1, 0, 9, 9, 9])  # N, Nm
        forces[name] = Forces(**stretch(time), log_odds={"Fmap": odds})
        signals[name] = signals_of(time, 0 * force, actual_TCP_force=force)
        published[name] = FurtherForces(**stretch(time), corrected={"Fu": force})
    of = published if in_reference else None
    found = set_threshold(forces, signals, Residuals(), ur5, 1.0, of)
    assert found.keys() == {"Fmap", "Fu"}
    assert 20 < found["Fu"] <= 20.5  # N, of 14, 16, 18, 20, 22, 24
    assert 5.0 < found["Fmap"] < 5.01  # two minutes allow two alarms: 6 and 7


def raised(run: Free, ur5: Robot) -> list[Contact]:
    """The alarms of F̂ᵐᵃᵖ."""
    known = recording(ur5, run)
    known = known.but(forces=forces_of(known), threshold={"Fmap": 0.0, "F*": 15.0})
    found: Contacts = known.run(judge_contacts)
    return [one for one in found.contacts if one.estimate == "Fmap"]


@pytest.mark.parametrize("mass", [2.0, 4.0])
def test_a_load_picked_up_on_the_way_is_named(ur5: Robot, mass: float) -> None:
    """From 8 s on, at whatever the gears pass on of it."""
    run = free_run(ur5, 5, seconds=18, period=PERIOD, scale=0.2)
    taken = 0.95 * load_torque(ur5, run, mass) * between(run.time, 8.0, 99.0)[:, None]
    found = raised(replace(run, torque=run.torque + taken), ur5)
    (load,) = [own for own in found if own.kind == "load"]
    assert load.load_mass == pytest.approx(mass, rel=0.1)
    assert load.start_s == pytest.approx(8.0, abs=0.5)
    assert load.end_s > 17


def test_a_push_is_no_load(ur5: Robot) -> None:
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    force = 40.0 * between(run.time, 6.0, 11.0)[:, None] * np.array([[0.6, 0.8, 0.0]])
    (found,) = raised(run.pushed(run.wrench(force)), ur5)
    assert found.kind == "contact"
    assert np.linalg.norm([found.Fx, found.Fy, found.Fz]) == pytest.approx(40, rel=0.25)
    assert not found.off_flange


def test_a_push_on_the_forearm_is_not_at_the_flange(ur5: Robot) -> None:
    """It loads no joint of the wrist."""
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    frames = link_frames(ur5, run.q)
    force = 60.0 * between(run.time, 6.0, 11.0)[:, None] * np.array([0.3, 0.8, 0.5, 0, 0, 0])
    touched = np.matvec(place_jacobian(*frames, 3, frames[1][:, 3]).mT, force)
    found = raised(replace(run, torque=run.torque + touched), ur5)
    assert [own.off_flange for own in found] == [True]


def test_a_push_on_the_forearm_is_no_false_alarm(ur5: Robot) -> None:
    """A sensor at the flange reads nothing of it, which alone would make it one."""
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    frames = link_frames(ur5, run.q)
    pushes = between(run.time, 3.0, 5.0) + between(run.time, 8.0, 10.0)
    force = 60.0 * pushes[:, None] * np.array([0.3, 0.8, 0.5, 0, 0, 0])
    touched = np.matvec(place_jacobian(*frames, 3, frames[1][:, 3]).mT, force)
    known = recording(ur5, replace(run, torque=run.torque + touched))
    silent = SensorWrenches(**stretch(run.time), wrench={"compensated": 0 * run.q})
    known = known.but(forces=forces_of(known), threshold={"Fmap": 0.0}, sensor=silent)
    known = known.but(role="validate")  # without the sensor, they would be false
    found: Contacts = known.run(judge_contacts)
    assert [(own.off_flange, own.kind) for own in found.contacts] == [(True, "off_flange")] * 2
    assert {own.false_alarms_per_min for own in found.detections} == {0}


def test_without_a_sensor_role_and_load_tell_false_alarms(ur5: Robot) -> None:
    """Not where the currents show a load, which an alarm may be."""
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    force = 40.0 * between(run.time, 6.0, 11.0)[:, None] * np.array([[0.6, 0.8, 0.0]])
    known = recording(ur5, run.pushed(run.wrench(force)))
    known = known.but(forces=forces_of(known), threshold={"Fmap": 0.0})
    for role, taken in product(("fit", "validate", "contact", ""), (False, True)):
        load = record(JudgedLoad, {"mass": 2.0, "taken": taken})
        own = known.but(role=role, prediction=Prediction(False, load=load))
        (found,) = own.run(judge_contacts).contacts
        assert found.kind == ("false" if role in ("fit", "validate") and not taken else "contact")


@pytest.mark.parametrize(
    ("friction", "signs", "withheld"),
    [
        (Friction(), [], False),
        (Friction(refused=Remark(CauseCode.NO_FIT_RECORDING, "no currents")), [], False),
        (Friction(from_=["free"]), [], True),
        (Friction(stopped=Remark(CauseCode.CONTRADICTING_CONSTANTS, "wrong")), [], True),
        (Friction(), [contradiction(CauseCode.EXCHANGED_JOINTS, "", "wrong")], True),
    ],
)
def test_a_stop_sign_withholds_the_static_estimate_too(
    friction: Friction, signs: list[Finding], withheld: bool
) -> None:
    assert is_fitted(friction, Contradictions(signs)) == withheld
