"""Which contact-free runs an arm has: what each carries, where it passes, and its files."""

from pathlib import Path
from typing import Any

from ur5lib.pipeline.records.prediction import FreeRun, Prediction
from ur5lib.tables import read_record, write_json

KINDS = ("currents", "motion")


def index_free_runs(input: Any, output: Any, params: Any) -> None:
    index = {}
    for name, path in zip(params.recordings, input.currents, strict=True):
        run = read_record(Prediction, path)
        if run.extent is not None:
            files = [str(Path(path).with_name(f"{kind}.parquet")) for kind in KINDS]
            index[name] = FreeRun(run.load, run.extent, *files)
    write_json(index, output.index)
