"""Threshold on the odds of contact, with few alarms in contact-free recordings."""

from typing import Any

from ur5lib.force.detection import alarm_threshold
from ur5lib.pipeline.estimates import GATED
from ur5lib.pipeline.records.forces import Forces
from ur5lib.tables import write_json


def set_threshold(input: Any, output: Any, params: Any) -> None:
    recordings = [Forces.read(path) for path in input.forces]
    thresholds = {}
    for name in sorted(GATED):
        known = [forces for forces in recordings if name in forces.log_odds]
        if known:
            odds, periods = zip(*((own.log_odds[name], own.period) for own in known), strict=True)
            rate = params.false_alarms_per_min
            thresholds[name] = alarm_threshold([*odds], [*periods], rate)
    write_json(thresholds, output.threshold)
