"""The study's tables of results, from what every recording and every arm came to."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import pandas as pd

from ur5lib.report.current_tables import (
    ablation_rows,
    contact_rows,
    cross_validation_rows,
    current_rows,
    detection_rows,
    friction_rows,
    payload_rows,
    remark_rows,
)
from ur5lib.report.identification_tables import (
    closed_loop_errors,
    excitation_rows,
    gain_rows,
    parameter_rows,
    published_gain_rows,
    rotor_rows,
)
from ur5lib.report.motion_tables import acceleration_errors, calibration_rows, innovation_rows
from ur5lib.report.reference import Printed, read_reference
from ur5lib.report.result_tables import (
    clock_table,
    contact_error_rows,
    file_table,
    force_errors,
    quality_table,
    recording_table,
    torque_errors,
)
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import read_json, read_table, write_csv

COLUMNS = {
    "torque_mae": "recording motion model joint mae printed zero_mae",
    "closed_loop_mae": "recording model joint quantity mae printed",
    "gains": "recording joint gain unit value std_error low high determined",
    "published_gains": "recording model joint cost least_cost limit fits",
    "rotor_inertia": "joint value std_error offset offset_std_error coulomb coulomb_std_error "
    "viscous viscous_std_error robot",
    "parameters": "robot parameter value std_error determined",
    "acceleration_mae": "recording estimate component mae printed zero_mae",
    "excitation": "robot combinations undetermined gravity inertia rotors all advice",
    "imu_calibration": "robot quantity axis unit value std_error",
    "innovations": "recording estimate channel variance variance_low variance_high portmanteau "
    "portmanteau_limit consistent white",
    "friction": "joint parameter value std_error prior_share thesis low high determined robot",
    "remarks": "robot step joint remark",
    "current_rmse": "model recording fitted joint rmse rmse_2hz mae r2 coverage95",
    "cross_validation": "robot fitted_on tested_on joint rmse_2hz",
    "payload": "recording mass std_error low high center_of_mass_x center_of_mass_y "
    "center_of_mass_z configured taken",
    "force_mae": "recording kind estimate during component mae max zero_mae zero_max mean_force "
    "slope skill correlation coverage50 coverage80 coverage95 interval_score95 "
    "zero_interval_score95 mae_low mae_high skill_low determined printed_mae printed_max",
    "contact_errors": "recording estimate contact start_s end_s component peak peak_error impulse "
    "impulse_error onset_error_s",
    "ablation": "recording variant component mae coverage95 interval_score95",
    "contacts": "recording estimate start_s end_s peak_s Fx Fx_std Fy Fy_std Fz Fz_std "
    "kind load_mass load_mass_std",
    "detection": "recording estimate force_class_n contacts found precision recall "
    "false_alarms_per_min extra_alarms time_in_alarm free_time_in_alarm median_delay_s "
    "causal_delay_s smallest_force_95_x smallest_force_95_y smallest_force_95_z alarms "
    "alarms_per_min roc_area",
}

Rows = Iterable[Mapping[str, object]]


def make_tables(input: Any, output: Any, params: Any) -> None:
    printed = read_reference(input.get("reference")).printed
    clocks = dict(zip(params.recordings, map(read_json, input.clocks), strict=True))
    qualities = dict(zip(params.recordings, map(read_json, input.quality), strict=True))
    write_csv(recording_table(qualities), output.recordings)
    write_csv(file_table(qualities), output.files)
    forces = dict(zip(params.recordings, map(read_json, input.forces), strict=True))
    write_csv(quality_table(qualities, clocks, forces), output.quality)
    write_csv(clock_table(clocks), output.clocks)
    rows = recording_rows(input, params.recordings, printed) | arm_rows(input, params.robots)
    ablations = zip(params.touched, map(read_json, input.ablation), strict=True)
    rows["ablation"] = [row for pair in ablations for row in ablation_rows(*pair)]
    for name, table in rows.items():
        write_csv(pd.DataFrame(table, columns=COLUMNS[name].split()), output[name])


def recording_rows(input: Any, recordings: list[str], printed: Printed) -> dict[str, Rows]:
    """Rows of the tables that are about recordings."""
    loops = {"q": printed.closed_loop_q, "qd": printed.closed_loop_qd}

    def each(rows: Callable[..., Rows], *sources: Any, **settings: Any) -> Rows:
        """What a function makes of each recording's files, which are read as they are needed."""
        for recording, *paths in zip(recordings, *sources, strict=True):
            yield from rows(recording, *map(read, paths), **settings)

    return {
        "torque_mae": each(torque_errors, input.torques, input.signals, printed=printed.torque_mae),
        "closed_loop_mae": each(
            closed_loop_errors, input.closed_loop, input.signals, printed=loops
        ),
        "gains": each(gain_rows, input.gains),
        "published_gains": each(published_gain_rows, input.gains),
        "acceleration_mae": each(
            acceleration_errors, input.accelerations, printed=printed.acceleration_mae
        ),
        "innovations": each(innovation_rows, input.motion),
        "current_rmse": each(current_rows, input.currents),
        "payload": each(payload_rows, input.currents),
        "detection": each(detection_rows, input.detection),
        "contacts": each(contact_rows, input.detection),
        "contact_errors": each(contact_error_rows, input.forces),
        "force_mae": each(
            force_errors,
            input.forces,
            printed_mae=printed.force_mae,
            printed_max=printed.force_max,
        ),
    }


def arm_rows(input: Any, robots: list[str]) -> dict[str, Rows]:
    """Rows of the tables that are about arms."""
    tables: dict[str, Any] = {}
    for robot, arm, *paths in zip(
        robots,
        input.arm,
        input.rotors,
        input.identification,
        input.calibration,
        input.friction,
        input.residuals,
        strict=True,
    ):
        rotors, identification, calibration, friction, residuals = map(read_json, paths)
        steps = {
            "identification": identification,
            "friction": friction,
            "contact forces": residuals,
        }
        found = {
            "rotor_inertia": rotor_rows(robot, rotors),
            "parameters": parameter_rows(robot, identification),
            "excitation": excitation_rows(robot, identification),
            "imu_calibration": calibration_rows(robot, calibration),
            "friction": friction_rows(robot, load_robot(arm), friction),
            "cross_validation": cross_validation_rows(robot, friction),
            "remarks": remark_rows(robot, steps),
        }
        for name, rows in found.items():
            tables.setdefault(name, []).extend(rows)
    return tables


def read(path: str) -> Any:
    """A table of signals or a summary."""
    return read_json(path) if path.endswith(".json") else read_table(path)


if __name__ == "__main__":
    run_step(make_tables, snakemake)  # type: ignore[name-defined]  # noqa: F821
