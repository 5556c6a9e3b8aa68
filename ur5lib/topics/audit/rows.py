"""The audit of a wrist's force sensor."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AuditRow:
    """A row of audit.csv: a value with its 95 % interval from low to high.

    verdict: unknown, wrong or right, as by `row` of `audit_sensor`; empty without an expected
    value. free_time, the time without contact [s], has a value alone.
    """

    quantity: str
    component: str
    value: float
    std_error: float | None
    low: float | None
    high: float | None
    unit: str
    expected: float | None
    verdict: str
