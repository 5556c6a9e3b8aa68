"""Whether the smoother's innovations are as wide as stated, and white."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "estimate",
    "channel",
    "variance",
    "variance_low",
    "variance_high",
    "portmanteau",
    "portmanteau_limit",
    "consistent",
    "white",
    "colour",
]

CHANNELS = [f"q_{joint}" for joint in range(1, 7)] + [f"qd_{joint}" for joint in range(1, 7)]
CHANNELS += [f"imu_{sensor}{axis}" for sensor in "ag" for axis in "xyz"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    fused = results.all("fused")
    for name, summary in results.each("motion"):
        yield from innovation_rows(name, summary | fused[name])


def innovation_rows(recording: str, summary: Mapping[str, Any]) -> Iterator[Row]:
    """Whether the smoother's innovations are as wide as stated, and white, from motion.json."""
    for estimate, account in summary.items():
        test = account["innovations"]
        for index, channel in enumerate(CHANNELS[: len(test["variance"])]):
            low, high = test["variance_limits"][index]
            yield {
                "recording": recording,
                "estimate": estimate,
                "channel": channel,
                "variance": test["variance"][index],
                "variance_low": low,
                "variance_high": high,
                "portmanteau": test["portmanteau"][index],
                "portmanteau_limit": test["portmanteau_limit"],
                "consistent": _word(test["consistent"][index]),
                "white": _word(test["white"][index]),
                "colour": test["colour"][index],
            }


def _word(holds: bool) -> str:
    return "yes" if holds else "no"
