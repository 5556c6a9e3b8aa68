"""Tables of results on motion: accelerations, innovations, the IMU's calibration."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.reference import PrintedTable, published

Row = dict[str, object]

CHANNELS = [f"q_{joint}" for joint in range(1, 7)] + [f"qd_{joint}" for joint in range(1, 7)]
CHANNELS += [f"imu_{sensor}{axis}" for sensor in "ag" for axis in "xyz"]


def acceleration_errors(
    recording: str, summary: Mapping[str, Any], printed: PrintedTable | None
) -> Iterator[Row]:
    """MAE of the end effector's acceleration against the IMU, from accelerations.json."""
    values = published(printed, recording)
    for estimate, errors in summary["errors"].items():
        for index, (component, mae) in enumerate(errors["mae"].items()):
            yield {
                "recording": recording,
                "estimate": estimate,
                "component": component,
                "mae": mae,
                "printed": values[estimate][index] if estimate in values else None,
                "zero_mae": errors["zero_mae"][component],
            }


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
            }


def calibration_rows(robot: str, known: Mapping[str, Any]) -> Iterator[Row]:
    """What all recordings for fitting tell of an arm's IMU, from imu.json."""
    found = known.get("all", {})
    for quantity, unit in (("mounting", "rad"), ("tilt", "rad"), ("gyroscope_bias", "rad/s")):
        for axis, value, std in zip(
            "xyz", found.get(quantity, []), found.get(f"{quantity}_std", []), strict=False
        ):
            yield {
                "robot": robot,
                "quantity": quantity,
                "axis": axis,
                "unit": unit,
                "value": value,
                "std_error": std,
            }


def _word(holds: bool) -> str:
    return "yes" if holds else "no"
