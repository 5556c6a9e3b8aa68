"""Torque constants and offsets by the thesis's regression on every recording, beside the print."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.reference import PrintedTable, published
from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "regression",
    "joint",
    "torque_constant",
    "torque_constant_std_error",
    "offset",
    "offset_std_error",
    "printed_torque_constant",
    "printed_offset",
    "mean_torque",
    "correlation",
    "correlation_without_friction",
]
AS_PRINTED = "torque_on_current"


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows; none without published constants."""
    printed = results.printed.current_torque
    for name, constants in results.each("constants") if printed else []:
        yield from constant_rows(name, constants, printed)


def constant_rows(
    recording: str, constants: Mapping[str, Any], printed: PrintedTable | None
) -> Iterator[Row]:
    """Yield both regressions of the joints that move, from published_constants.json."""
    values = published(printed, recording)
    for regression, line in constants.get("lines", {}).items():
        known = values if regression == AS_PRINTED else {}
        for joint in range(6):
            if line["torque_constant"][joint] is not None:
                yield {
                    "recording": recording,
                    "regression": regression,
                    "joint": joint + 1,
                    "torque_constant": line["torque_constant"][joint],
                    "torque_constant_std_error": line["torque_constant_std"][joint],
                    "offset": line["offset"][joint],
                    "offset_std_error": line["offset_std"][joint],
                    "printed_torque_constant": known["k"][joint] if known else None,
                    "printed_offset": known["b"][joint] if known else None,
                    "mean_torque": constants["mean_torque"][joint],
                    "correlation": constants["correlation"][joint],
                    "correlation_without_friction": constants["correlation_without_friction"][
                        joint
                    ],
                }
