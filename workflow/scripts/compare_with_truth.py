"""Estimates from simulated recordings against the truth, which no other step reads."""

from typing import Any

import pandas as pd

from ur5lib.records.truth import COLUMNS, TrueParameters
from ur5lib.report.truth_rows import arm_rows, recording_rows
from ur5lib.tables import read_record, write_csv
from ur5lib.timeseries.lowpass import Butterworth

OF_ARMS = ("described", "fitted", "rotors", "identification", "calibration", "friction")
OF_RECORDINGS = ("truth", "clocks", "motion", "fused", "accelerations", "forces")


def compare_with_truth(input: Any, output: Any, params: Any) -> None:
    known = [read_record(TrueParameters, path) for path in input.truth_summary]
    truths = dict(zip(params.recordings, known, strict=True))
    arms = {
        robot: {name: input[name][k] for name in OF_ARMS} for k, robot in enumerate(params.robots)
    }
    rows = [
        {"robot": robot} | row
        for robot, files in arms.items()
        for row in arm_rows(files, {n: t for n, t in truths.items() if t.robot == robot})
    ]
    design = Butterworth(params.order, params.cutoff_hz)
    for k, (name, truth) in enumerate(truths.items()):
        files = arms[truth.robot] | {own: input[own][k] for own in OF_RECORDINGS}
        about = {"recording": name, "robot": truth.robot}
        rows += [about | row for row in recording_rows(files, truth, design)]
    write_csv(pd.DataFrame(rows, columns=COLUMNS), output.truth)
