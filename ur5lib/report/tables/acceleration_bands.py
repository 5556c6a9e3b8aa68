"""Whether the end effector's acceleration by encoders lies within its band about the IMU's."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ur5lib.report.study_results import Row, StudyResults
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

COLUMNS = [
    "recording",
    "range",
    "during",
    "component",
    "unit",
    "rms",
    "std",
    "held",
    "filterpy_rms",
]

COMPONENTS = {"x": "m/s2", "y": "m/s2", "z": "m/s2", "rx": "rad/s2", "ry": "rad/s2", "rz": "rad/s2"}


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    summaries = results.all("accelerations")
    for name, summary in summaries.items():
        others = [summaries[other] for other in summary.get("calibrated_on", ()) if other != name]
        yield from band_rows(name, summary, [other for other in others if "ranges" in other])


def band_rows(
    recording: str, summary: Mapping[str, Any], others: list[Mapping[str, Any]]
) -> Iterator[Row]:
    """Yield rows of a recording: its differences from the IMU, the share within the band that the
    other recordings show for the same range of frequency, in motion or at rest, and the differences
    of filterpy's plain filter.

    The band counts all errors of both: noise of encoders and IMU, its calibration, and links that
    bend between them. No rows without another recording.
    """
    for name, states in summary.get("ranges", {}).items():
        for state, found in states.items():
            known = [part for other in others if (part := other["ranges"].get(name, {}).get(state))]
            if not known:
                continue
            std = np.sqrt(np.mean([part["square"] for part in known], axis=0))
            plain = summary["plain_ranges"][name][state]["square"]
            held = _held(np.array(found["quantiles"]), NORMAL95 * std)
            for index, (component, unit) in enumerate(COMPONENTS.items()):
                yield {
                    "recording": recording,
                    "range": name,
                    "during": state,
                    "component": component,
                    "unit": unit,
                    "rms": float(np.sqrt(found["square"][index])),
                    "std": float(std[index]),
                    "held": float(held[index]),
                    "filterpy_rms": float(np.sqrt(plain[index])),
                }


def _held(quantiles: Array, limits: Array) -> Array:
    """Return the shares (6,) within limits (6,) of absolute values with quantiles (101, 6)."""
    levels = np.linspace(0, 1, len(quantiles))
    return np.array(
        [np.interp(x, column, levels) for x, column in zip(limits, quantiles.T, strict=True)]
    )
