"""What the figures of a built study draw, beside what its tables state."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from ur5lib.force.estimators import ESTIMATES, LEADING, UNGATED
from ur5lib.force.sensed_contact import in_contact
from ur5lib.jobs.files import arguments
from ur5lib.records.accelerations import COMPONENTS
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.records.table import WRENCH
from ur5lib.report.figures import traces
from ur5lib.report.figures.house_style import Drawing
from ur5lib.steps.draw_figures import draw_figures
from ur5lib.steps.judge_sensor import saturated
from ur5lib.tables import read_csv, read_record

TABLES = ("signals", "torques", "accelerations", "currents", "kinematics", "sensor", "forces")
JUDGED = ("current_rmse", "torque_mae", "force_mae", "acceleration_mae", "friction")
JUDGED += ("judged_errors",)
ERROR, BAND = "error of ", "95 % band, "


class Drawn:
    """A figure's lines (N, n) by label, without the breaks between segments."""

    def __init__(self, drawing: Drawing, rows: np.ndarray | None = None) -> None:
        data = drawing.data.dropna(subset="time [s]") if len(drawing.data) else drawing.data
        labels = [column.rpartition(", ")[0] for column in data.columns]
        self.lines = {
            label: data.loc[:, [own == label for own in labels]].to_numpy()
            for label in dict.fromkeys(labels)
            if label
        }
        if rows is not None:
            self.lines = {label: line[rows] for label, line in self.lines.items()}

    def error(self, label: str) -> np.ndarray:
        """The error below the line of a label."""
        (own,) = (line for name, line in self.lines.items() if name.startswith(ERROR + label))
        return own


def by_place(rows: pd.DataFrame, value: str, places: list) -> np.ndarray:
    column = "joint" if "joint" in rows else "component"
    return rows.drop_duplicates(column).set_index(column)[value].reindex(places).to_numpy(float)


def check_drawn_numbers(results: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Compare all recordings of a study; return the sections that were compared."""
    monkeypatch.setattr(traces, "decimate", lambda time, values: (time, values))
    study = yaml.safe_load((results / "configuration.yaml").read_text())
    told = {name: read_csv(results / "tables" / f"{name}.csv") for name in JUDGED}
    compared, known = list[str](), study["settings"]
    judged = told["judged_errors"]
    links = judged[judged["question"] == "links"].groupby("robot")
    closest = {arm: {*rows["model"], *rows["rival"].dropna()} for arm, rows in links}
    lowpass = known["lowpass"]["currents"]
    settings = {"lowpass": (lowpass["order"], lowpass["cutoff_hz"]), **known["singularities"]}
    for entry in study["recordings"]:
        name, arm = entry["name"], entry["robot"]
        folder, fitted = results / "recordings" / name, results / "parameters" / arm
        if not (folder / "forces.parquet").is_file():
            continue
        files = {key: str(folder / f"{key}.parquet") for key in TABLES}
        files |= {key: str(fitted / key) for key in ("arm.yaml", "threshold.json")}
        given = arguments(
            draw_figures,
            {Path(key).stem: path for key, path in files.items()},
            {**settings, "role": entry["role"], "gravity": None},
        )
        figures, signals = draw_figures(**given), given["recording"].signals
        own = {
            table: rows[rows["recording"] == name]
            for table, rows in told.items()
            if "recording" in rows
        }
        compared += check_currents(figures["currents"], own["current_rmse"])
        compared += check_torques(
            figures["torques"], own["torque_mae"], ~signals.interpolated, closest.get(arm, set())
        )
        told_by_sensor = ~at_limit(folder, signals)
        compared += check_forces(figures["forces_estimated"], own["force_mae"], told_by_sensor)
        compared += check_accelerations(figures["accelerations"], own["acceleration_mae"])
    for robot, rows in told["friction"].groupby("robot"):
        numbers = results / "figures" / str(robot) / "friction.csv"
        of_arm = {entry["name"] for entry in study["recordings"] if entry["robot"] == robot}
        rmse = told["current_rmse"]
        rmse = rmse[rmse["recording"].isin(of_arm) & (rmse["fitted"] == "yes")]
        compared += check_friction(read_csv(numbers), rows, rmse[rmse["model"] == "fitted"])
    return compared


def check_currents(drawing: Drawing, rows: pd.DataFrame) -> list[str]:
    rows, drawn = rows[rows["model"] == "fitted"], Drawn(drawing)
    if rows.empty:
        return []
    joints = sorted(rows["joint"])
    error = drawn.error("prediction")
    measured = next(line for label, line in drawn.lines.items() if " below " in label)
    rmse = np.sqrt(np.nanmean(error**2, axis=0))
    np.testing.assert_allclose(rmse, by_place(rows, "rmse_lowpassed", joints), rtol=1e-4)
    low, high = (drawn.lines[BAND + edge] for edge in ("lower", "upper"))
    known = np.isfinite(error + low)
    inside = np.where(known, (measured >= low) & (measured <= high), np.nan)
    np.testing.assert_allclose(
        np.nanmean(inside, axis=0), by_place(rows, "coverage95", joints), atol=1e-4
    )
    return ["currents"]


def check_torques(
    drawing: Drawing, rows: pd.DataFrame, received: np.ndarray, compared: set[str]
) -> list[str]:
    """compared: the models of the report's table, which are drawn."""
    if rows.dropna(subset="mae_2hz").empty:
        return []
    drawn = Drawn(drawing, received)
    labels = [label for label in drawn.lines if label.startswith(ERROR)]
    names = [label.removeprefix(ERROR).removeprefix("Model ") for label in labels]
    assert compared <= {name.split(" at the ")[0] for name in names}
    for label, name in zip(labels, names, strict=True):
        model, motion = name.removesuffix(" motion").split(" at the ")
        known = rows[(rows["model"] == model) & (rows["motion"] == motion)]
        mae = np.nanmean(np.abs(drawn.lines[label]), axis=0)
        np.testing.assert_allclose(
            mae, by_place(known, "mae_2hz", sorted(known["joint"])), rtol=1e-4
        )
    return ["torques"]


def at_limit(folder: Path, signals: Signals) -> np.ndarray:
    """Where (N,) a recording's force sensor is saturated."""
    quality = read_record(Quality, folder / "quality.json")
    if signals.force_sensor is None or not (channels := quality.saturated_channels()):
        return np.zeros(len(signals.time), bool)
    return saturated(signals.force_sensor, pd.read_parquet(folder / "force.parquet"), channels)


def check_forces(drawing: Drawing, rows: pd.DataFrame, told: np.ndarray) -> list[str]:
    """told: (N,), where the sensor tells a force."""
    rows = rows[(rows["kind"] == "compensated") & (rows["during"] == "contact")]
    drawn = Drawn(drawing)
    for name in {*rows["estimate"]} & {LEADING, UNGATED}:  # whose errors the report states
        touched = in_contact(np.linalg.norm(drawn.lines["force sensor"][:, :3], axis=1))
        error = (drawn.lines["force sensor"] - drawn.lines[ESTIMATES[name]])[:, :3]
        known = told & touched & np.isfinite(error).all(axis=1)
        mae = np.abs(error[known]).mean(axis=0)
        own = by_place(rows[rows["estimate"] == name], "mae", [*WRENCH[:3]])
        np.testing.assert_allclose(mae, own, rtol=1e-4)
    return ["forces"] if len(rows) else []


def check_accelerations(drawing: Drawing, rows: pd.DataFrame) -> list[str]:
    rows = rows[rows["estimate"] == "encoders"]
    if rows.empty:
        return []
    mae = np.nanmean(np.abs(Drawn(drawing).error("from the joints")), axis=0)
    np.testing.assert_allclose(mae, by_place(rows, "mae", [*COMPONENTS]), rtol=1e-4)
    return ["accelerations"]


def check_friction(numbers: pd.DataFrame, rows: pd.DataFrame, scores: pd.DataFrame) -> list[str]:
    """The curve has the table's parameters, and the band holds what it holds of the recordings."""
    for joint, own in rows.groupby("joint"):
        table = own.set_index("parameter")["value"]
        drawn = numbers.filter(regex=f"joint {joint} ").to_numpy()[:, :4]
        qd, measured, fitted, half = drawn[np.isfinite(drawn).all(axis=1)].T
        root = np.sqrt(np.abs(qd)) * np.sign(qd) - 4 / 15 * np.sign(qd) - 4 / 5 * qd
        dry = fitted - table["viscous"] * qd - table.get("velocity_root", 0.0) * root
        dry = np.sign(qd) * (dry - table.get("velocity_square", 0.0) * np.abs(qd) * qd)
        least = table["coulomb"] + min(0.0, table["load"]) * 100
        assert np.ptp(dry) <= 1e-4 * np.abs(fitted).max()
        assert (dry >= least - 1e-4).all()
        held = scores.loc[scores["joint"] == joint, "coverage95"].mean()
        assert np.mean(np.abs(measured - fitted) <= half) == pytest.approx(held, abs=0.05)
    return ["friction"] if len(rows) else []
