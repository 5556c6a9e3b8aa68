"""Frequency response, presets and ends of the low-pass filters; the derivative."""

import numpy as np
import pytest
from scipy import signal

from ur5lib.timeseries.lowpass import (
    Butterworth,
    causal_lowpass,
    frequency_response,
    inner_lowpass,
    slow_delay,
    zero_phase_lowpass,
)
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import by_segment

DESIGNS = [Butterworth(8, 4.7), Butterworth(5, 1.454)]  # of Equation 5.12 and Section 6.1
RATE = 125.0


@pytest.mark.parametrize("design", [*DESIGNS, Butterworth(1, 20.0), Butterworth(4, 60.0)])
def test_response_is_the_definition(design: Butterworth) -> None:
    """|H|² = 1 / (1 + (Ω / Ω_c)^2N), with frequencies warped by the bilinear transform."""
    frequency = np.linspace(0.1, 60, 200)
    warped = np.tan(np.pi * frequency / RATE) / np.tan(np.pi * design.cutoff / RATE)
    expected = 1 / np.sqrt(1 + warped ** (2 * design.order))
    np.testing.assert_allclose(frequency_response(frequency, RATE, *design), expected, atol=1e-9)


@pytest.mark.parametrize("design", DESIGNS)
def test_response_is_the_filters(design: Butterworth) -> None:
    """What an impulse becomes, by its spectrum: by one pass; squared and without phase by both."""
    impulse = np.zeros((8192, 1))
    impulse[4096] = 1
    once, twice = (
        np.fft.rfft(run(impulse, RATE, *design)[:, 0]) / np.fft.rfft(impulse[:, 0])
        for run in (causal_lowpass, zero_phase_lowpass)
    )
    gain = frequency_response(np.fft.rfftfreq(8192, 1 / RATE)[:-1], RATE, *design)
    np.testing.assert_allclose(np.abs(once[:-1]), gain, atol=1e-6)
    np.testing.assert_allclose(twice[:-1], gain**2, atol=1e-6)


@pytest.mark.parametrize("design", DESIGNS)
def test_lines_pass_to_the_ends(design: Butterworth) -> None:
    line = np.linspace(-3, 5, 1500)[:, None]
    np.testing.assert_allclose(zero_phase_lowpass(line, RATE, *design), line, atol=1e-3)


@pytest.mark.parametrize("count", [2, 40, 1500])
@pytest.mark.parametrize("design", DESIGNS)
def test_ends_go_on_by_their_reflection_for_three_periods(design: Butterworth, count: int) -> None:
    """Of the cut-off, or as long as there is something to reflect."""
    values = np.random.default_rng(0).normal(size=(count, 2)).cumsum(axis=0)
    reach = min(count - 1, int(3 / design.cutoff * RATE))
    before, after = (
        2 * values[0] - values[reach:0:-1],
        2 * values[-1] - values[-2 : -reach - 2 : -1],
    )
    sections = signal.butter(design.order, design.cutoff, fs=RATE, output="sos")
    longer = np.concatenate([before, values, after])
    expected = signal.sosfiltfilt(sections, longer, axis=0, padlen=0)[reach : reach + count]
    np.testing.assert_allclose(zero_phase_lowpass(values, RATE, *design), expected, atol=1e-9)


@pytest.mark.parametrize("count", [52, 53, 500])
def test_ends_where_the_filter_has_to_guess_are_left_out(count: int) -> None:
    """1 / cutoff at either end: 26 samples here; of a record of two such ends nothing is left."""
    values = np.random.default_rng(1).normal(size=(count, 1))
    inner = inner_lowpass(values, RATE, *Butterworth(8, 4.8))[:, 0]
    whole = zero_phase_lowpass(values, RATE, *Butterworth(8, 4.8))[:, 0]
    np.testing.assert_array_equal(inner[26:-26], whole[26:-26] if count > 52 else [])
    assert np.isnan(inner[:26]).all()
    assert np.isnan(inner[-26:]).all()


def test_a_high_order_at_a_low_cutoff_is_stable() -> None:
    """As one polynomial it would not be: that is why the design is in sections."""
    noise = np.random.default_rng(0).normal(size=(5000, 1))
    cutoff = 0.1
    assert np.abs(causal_lowpass(noise, RATE, 8, cutoff)).max() < 1
    polynomials = signal.butter(8, cutoff, fs=RATE)
    assert not np.abs(signal.lfilter(*polynomials, noise, axis=0)).max() < 1


@pytest.mark.parametrize("cutoff", [62.5, 100.0, 1000.0])
def test_a_cutoff_beyond_nyquist_changes_nothing(cutoff: float) -> None:
    """Each recording has its own: at 500 Hz, the same cut-offs do filter."""
    wave = np.sin(2 * np.pi * 20 * np.arange(2000) / RATE)[:, None]
    for lowpass in (zero_phase_lowpass, causal_lowpass):
        np.testing.assert_array_equal(lowpass(wave, RATE, 4, cutoff), wave)
    np.testing.assert_allclose(frequency_response(np.array([1.0, 60.0]), RATE, 4, cutoff), 1.0)
    whole = zero_phase_lowpass(wave, 500.0, 4, cutoff)
    assert (np.abs(whole - wave).max() > 1e-3) == (cutoff < 250)


@pytest.mark.parametrize("cutoff", [0.0, -1.0, np.nan])
def test_a_cutoff_that_is_none_is_refused(cutoff: float) -> None:
    with pytest.raises(ValueError, match="is not above zero"):
        zero_phase_lowpass(np.ones((9, 1)), RATE, 4, cutoff)


def test_neither_segments_nor_what_a_missing_row_parts_touch_one_another() -> None:
    """The row stays missing."""
    values = np.repeat([0.0, 1.0, np.nan, 0.0], [200, 200, 1, 200])[:, None]
    segment = np.repeat([0, 1], [200, 401])
    smooth = by_segment(zero_phase_lowpass, values, segment, RATE, 4, 5)
    np.testing.assert_allclose(smooth, values, atol=1e-12)


@pytest.mark.parametrize("length", [1, 2, 5])
def test_short_segments_do_not_fail(length: int) -> None:
    values = np.ones((length, 3))
    np.testing.assert_allclose(zero_phase_lowpass(values, RATE, 4, 5), values)


def test_derivative_of_a_parabola_is_exact_inside() -> None:
    time = np.arange(2000) / RATE
    slope = differentiate(time[:, None] ** 2, 1 / RATE)
    np.testing.assert_allclose(slope[1:-1, 0], 2 * time[1:-1], atol=1e-9)
    assert np.isnan(differentiate(np.ones((1, 2)), 1 / RATE)).all()


@pytest.mark.parametrize(("design", "delay"), [(DESIGNS[0], 0.17), (DESIGNS[1], 0.35)])
def test_slow_signals_are_late_by_the_delay(design: Butterworth, delay: float) -> None:
    """A ramp, once the filter has forgotten its start; erratum 5: by a third of a second."""
    assert slow_delay(design) == pytest.approx(delay, abs=0.01)
    time = np.arange(4000) / RATE
    passed = causal_lowpass(time[:, None], RATE, *design)[:, 0]
    np.testing.assert_allclose(time[-1] - passed[-1], slow_delay(design), rtol=0.01)
