"""Errors of the force estimates against the sensor."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.reference import PrintedTable, published
from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "kind",
    "estimate",
    "during",
    "component",
    "mae",
    "max",
    "zero_mae",
    "zero_max",
    "mean_force",
    "slope",
    "skill",
    "correlation",
    "coverage50",
    "coverage80",
    "coverage95",
    "interval_score95",
    "zero_interval_score95",
    "mae_low",
    "mae_high",
    "skill_low",
    "determined",
    "printed_mae",
    "printed_max",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("forces"):
        yield from force_errors(name, summary, results.printed.force_mae, results.printed.force_max)


def force_errors(
    recording: str,
    summary: Mapping[str, Any],
    printed_mae: PrintedTable | None,
    printed_max: PrintedTable | None,
) -> Iterator[Row]:
    """Yield the errors of the force estimates against the sensor, from forces.json."""
    tables = {"mae": published(printed_mae, recording), "max": published(printed_max, recording)}
    for kind, estimates in summary["errors"].items():
        for estimate, periods in estimates.items():
            known = _determined(periods.get("contact"))
            for during, figures in periods.items():
                printed = tables if (kind, during) == ("printed", "all") else {}
                for i, component in enumerate(figures["mae"]):
                    yield {
                        "recording": recording,
                        "kind": kind,
                        "estimate": estimate,
                        "during": during,
                        "component": component,
                        **{name: values[component] for name, values in figures.items()},
                        "determined": known.get(component),
                        **{
                            f"printed_{figure}": table[estimate][i]
                            for figure, table in printed.items()
                            if estimate in table
                        },
                    }


def _determined(in_contact: Mapping[str, Any] | None) -> dict[str, str]:
    """Return which components are determined: the skill in contact is significantly above zero."""
    if not in_contact:
        return {}
    skills = in_contact.get("skill_low", in_contact["skill"])
    return {name: "yes" if (skill or 0) > 0 else "no" for name, skill in skills.items()}
