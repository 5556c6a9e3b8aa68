"""The bands that another recording leaves."""

from dataclasses import replace

import numpy as np
import pytest

from ur5lib.excitation.bands import Bands, Outlook
from ur5lib.excitation.posterior import Earlier
from ur5lib.identification.current_regression import expected_fit
from ur5lib.identification.currents import parameters
from ur5lib.identification.population import fit_population
from ur5lib.pipeline.current_samples import prior_of
from ur5lib.robots.description import POPULATION, load_robot, robot_path
from ur5lib.robots.population import read_measured

SECONDS = 20.0
BANDS = ("force", "current", "mass")


def outlook(recordings: int, days: int) -> Outlook:
    """Of a UR5e that was fitted to as many recordings, which told what other arms have."""
    arm, population = load_robot(robot_path("ur5e")), fit_population(read_measured(POPULATION))
    fit = replace(expected_fit(prior_of(arm, [], population)), days=days)
    return Outlook(arm, Earlier(fit, parameters(fit), None, recordings, [], population))


@pytest.fixture(scope="module")
def of_one_day() -> list[Bands]:
    own = outlook(recordings=5, days=1)
    return own.ranked(own.candidates(SECONDS))


def test_no_recording_widens_a_band_and_the_best_comes_first(of_one_day: list[Bands]) -> None:
    now, *others = of_one_day
    assert now.after == "now"
    assert [row.force for row in others] == sorted(row.force for row in others)
    for row in others:
        assert all(getattr(row, name) < getattr(now, name) for name in BANDS)


def test_another_day_is_worth_more_than_the_same(of_one_day: list[Bands]) -> None:
    rows = {row.after: row for row in of_one_day}
    for name, same in rows.items():
        if (other := rows.get(f"{name}, on another day")) is not None:
            assert all(getattr(other, band) < getattr(same, band) for band in BANDS)
    assert sum("another day" in name for name in rows) == 3


def test_days_that_were_seen_need_no_other() -> None:
    own = outlook(recordings=5, days=3)
    assert not any("another day" in row.after for row in own.ranked(own.candidates(SECONDS)))


def test_what_is_known_of_parameters_narrows_to_what_recordings_differ_in() -> None:
    own = outlook(recordings=5, days=3)
    told = np.eye(len(own.information))
    sure, surer = (own.bands(own.information + size * told) for size in (1e12, 1e14))
    assert sure.force == pytest.approx(surer.force, rel=1e-3)
    assert sure.force < own.bands(own.information).force
