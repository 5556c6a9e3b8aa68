"""The steps of the force estimates, on made-up torques: loads, rates, alarms."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.library.current_study import CONSTANT, make_record, prior, smooth, with_noise
from tests.library.made_up_torques import MODEL, Free, between, free_run
from tests.made_records import motion_of, signals_of, stretch, torques_of
from tests.scripts.conftest import script
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import remark
from ur5lib.force.estimators import GATED
from ur5lib.force.flange_contact import lever
from ur5lib.force.problem import is_fitted
from ur5lib.force.residual_model import ResidualModel, Residuals, few_paths
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import breakaway_torque
from ur5lib.identification.payload import LEFT, JudgedLoad, PayloadEstimate, judged_load
from ur5lib.identification.validation import least_squares_coefficients
from ur5lib.recordings.quality import Contradictions, Finding, contradiction
from ur5lib.records.carried import Carried
from ur5lib.records.contacts import Alarm, Detected
from ur5lib.records.currents import Currents, LoadRegressor
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.records.friction import Friction, KnownConstants
from ur5lib.records.prediction import Prediction
from ur5lib.robots.description import Payload, Robot, robot_path
from ur5lib.robots.statics import link_frames
from ur5lib.steps.fit_residuals import usual_residuals
from ur5lib.tables import read_json, read_record, read_table, write_json
from ur5lib.timeseries.arrays import Array

PERIOD = 0.016
BARE = JudgedLoad(0.0, 0.05, (0.0, 0.0), False, 0.0, 0.0, False, np.zeros(3), np.zeros(3))
LOADED = replace(BARE, mass=2.7, carried=2.7)
SENSED = KnownConstants(np.ones(6), np.zeros(6))
INPUTS = "motion residuals kinematics currents load friction contradictions signals"
SUMMARIES = {"load", "residuals", "threshold", "detection", "friction", "contradictions"}
SETTINGS = SimpleNamespace(recording="own", cutoff_hz=2.0, contact_force_n=15.0, tries=False)


@dataclass(frozen=True)
class Recording:
    """A recording's tables in a folder of its own."""

    folder: Path

    def __getattr__(self, name: str) -> str:
        if name == "arm":
            return str(robot_path("ur5"))
        suffix = "json" if name in SUMMARIES else "parquet"
        return str(self.folder / f"{name}.{suffix}")

    def write(
        self, run: Free, load: JudgedLoad | None = None, controller: Array | None = None
    ) -> "Recording":
        """What estimate_forces reads of it; controller: its own wrench from currents (N, 6)."""
        self.folder.mkdir(parents=True, exist_ok=True)
        grid, nothing = stretch(run.time), 0 * run.q
        motion = motion_of(run.time, run.q, run.qd)
        motion.write(self.motion)
        torques = dict.fromkeys(("external_torque", "causal_torque"), run.torque)
        currents = Currents(**grid, load_doubt=nothing, **torques)
        currents.write(self.currents)
        signals = signals_of(run.time, run.q, wrench_calc_from_currents=controller)
        signals.write(self.signals)
        SensorWrenches(**grid).write(self.sensor)
        PublishedForces(**grid).write(self.published)
        frames = run.rotation, nothing[:, :3], run.jacobian
        Kinematics.of(run.time, *frames).write(self.kinematics)
        write_json(Prediction(True, {}, load), self.load)
        write_json(Residuals(MODEL, MODEL), self.residuals)
        write_json(Friction(from_=["free"]), self.friction)
        write_json(Contradictions(), self.contradictions)
        return self

    def estimate(self) -> Forces:
        """What estimate_forces makes of it."""
        names = [
            "motion",
            "residuals",
            "kinematics",
            "currents",
            "load",
            "friction",
            "contradictions",
            "signals",
        ]
        input = SimpleNamespace(**{name: getattr(self, name) for name in names})
        script("estimate_forces").estimate_forces(input, self, SETTINGS)
        return Forces.from_table(read_table(self.forces))  # another estimate may replace the file


@pytest.fixture(scope="module")
def weighty(ur5: Robot) -> tuple[Free, Free]:
    """One motion, bare and with what 2.7 kg leave of the motors' torque."""
    bare = free_run(ur5, 0, seconds=16, period=PERIOD, scale=0.1)
    loaded = Free(**vars(bare) | {"torque": bare.torque + load_torque(ur5, bare, 2.7)})
    return bare, loaded


def load_torque(ur5: Robot, run: Free, mass: float) -> np.ndarray:
    """What a load takes of the motors' torque, by inverse dynamics with it and without."""
    payload = Payload(mass=mass, center_of_mass=(0.0, 0.0, 0.08))
    qdd = np.gradient(run.qd, run.time, axis=0)
    models = [LinkModel(ur5.carrying(carried), "C") for carried in (payload, None)]
    loaded, bare = (model.inverse_dynamics(run.q, run.qd, qdd) for model in models)
    return bare - loaded


def test_every_estimate_has_its_band_and_its_odds(
    weighty: tuple[Free, Free], tmp_path: Path
) -> None:
    """But the controller's own wrench, which stands as it was recorded."""
    bare, _ = weighty
    count, own = len(bare.time), "controller_currents"
    wrench = np.arange(6.0) + np.zeros((count, 6))
    forces = Recording(tmp_path).write(bare, BARE, wrench).estimate()
    np.testing.assert_array_equal(forces.wrench[own], wrench)
    assert forces.wrench.keys() - {own} == forces.std.keys()
    assert forces.std.keys() >= {"Fmap", "least_squares"}
    assert forces.log_odds.keys() == forces.wrench.keys() & {*GATED}
    shapes = [
        (forces.wrench, (count, 6)),
        (forces.std, (count, 6)),
        (forces.log_odds, (count,)),
        ({"causal": forces.causal_log_odds}, (count,)),
        ({"background": forces.background}, (count, 6)),
    ]
    for arrays, shape in shapes:
        for values in arrays.values():
            assert values is not None
            assert values.shape == shape
            assert np.isfinite(values).all()


# What the arm carries


LOAD_2 = 14.0  # Nm on joint 2, of 2 kg
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
class Predicted:
    """What predict_currents says of a load, and its table."""

    load: JudgedLoad | None
    currents: Currents

    @property
    def taken_torque(self) -> np.ndarray:
        """Of the load that the prediction contains, (N, 6) [Nm], times how each motor feels it."""
        assert self.currents.load_doubt is not None
        return self.currents.load_doubt / LEFT

    def left_on_joint_2(self) -> float:
        """Median external torque [Nm]."""
        assert self.currents.external_torque is not None
        return float(np.nanmedian(np.abs(self.currents.external_torque[:, 1])))


def predicted(folder: Path, friction: Friction, **given: Any) -> Predicted:
    """What predict_currents makes of payload.json, where 14 Nm more than known load joint 2."""
    bare = with_noise(make_record(7, seconds=10.0), 7)
    count, names = len(bare.q), ("signals", "motion", "torques", "regressor")
    record = replace(bare, current=bare.current + LOAD_2 * np.eye(6)[1] / CONSTANT)
    found = given.get("found", TWO_KILOGRAMS)
    known = given.get("known", Carried(None, "none", None))
    unloaded = given.get("unloaded", [UNLOADED])
    per_load = np.zeros((count, 6, 4))
    per_load[:, 1, 0] = LOAD_2 / 2.0
    files: dict[str, Any] = {name: str(folder / f"{name}.parquet") for name in names}
    time = record.period * np.arange(count)
    signals_of(time, record.q, actual_current=record.current).write(files["signals"])
    motion_of(time, record.q, record.qd).write(files["motion"])
    torques_of(time, {}, {"C+rotors": record.torque}).write(files["torques"])
    LoadRegressor(**stretch(time), load_regressor=per_load).write(files["regressor"])
    signs = Contradictions(given.get("signs", []))
    summaries = {"payload": found, "load": known, "friction": friction, "contradictions": signs}
    for name, summary in summaries.items():
        files[name] = str(folder / f"{name}.json")
        write_json(summary, files[name])
    files["unloaded"] = [str(folder / f"unloaded_{i}.json") for i in range(len(unloaded))]
    for path, own in zip(files["unloaded"], unloaded, strict=True):
        write_json(own, path)
    input = SimpleNamespace(arm=robot_path("ur5"), **files)
    output = SimpleNamespace(currents=folder / "currents.parquet", summary=folder / "currents.json")
    lowpass = {"order": 4, "cutoff_hz": 2.0}
    params = SimpleNamespace(
        role=given.get("role", "validate"), recording="made", untouched=None, **lowpass
    )
    script("predict_currents").predict_currents(input, output, params)
    return Predicted(read_record(Prediction, output.summary).load, Currents.read(output.currents))


def test_a_load_that_is_certain_is_taken_into_the_prediction(
    friction: Friction, tmp_path: Path
) -> None:
    made = predicted(tmp_path, friction)
    load = made.load
    assert load is not None
    assert load.taken
    assert load.carried == load.mass == 2.0
    assert np.median(made.taken_torque[:, 1]) == pytest.approx(LOAD_2, rel=0.2)
    assert (made.taken_torque[:, [0, 2, 3, 4, 5]] == 0).all()
    assert made.left_on_joint_2() < 0.1 * LOAD_2
    np.testing.assert_allclose(load.center_of_mass, [0.05, 0, 0])


def test_nothing_is_predicted_beside_a_stop_sign(friction: Friction, tmp_path: Path) -> None:
    made = predicted(tmp_path, friction, signs=[contradiction("unusable")])
    assert made.load is None
    assert made.currents.external_torque is None


@pytest.mark.parametrize(
    "given",
    [
        {"role": "fit"},  # its payload is taken as it is told
        {"known": Carried(KILOGRAM, "study", None)},  # and so is a declared one
        {"unloaded": [replace(UNLOADED, parameters=np.ones(4))]},  # bare runs seem to, too
        {"found": replace(TWO_KILOGRAMS, parts=np.array([4.0, 2.0, 0.0]))},
    ],
)
def test_a_load_is_not_taken_where_it_is_told_or_uncertain(
    friction: Friction, tmp_path: Path, given: dict[str, Any]
) -> None:
    made = predicted(tmp_path, friction, **given)
    assert made.load is not None
    assert not made.load.taken
    assert (made.taken_torque == 0).all()
    assert made.left_on_joint_2() > 0.8 * LOAD_2


def test_what_the_controller_was_told_counts_as_carried(friction: Friction, tmp_path: Path) -> None:
    """RTDE says 1 kg, 2 kg hang there beside it."""
    made = predicted(tmp_path, friction, known=Carried(KILOGRAM, "rtde", KILOGRAM))
    assert made.load is not None
    assert (made.load.configured, made.load.carried, made.load.taken) == (1.0, 3.0, True)
    assert np.median(made.taken_torque[:, 1]) == pytest.approx(LOAD_2, rel=0.2)


def test_at_rest_no_load_is_told(friction: Friction, tmp_path: Path) -> None:
    made = predicted(tmp_path, friction, found=PayloadEstimate())
    assert made.load is None
    assert (made.taken_torque == 0).all()


def test_without_unloaded_runs_the_mass_stands_alone() -> None:
    """No recording to fit on moves: nothing tells how far runs differ."""
    load = judged_load(TWO_KILOGRAMS, [], paths=5, configured=0.0, may_be_taken=True)
    assert np.isfinite(load.std_error)


# What is left without contact


def fit_residuals(tmp_path: Path, friction: Friction, paths: int, *runs: Free) -> Residuals:
    recordings = [Recording(tmp_path / f"{i}").write(run) for i, run in enumerate(runs)]
    write_json(replace(friction, paths=paths), tmp_path / "friction.json")
    input = SimpleNamespace(
        friction=tmp_path / "friction.json",
        currents=[own.currents for own in recordings],
        motion=[own.motion for own in recordings],
    )
    output = SimpleNamespace(residuals=tmp_path / "residuals.json")
    script("fit_residuals").fit_residuals(input, output, SETTINGS)
    return read_record(Residuals, output.residuals)


def torque_model(residuals: Residuals) -> ResidualModel:
    assert residuals.tau_ext is not None
    return residuals.tau_ext


def test_residuals_of_few_paths_are_wider(ur5: Robot, friction: Friction, tmp_path: Path) -> None:
    runs = [free_run(ur5, seed, period=PERIOD) for seed in (1, 2)]
    found = {paths: fit_residuals(tmp_path, friction, paths, *runs) for paths in (1, 2, 5)}
    models = {paths: torque_model(residuals) for paths, residuals in found.items()}
    # other arms stand for those missing of three
    assert models[1].doubt == models[2].doubt == pytest.approx(few_paths(3) / few_paths(5))
    assert models[5].doubt == 1
    # and for all three where there is none
    assert torque_model(usual_residuals(friction.fit, 2.0)).doubt == models[1].doubt
    assert (models[1].spread >= models[2].spread).all()
    assert (models[2].spread >= models[5].spread).all()
    assert (models[1].spread > models[5].spread).any()
    assert found[1].remarks[0] == remark("one path of all")
    assert [len(found[paths].remarks) for paths in (1, 2, 5)] == [2, 1, 0]
    assert found[5].tau_causal is not None
    np.testing.assert_array_equal(models[5].breakaway, breakaway_torque(friction.fit))


def test_sensed_torques_have_no_usual_error(ur5: Robot, friction: Friction, tmp_path: Path) -> None:
    runs = [free_run(ur5, seed, period=PERIOD) for seed in (1, 2)]
    sensed = replace(friction, known_constants=SENSED)
    one, five = (torque_model(fit_residuals(tmp_path, sensed, n, *runs)) for n in (1, 5))
    assert one.doubt == pytest.approx(few_paths(1) / few_paths(5))
    np.testing.assert_allclose(one.spread, five.spread)


@pytest.mark.parametrize(("seconds", "remarks"), [(8.0, 1), (12.0, 0)])
def test_few_paths_that_hardly_rest_ask_for_rest(
    ur5: Robot, friction: Friction, tmp_path: Path, seconds: float, remarks: int
) -> None:
    """From ten seconds on it is known what a joint holds."""
    resting = free_run(ur5, 2, seconds=seconds, moving=False, period=PERIOD)
    found = fit_residuals(tmp_path, friction, 2, free_run(ur5, 1, period=PERIOD), resting)
    assert len(found.remarks) == remarks


def test_of_a_joint_that_never_moves_other_arms_tell(
    ur5: Robot, friction: Friction, tmp_path: Path
) -> None:
    run = free_run(ur5, 4, period=PERIOD)
    still = Free(**vars(run) | {"qd": run.qd * [1, 1, 1, 1, 1, 0]})
    reason = remark("still joints", joints=[6])
    found = fit_residuals(tmp_path, friction, 5, still)
    assert found.remarks == (reason,)
    np.testing.assert_array_equal(
        torque_model(found).spread, torque_model(usual_residuals(friction.fit, 2.0)).spread
    )
    # of a sensed torque, they do not
    refused = fit_residuals(tmp_path, replace(friction, known_constants=SENSED), 5, still)
    assert refused.refused == reason
    assert refused.tau_ext is None


def test_without_a_fit_there_are_no_residuals(tmp_path: Path) -> None:
    assert fit_residuals(tmp_path, Friction(), 0) == Residuals()


# Alarms


def test_a_threshold_counts_minutes_of_mixed_rates(tmp_path: Path) -> None:
    """Causal odds have a threshold of their own; F̂ᵘ pushes thrice, as long as the peaks."""
    paths, published = [], []
    for period, peaks in ((0.002, [2.0, 4.0, 6.0]), (0.01, [3.0, 5.0, 7.0])):
        odds = np.full(round(60 / period), -5.0)
        odds[[round(second / period) for second in (10, 30, 50)]] = peaks
        grid = {"time": period * np.arange(len(odds)), "segment": np.zeros(len(odds), np.int64)}
        paths.append(str(tmp_path / f"{len(paths)}.parquet"))
        Forces(**grid, log_odds={"Fmap": odds}, causal_log_odds=odds - 1).write(paths[-1])
        published.append(str(tmp_path / f"published_{len(paths)}.parquet"))
        force = np.outer(odds + 5, [0, 1, 0, 9, 9, 9])  # N, Nm
        PublishedForces(**grid, corrected={"Fu": 2 * force}).write(published[-1])
    input = SimpleNamespace(forces=paths, published=published)
    output = SimpleNamespace(threshold=tmp_path / "threshold.json")
    params = SimpleNamespace(false_alarms_per_min=1)
    script("set_threshold").set_threshold(input, output, params)
    found = read_json(output.threshold)
    assert found.keys() == {"Fmap", "Fu", "causal"}
    assert found["causal"] == pytest.approx(found["Fmap"] - 1)
    assert 20 < found["Fu"] <= 20.5  # N, of 14, 16, 18, 20, 22, 24
    assert 5.0 < found["Fmap"] < 5.01  # two minutes allow two alarms: 6 and 7


def detect(recording: Recording, run: Free, ur5: Robot) -> list[Alarm]:
    """What detect_contacts raises of F̂ᵐᵃᵖ."""
    qdd = np.gradient(run.qd, run.time, axis=0)
    per_load = LinkModel(ur5, "C").regressor(run.q, run.qd, qdd)[:, :, 50:54]  # of link 6
    forces = recording.write(run, BARE).estimate()
    regressor = LoadRegressor(time=run.time, segment=forces.segment, load_regressor=per_load)
    regressor.write(recording.regressor)
    write_json({"Fmap": 0.0, "F*": 15.0}, recording.threshold)
    script("detect_contacts").detect_contacts(recording, recording, SETTINGS)
    return read_record(dict[str, Detected], recording.detection)["Fmap"].raised


@pytest.mark.parametrize("mass", [2.0, 4.0])
def test_a_load_picked_up_on_the_way_is_named(ur5: Robot, tmp_path: Path, mass: float) -> None:
    """From 8 s on, at whatever the gears pass on of it."""
    run = free_run(ur5, 5, seconds=18, period=PERIOD, scale=0.2)
    taken = 0.95 * load_torque(ur5, run, mass) * between(run.time, 8.0, 99.0)[:, None]
    loaded = Free(**vars(run) | {"torque": run.torque + taken})
    found = detect(Recording(tmp_path), loaded, ur5)
    (load,) = [own for own in found if own.kind == "load"]
    assert load.load_mass == pytest.approx(mass, rel=0.1)
    assert load.start == pytest.approx(8.0, abs=0.5)
    assert load.end > 17


def test_a_push_is_no_load(ur5: Robot, tmp_path: Path) -> None:
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    force = 40.0 * between(run.time, 6.0, 11.0)[:, None] * np.array([[0.6, 0.8, 0.0]])
    found = detect(Recording(tmp_path), run.pushed(run.wrench(force)), ur5)
    assert [own.kind for own in found] == ["contact"]
    assert np.linalg.norm(found[0].force) == pytest.approx(40, rel=0.25)
    assert not found[0].off_flange


def test_a_push_on_the_forearm_is_not_at_the_flange(ur5: Robot, tmp_path: Path) -> None:
    """It loads no joint of the wrist."""
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    frames = link_frames(ur5, run.q)
    force = 60.0 * between(run.time, 6.0, 11.0)[:, None] * np.array([0.3, 0.8, 0.5, 0, 0, 0])
    touched = np.matvec(lever(*frames, 3, frames[1][:, 3]).mT, force)
    found = detect(Recording(tmp_path), replace(run, torque=run.torque + touched), ur5)
    assert [own.off_flange for own in found] == [True]


@pytest.mark.parametrize(
    ("friction", "signs", "withheld"),
    [
        (Friction(), [], False),
        (Friction(refused=remark("no currents")), [], False),
        (Friction(from_=["free"]), [], True),
        (Friction(stopped=remark("wrong constants")), [], True),
        (Friction(), [contradiction("unusable")], True),
    ],
)
def test_a_stop_sign_withholds_the_static_estimate_too(
    friction: Friction, signs: list[Finding], withheld: bool
) -> None:
    assert is_fitted(friction, Contradictions(signs)) == withheld
