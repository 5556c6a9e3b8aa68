"""The drift of each host, from contact-free recordings with a clock estimated by motion."""

from dataclasses import asdict
from typing import Any

from ur5lib.signals.host_drifts import pool_drifts as pool
from ur5lib.tables import read_json, write_json


def pool_drifts(input: Any, output: Any, params: Any) -> None:
    clocks = dict(zip(params.recordings, map(read_json, input.clocks), strict=True))
    drifts = pool(clocks, params.hosts)
    write_json({host: asdict(drift) for host, drift in drifts.items()}, output.drifts)
