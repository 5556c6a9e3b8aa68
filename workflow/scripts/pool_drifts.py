"""The drift of each host, from contact-free recordings with a clock estimated by motion."""

from typing import Any

from ur5lib.signals.clock import OwnClock
from ur5lib.signals.clock import pool_drifts as pool
from ur5lib.tables import read_record, write_json


def pool_drifts(input: Any, output: Any, params: Any) -> None:
    own = [read_record(dict[str, OwnClock], path) for path in input.clocks]
    clocks = dict(zip(params.recordings, own, strict=True))
    write_json(pool(clocks, params.hosts), output.drifts)
