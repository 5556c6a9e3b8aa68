"""The steps of the force estimates, on made-up torques: loads, templates, rates, alarms."""

from dataclasses import asdict, dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest
import torch

from tests.library.current_study import make_record, prior, smooth, with_noise
from tests.library.made_up_torques import MODEL, Free, between, free_run
from tests.scripts.conftest import script
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.regressor import regressor
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.force.external_torque import MOVING
from ur5lib.force.residual_model import ResidualModel, few_paths
from ur5lib.identification.currents import breakaway_torque, fit_currents
from ur5lib.robots.description import Payload, Robot
from ur5lib.tables import WRENCH, channel, named, read_json, read_table, write_json, write_table

PERIOD = 0.016
LINK_6 = slice(50, 54)
BARE = {"carried": 0.0, "std_error": 0.05}
LOADED = {"carried": 2.7, "std_error": 0.05}
SETTINGS = SimpleNamespace(cutoff_hz=2.0, contact_force_n=15.0, role="contact")


@dataclass(frozen=True)
class Recording:
    """A recording's tables in a folder of its own."""

    folder: Path

    def __getattr__(self, name: str) -> str:
        suffix = "json" if name in {"load", "residuals", "threshold", "detection"} else "parquet"
        return str(self.folder / f"{name}.{suffix}")

    def write(self, run: Free, load: dict[str, float] | None = None) -> "Recording":
        """What estimate_forces reads of it."""
        self.folder.mkdir(parents=True, exist_ok=True)
        base = {"time": run.time, "segment": np.zeros(len(run.time), int)}
        tables = {
            "motion": named(run.q, "q") | named(run.qd, "qd"),
            "currents": named(run.torque, "tau_ext")
            | named(run.torque, "tau_observer")
            | named(np.zeros_like(run.torque), "load_doubt"),
            "kinematics": named(run.jacobian.reshape(-1, 36), "J"),
            "sensor": {},
        }
        for name, columns in tables.items():
            write_table(pd.DataFrame(base | columns), getattr(self, name))
        write_json({"load": load}, self.load)
        write_json({name: MODEL.to_dict() for name in ("tau_ext", "tau_observer")}, self.residuals)
        return self

    def estimate(self, *others: "Recording") -> pd.DataFrame:
        """What estimate_forces makes of it, beside other contact-free recordings."""
        input = SimpleNamespace(
            motion=self.motion,
            residuals=self.residuals,
            kinematics=self.kinematics,
            currents=self.currents,
            load=self.load,
            free_currents=[other.currents for other in others],
            free_motion=[other.motion for other in others],
            free_loads=[other.load for other in others],
        )
        script("estimate_forces").estimate_forces(input, self, SETTINGS)
        return read_table(self.forces)


def estimates(forces: pd.DataFrame) -> set[str]:
    return {name.removesuffix("_Fx") for name in forces.filter(regex="^[^_]*_Fx$")}


# Which runs may be the template of which


@pytest.mark.parametrize(
    ("own", "other", "alike"),
    [
        (BARE, BARE, True),
        (BARE, LOADED, False),
        (LOADED, LOADED, True),
        (BARE, None, False),
        (None, None, False),
        ({"carried": 0.0, "std_error": 1.0}, LOADED | {"std_error": 1.0}, True),  # not told apart
        ({"carried": 0.0, "std_error": 0.0}, {"carried": 0.0, "std_error": 0.0}, True),
    ],
)
def test_runs_are_alike_that_may_carry_the_same(
    tmp_path: Path, own: Any, other: Any, alike: bool
) -> None:
    paths = [str(tmp_path / "own.json"), str(tmp_path / "other.json")]
    for path, load in zip(paths, (own, other), strict=True):
        write_json({"load": load}, path)
    same_load = script("estimate_forces").same_load
    assert same_load(*paths) == same_load(*paths[::-1]) == alike


def test_a_recording_without_currents_tells_no_load(tmp_path: Path) -> None:
    for name in ("own", "other"):
        write_json({"fitted": False, "scores": {}}, tmp_path / name)
    assert not script("estimate_forces").same_load(tmp_path / "own", tmp_path / "other")


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
    states = [torch.from_numpy(state.copy()) for state in (run.q, run.qd, qdd)]
    arms = [build_arm(ur5.carrying(carried), "C") for carried in (payload, None)]
    loaded, bare = (inverse_dynamics(arm, *states).numpy() for arm in arms)
    return bare - loaded


def test_a_template_is_of_the_same_payload(weighty: tuple[Free, Free], tmp_path: Path) -> None:
    """The only other run of its path carried 2.7 kg: an unloaded arm that nothing touches."""
    bare, loaded = weighty
    own = Recording(tmp_path / "own").write(bare, BARE)
    alike = Recording(tmp_path / "alike").write(bare, BARE)
    heavy = Recording(tmp_path / "heavy").write(loaded, LOADED)
    forces = own.estimate(heavy)
    assert estimates(forces) == {"Fmap", "observer"}
    for name in ("Fmap", "observer"):
        assert forces[f"log_odds_{name}"].max() < 0
        assert np.abs(forces[[f"{name}_{c}" for c in WRENCH[:3]]].to_numpy()).max() < 0.5
    assert estimates(own.estimate(alike)) == {"Fmap", "observer", "repeat"}
    both = own.estimate(heavy, alike)
    alone = own.estimate(alike)
    pd.testing.assert_frame_equal(both, alone)  # the loaded one has no part in it
    assert estimates(heavy.estimate(own)) == {"Fmap", "observer"}


def test_every_estimate_has_its_band_and_its_odds(
    weighty: tuple[Free, Free], tmp_path: Path
) -> None:
    bare, _ = weighty
    forces = Recording(tmp_path).write(bare, BARE).estimate()
    for name in ("Fmap", "observer"):
        wanted = [*WRENCH, *(f"std_{component}" for component in WRENCH)]
        assert {f"{name}_{part}" for part in wanted} <= {*forces}
        assert {f"log_odds_{name}", f"causal_log_odds_{name}"} <= {*forces}
    assert {f"least_squares_{c}" for c in WRENCH} <= {*forces}
    assert channel(forces, "tau_background").shape == (len(bare.time), 6)
    assert np.isfinite(forces.to_numpy()).all()


# What the arm carries


def carried_load(tmp_path: Path, **given: Any) -> tuple[dict[str, Any] | None, np.ndarray]:
    """What predict_currents makes of payload.json; Y is that of a weight on joint 2."""
    found = {"parameters": [2.0, 0.1, 0.0, 0.0], "std_error": [0.05] * 4, "parts": [2.0] * 3}
    found = given.get("found", found)
    known = {"source": "none", "payload": None, "told": None} | given.get("known", {})
    unloaded = given.get("unloaded", [{"parameters": [0.05] * 4, "std_error": [0.05] * 4}])
    columns = np.zeros((5, 6, 4))
    columns[:, 1, 0] = 7.0
    table = pd.DataFrame({"time": np.arange(5)} | named(columns.reshape(5, 24), "load_regressor"))
    write_table(table, tmp_path / "regressor.parquet")
    names = [str(tmp_path / f"unloaded_{i}.json") for i in range(len(unloaded))]
    for name, own in zip(names, unloaded, strict=True):
        write_json(own, name)
    write_json(found, tmp_path / "payload.json")
    write_json(known, tmp_path / "load.json")
    input = SimpleNamespace(
        regressor=str(tmp_path / "regressor.parquet"),
        payload=str(tmp_path / "payload.json"),
        load=str(tmp_path / "load.json"),
        unloaded=names,
    )
    params = SimpleNamespace(role=given.get("role", "validate"))
    result: tuple[dict[str, Any] | None, np.ndarray] = script("predict_currents").carried_load(
        input, params, {"paths": given.get("paths", 5)}
    )
    return result


def test_a_load_that_is_certain_is_taken_into_the_prediction(tmp_path: Path) -> None:
    load, torque = carried_load(tmp_path)
    assert load is not None
    assert load["taken"]
    assert load["carried"] == load["mass"] == 2.0
    np.testing.assert_allclose(torque, np.tile([0, 14.0, 0, 0, 0, 0], (5, 1)))
    np.testing.assert_allclose(load["center_of_mass"], [0.05, 0, 0])


@pytest.mark.parametrize(
    "given",
    [
        {"role": "fit"},  # its payload is taken as it is told
        {"known": {"source": "study", "payload": {"mass": 1.0}}},  # and so is a declared one
        {
            "unloaded": [{"parameters": [1.0] * 4, "std_error": [0.05] * 4}]
        },  # bare runs seem to, too
        {
            "found": {
                "parameters": [2.0, 0, 0, 0],
                "std_error": [0.05] * 4,
                "parts": [4.0, 2.0, 0.0],
            }
        },
    ],
)
def test_a_load_is_not_taken_where_it_is_told_or_uncertain(
    tmp_path: Path, given: dict[str, Any]
) -> None:
    load, torque = carried_load(tmp_path, **given)
    assert load is not None
    assert not load["taken"]
    assert (torque == 0).all()


def test_what_the_controller_was_told_counts_as_carried(tmp_path: Path) -> None:
    """RTDE says 1 kg, 2 kg hang there beside it."""
    told = {"source": "rtde", "payload": {"mass": 1.0}, "told": {"mass": 1.0}}
    load, torque = carried_load(tmp_path, known=told)
    assert load is not None
    assert (load["configured"], load["carried"], load["taken"]) == (1.0, 3.0, True)
    assert np.abs(torque).max() == pytest.approx(14.0)


def test_at_rest_no_load_is_told(tmp_path: Path) -> None:
    load, torque = carried_load(tmp_path, found={})
    assert load is None
    assert torque.shape == (5, 6)
    assert (torque == 0).all()


def test_without_unloaded_runs_the_mass_stands_alone(tmp_path: Path) -> None:
    """No recording to fit on moves: nothing tells how far runs differ."""
    load, _ = carried_load(tmp_path, unloaded=[{}])
    assert load is not None
    assert np.isfinite(load["std_error"])


# What is left without contact


@pytest.fixture(scope="module")
def friction() -> dict[str, Any]:
    records = [with_noise(make_record(seed, seconds=10.0), seed) for seed in range(2)]
    return {"from": ["a", "b"], "fit": asdict(fit_currents(records, smooth, prior(), ()))}


def fit_residuals(
    tmp_path: Path, friction: dict[str, Any], paths: int, *runs: Free
) -> dict[str, Any]:
    recordings = [Recording(tmp_path / f"{i}").write(run) for i, run in enumerate(runs)]
    write_json(friction | {"paths": paths}, tmp_path / "friction.json")
    input = SimpleNamespace(
        friction=tmp_path / "friction.json",
        currents=[own.currents for own in recordings],
        motion=[own.motion for own in recordings],
    )
    output = SimpleNamespace(residuals=tmp_path / "residuals.json")
    script("fit_residuals").fit_residuals(input, output, SETTINGS)
    result: dict[str, Any] = read_json(output.residuals)
    return result


def test_residuals_of_few_paths_are_wider(
    ur5: Robot, friction: dict[str, Any], tmp_path: Path
) -> None:
    runs = [free_run(ur5, seed, period=PERIOD) for seed in (1, 2)]
    found = {paths: fit_residuals(tmp_path, friction, paths, *runs) for paths in (1, 2, 5)}
    models = {
        paths: ResidualModel.from_dict(summary["tau_ext"]) for paths, summary in found.items()
    }
    ratio = models[2].spread / models[5].spread
    np.testing.assert_allclose(ratio, few_paths(2) / few_paths(5))
    np.testing.assert_array_equal(models[1].spread, models[2].spread)
    (remark,) = found[1]["remarks"]
    assert "of one path" in remark
    assert "record another path" in remark
    assert "remarks" not in found[2]
    assert {"tau_ext", "tau_observer"} <= found[5].keys()
    assert (models[5].breakaway > 0).all()


def test_recordings_of_several_rates_leave_the_same(
    ur5: Robot, friction: dict[str, Any], tmp_path: Path
) -> None:
    """One recording at 250 Hz, and one of four of its samples; then both together."""
    often = free_run(ur5, 3, seconds=40, period=0.004)
    seldom = Free(*(values[::4] for values in vars(often).values()))
    spreads = [
        ResidualModel.from_dict(fit_residuals(tmp_path, friction, 5, *runs)["tau_ext"])
        for runs in ([often], [seldom], [often, seldom], [seldom, often])
    ]
    for other in spreads[1:]:
        for name in ("spread", "change"):
            own, reference = (getattr(model, name)[MOVING] for model in (other, spreads[0]))
            np.testing.assert_allclose(own, reference, rtol=0.03)


def test_a_joint_that_never_moves_is_refused(
    ur5: Robot, friction: dict[str, Any], tmp_path: Path
) -> None:
    run = free_run(ur5, 4, period=PERIOD)
    qd = run.qd * [1, 1, 1, 1, 1, 0]
    found = fit_residuals(tmp_path, friction, 5, Free(**vars(run) | {"qd": qd}))
    assert "moves joint 6" in found["refused"]
    assert "tau_ext" not in found


def test_without_a_fit_there_are_no_residuals(tmp_path: Path) -> None:
    assert fit_residuals(tmp_path, {"from": []}, 0) == {}


def test_breakaway_is_the_friction_of_the_fit(
    ur5: Robot, friction: dict[str, Any], tmp_path: Path
) -> None:
    records = [with_noise(make_record(seed, seconds=10.0), seed) for seed in range(2)]
    expected = breakaway_torque(fit_currents(records, smooth, prior(), ()))
    found = fit_residuals(tmp_path, friction, 5, free_run(ur5, 1, period=PERIOD))
    np.testing.assert_allclose(found["tau_ext"]["breakaway"], expected)


# Alarms


def test_a_threshold_counts_minutes_of_mixed_rates(tmp_path: Path) -> None:
    """Causal odds are no estimate of their own."""
    paths = []
    for period, peaks in ((0.002, [2.0, 4.0, 6.0]), (0.01, [3.0, 5.0, 7.0])):
        odds = np.full(round(60 / period), -5.0)
        odds[[round(second / period) for second in (10, 30, 50)]] = peaks
        columns = {"log_odds_Fmap": odds, "causal_log_odds_Fmap": odds + 90}
        if not paths:
            columns["log_odds_observer"] = odds + 1
        table = pd.DataFrame({"time": period * np.arange(len(odds))} | columns)
        paths.append(str(tmp_path / f"{len(paths)}.parquet"))
        write_table(table, paths[-1])
    input = SimpleNamespace(forces=paths)
    output = SimpleNamespace(threshold=tmp_path / "threshold.json")
    params = SimpleNamespace(false_alarms_per_min=1)
    script("set_threshold").set_threshold(input, output, params)
    found = read_json(output.threshold)
    assert found.keys() == {"Fmap", "observer"}
    assert 5.0 < found["Fmap"] < 5.01  # two minutes allow two alarms: 6 and 7
    assert 5.0 < found["observer"] < 5.01  # one minute allows one: 7


def detect(recording: Recording, run: Free, ur5: Robot) -> list[dict[str, Any]]:
    """What detect_contacts raises of F̂ᵐᵃᵖ."""
    qdd = np.gradient(run.qd, run.time, axis=0)
    states = [torch.from_numpy(state.copy()) for state in (run.q, run.qd, qdd)]
    per_load = regressor(build_arm(ur5, "C"), *states).numpy()[:, :, LINK_6]
    columns = named(per_load.reshape(len(per_load), -1), "load_regressor")
    write_table(pd.DataFrame({"time": run.time} | columns), recording.regressor)
    write_json({"Fmap": 0.0}, recording.threshold)
    recording.write(run, BARE).estimate()
    script("detect_contacts").detect_contacts(recording, recording, SETTINGS)
    raised: list[dict[str, Any]] = read_json(recording.detection)["Fmap"]["raised"]
    return raised


@pytest.mark.parametrize("mass", [2.0, 4.0])
def test_a_load_picked_up_on_the_way_is_named(ur5: Robot, tmp_path: Path, mass: float) -> None:
    """From 8 s on, at whatever the gears pass on of it."""
    run = free_run(ur5, 5, seconds=18, period=PERIOD, scale=0.2)
    taken = 0.95 * load_torque(ur5, run, mass) * between(run.time, 8.0, 99.0)[:, None]
    loaded = Free(**vars(run) | {"torque": run.torque + taken})
    found = detect(Recording(tmp_path), loaded, ur5)
    (load,) = [own for own in found if own["kind"] == "load"]
    assert load["load_mass"] == pytest.approx(mass, rel=0.1)
    assert load["start"] == pytest.approx(8.0, abs=0.5)
    assert load["end"] > 17


def test_a_push_is_no_load(ur5: Robot, tmp_path: Path) -> None:
    run = free_run(ur5, 6, seconds=16, period=PERIOD, scale=0.2)
    force = 40.0 * between(run.time, 6.0, 11.0)[:, None] * np.array([[0.6, 0.8, 0.0]])
    found = detect(Recording(tmp_path), run.pushed(run.wrench(force)), ur5)
    assert [own["kind"] for own in found] == ["contact"]
    assert np.linalg.norm(found[0]["force"]) == pytest.approx(40, rel=0.25)
