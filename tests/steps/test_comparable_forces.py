"""Which forces are compared with a sensor, and which errors may be relied on."""

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.made_tables import record
from ur5lib.records.force_errors import ForceError
from ur5lib.steps.judge_sensor import compared_estimates, used

WRENCH = np.ones((5, 6))


@pytest.mark.parametrize(
    ("wrist", "raw", "own_clock", "kept"),
    [
        (True, None, False, False),
        (True, WRENCH, False, True),
        (True, None, True, True),
        (False, None, False, True),
    ],
)
def test_a_sensor_is_not_compared_with_itself(
    wrist: bool, raw: Any, own_clock: bool, kept: bool
) -> None:
    """The controller's force of an e-Series arm is its wrist sensor."""
    robot: Any = SimpleNamespace(wrist_sensor=wrist)
    signals: Any = SimpleNamespace(ft_raw_wrench=raw)
    reading: Any = SimpleNamespace(own_clock=own_clock)
    both = {"Fu": WRENCH, "F": 2 * WRENCH}
    published: Any = SimpleNamespace(printed=both, corrected=both)
    forces: Any = SimpleNamespace(wrench={}, std={}, log_odds={})
    found = compared_estimates(robot, signals, reading, published, forces)
    assert {*found} == {"printed", "corrected", "compensated"}
    for estimates in found.values():
        assert [*estimates] == (["Fu", "F"] if kept else ["F"])


@pytest.mark.parametrize(
    ("is_doubted", "estimate", "use"),
    [
        (False, "Fmap", ("yes", "")),
        (False, "static", ("yes", "uncalibrated")),
        (True, "Fmap", ("no", "sensor_bias")),
        (True, "static", ("no", "sensor_bias")),
    ],
)
def test_which_errors_of_the_force_may_be_relied_on(
    is_doubted: bool, estimate: str, use: tuple[str, str]
) -> None:
    """Of forces in contact, also in those that are missed; nothing is said of other errors."""
    kinds = ("compensated", "corrected"), ("contact", "missed", "free", "all"), ("Fx", "nx")
    judged = [("compensated", during, "Fx") for during in ("contact", "missed")]
    for kind, during, component in product(*kinds):
        about = {"kind": kind, "during": during, "component": component, "estimate": estimate}
        for role, told in (("fit", ("no", "fitted")), ("validate", use), ("contact", use)):
            row = used(record(ForceError, about), role, is_doubted)
            expected = told if (kind, during, component) in judged else (None, "")
            assert (row.use, row.reason) == expected
