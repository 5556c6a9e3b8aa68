"""Figures of one recording, after the thesis's 5.11, 5.12 and 6.4 to 6.9."""

from typing import Any

import numpy as np
import pandas as pd

from ur5lib.report.figures import joint_panels, save, wrench_panels
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_table

COMPONENTS = ["Fx", "Fy", "Fz", "nx", "ny", "nz"]
LABELS = {"Fu": "controller's estimate", "F": "without friction", "F*": "with friction"}


def draw_figures(input: Any, output: Any, params: Any) -> None:
    signals, torques = read_table(input.signals), read_table(input.torques)
    draw_torques(signals, torques, output)
    forces = read_table(input.forces)
    for kind in ("printed", "corrected"):
        draw_forces(forces, kind, output)


def draw_torques(signals: pd.DataFrame, torques: pd.DataFrame, output: Any) -> None:
    """Figures 5.11 and 5.12: Model C against the controller's model."""
    time = unbroken(signals, signals["time"].to_numpy())
    moment = unbroken(signals, channel(signals, "target_moment"))
    model = unbroken(signals, channel(torques, "tau_target_C"))
    values = {"controller's target_moment": (moment, "measured"), "Model C": (model, "first")}
    save(joint_panels(time, values, r"\tau"), output.torques)
    error = {"target_moment − Model C": (moment - model, "measured")}
    save(joint_panels(time, error, r"\Delta\tau"), output.torque_errors)


def draw_forces(forces: pd.DataFrame, kind: str, output: Any) -> None:
    """Figures 6.4 and 6.5, 6.6 and 6.7, 6.8 and 6.9."""

    def wrench(name: str) -> Any:
        return unbroken(forces, forces[[f"{kind}_{name}_{c}" for c in COMPONENTS]].to_numpy())

    time = unbroken(forces, forces["time"].to_numpy())
    sensor = {"force sensor": (wrench("sensor"), "measured")}
    fu, f, f_star = (wrench(name) for name in LABELS)
    styles = {"Fu": (fu, "first"), "F": (f, "second"), "F*": (f_star, "third")}
    series = {LABELS[name]: style for name, style in styles.items()}
    without = sensor | {LABELS[name]: styles[name] for name in ("F", "Fu")}
    with_friction = sensor | {LABELS["F*"]: styles["F*"]}
    reference = sensor["force sensor"][0]
    errors = {label: (reference - values, style) for label, (values, style) in series.items()}
    save(wrench_panels(time, without), output[f"forces_{kind}"])
    save(wrench_panels(time, with_friction), output[f"forces_friction_{kind}"])
    save(wrench_panels(time, errors, r"\Delta "), output[f"force_errors_{kind}"])


def unbroken(table: pd.DataFrame, values: Any) -> Any:
    """Values with NaN between segments, so that no line is drawn across a gap."""
    breaks = np.flatnonzero(np.diff(table["segment"])) + 1
    return np.insert(values, breaks, np.nan, axis=0)


if __name__ == "__main__":
    run_step(draw_figures, snakemake)  # type: ignore[name-defined]  # noqa: F821
