"""Stamps at another rate than the name of their file or folder says."""

import pytest

from ur5lib.checks.named_rates import other_named_rate


@pytest.mark.parametrize(
    ("names", "period"),
    [
        (["free_125hz.csv"], 0.01),
        (["logs", "ur5_500 Hz.csv"], 0.0025),
        (["joint_space_1kHz.csv"], 0.00125),
        (["traj1_8ms.csv"], 0.01),
        (["benchmark-10hz", "A.csv"], 0.125),
    ],
)
def test_a_clock_of_another_rate_than_named_is_told(names: list[str], period: float) -> None:
    (found,) = other_named_rate(names, period)
    assert found.severity == "warning"
    assert "1.25 times" in found.detail or "0.8 times" in found.detail


@pytest.mark.parametrize(
    ("names", "period"),
    [
        (["free_125hz.csv"], 0.008),
        (["ur5e_500hz.csv"], 0.01),  # every fifth sample
        (["force_100hz_robot_125hz.csv"], 0.008),
        (["raw-4ms", "A.csv"], 0.004),
        (["joint_space_1khz.csv"], 0.001),
        (["run_3.csv"], 0.01),
        (["ms", "hz.csv"], 0.01),
        (["0hz.csv"], 0.01),
    ],
)
def test_names_that_fit_or_say_no_rate_are_none(names: list[str], period: float) -> None:
    assert [*other_named_rate(names, period)] == []
