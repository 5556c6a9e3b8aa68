"""Which contact-free runs an arm has: what each carries, where it passes, and its files."""

from pathlib import Path
from typing import Any

from ur5lib.tables import read_json, write_json

KINDS = ("currents", "motion")


def index_free_runs(input: Any, output: Any, params: Any) -> None:
    index = {}
    for name, path in zip(params.recordings, input.currents, strict=True):
        summary = read_json(path)
        if summary.get("extent"):
            files = {kind: str(Path(path).with_name(f"{kind}.parquet")) for kind in KINDS}
            index[name] = {"load": summary["load"], "extent": summary["extent"], **files}
    write_json(index, output.index)
