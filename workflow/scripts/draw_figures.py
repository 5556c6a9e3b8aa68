"""Figures of one recording, after the thesis's 5.11, 5.12 and 6.4 to 6.9."""

from typing import Any

import numpy as np
import pandas as pd

from ur5lib.report.figures import joint_panels, save, wrench_panels
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_table

COMPONENTS = ["Fx", "Fy", "Fz", "nx", "ny", "nz"]
LABELS = {
    "sensor": "force sensor",
    "Fu": "controller's estimate",
    "F": "without friction",
    "F*": "with friction",
}
STYLES = {"sensor": "measured", "Fu": "first", "F": "second", "F*": "third"}


def draw_figures(input: Any, output: Any, params: Any) -> None:
    signals, torques = read_table(input.signals), read_table(input.torques)
    draw_torques(signals, torques, load_robot(input.arm).chosen_model, output)
    forces = read_table(input.forces)
    for kind in ("printed", "corrected"):
        draw_forces(forces, kind, output)


def draw_torques(signals: pd.DataFrame, torques: pd.DataFrame, model: str, output: Any) -> None:
    """Figures 5.11 and 5.12: the chosen model against the controller's."""
    time = unbroken(signals, signals["time"].to_numpy())
    motion = "target" if f"tau_target_{model}_0" in torques else "measured"
    modelled = unbroken(signals, channel(torques, f"tau_{motion}_{model}"))
    values = {f"Model {model}, {motion} motion": (modelled, "first")}
    error = {}
    if "target_moment_0" in signals:
        moment = unbroken(signals, channel(signals, "target_moment"))
        values = {"controller's target_moment": (moment, "measured")} | values
        error = {f"target_moment − Model {model}": (moment - modelled, "measured")}
    save(joint_panels(time, values, r"\tau"), output.torques)
    save(joint_panels(time, error, r"\Delta\tau"), output.torque_errors)


def draw_forces(forces: pd.DataFrame, kind: str, output: Any) -> None:
    """Figures 6.4 and 6.5, 6.6 and 6.7, 6.8 and 6.9."""

    def wrenches(*names: str) -> dict[str, Any]:
        columns = {name: [f"{kind}_{name}_{c}" for c in COMPONENTS] for name in names}
        return {
            LABELS[name]: (unbroken(forces, forces[wanted].to_numpy()), STYLES[name])
            for name, wanted in columns.items()
            if wanted[0] in forces
        }

    time = unbroken(forces, forces["time"].to_numpy())
    reference = wrenches("sensor")[LABELS["sensor"]][0]
    errors = {
        label: (reference - values, style)
        for label, (values, style) in wrenches("Fu", "F", "F*").items()
    }
    save(wrench_panels(time, wrenches("sensor", "F", "Fu")), output[f"forces_{kind}"])
    save(wrench_panels(time, wrenches("sensor", "F*")), output[f"forces_friction_{kind}"])
    save(wrench_panels(time, errors, r"\Delta "), output[f"force_errors_{kind}"])


def unbroken(table: pd.DataFrame, values: Any) -> Any:
    """Values with NaN between segments, so that no line is drawn across a gap."""
    breaks = np.flatnonzero(np.diff(table["segment"])) + 1
    return np.insert(values, breaks, np.nan, axis=0)


if __name__ == "__main__":
    run_step(draw_figures, snakemake)  # type: ignore[name-defined]  # noqa: F821
