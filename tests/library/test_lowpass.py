"""Frequency response, presets and ends of the low-pass filters."""

import numpy as np
import pytest
from scipy import signal

from ur5lib.timeseries.lowpass import (
    THESIS_ACCELERATION,
    THESIS_CURRENT,
    Butterworth,
    causal_lowpass,
    frequency_response,
    zero_phase_lowpass,
)

RATE = 125.0


@pytest.mark.parametrize("design", [THESIS_ACCELERATION, THESIS_CURRENT, Butterworth(1, 20.0)])
def test_response_is_the_definition(design: Butterworth) -> None:
    """|H|² = 1 / (1 + (Ω / Ω_c)^2N), with frequencies warped by the bilinear transform."""
    frequency = np.linspace(0.1, 60, 200)
    warped = np.tan(np.pi * frequency / RATE) / np.tan(np.pi * design.cutoff / RATE)
    expected = 1 / np.sqrt(1 + warped ** (2 * design.order))
    np.testing.assert_allclose(frequency_response(frequency, RATE, *design), expected, atol=1e-9)


@pytest.mark.parametrize("design", [THESIS_ACCELERATION, THESIS_CURRENT])
def test_response_is_the_filters(design: Butterworth) -> None:
    """The spectrum of what an impulse becomes: by one pass, and squared by both."""
    impulse = np.zeros((8192, 1))
    impulse[4096] = 1
    once, twice = (
        np.abs(np.fft.rfft(run(impulse, RATE, *design)[:, 0]))
        for run in (causal_lowpass, zero_phase_lowpass)
    )
    gain = frequency_response(np.fft.rfftfreq(8192, 1 / RATE)[:-1], RATE, *design)
    np.testing.assert_allclose(once[:-1], gain, atol=1e-6)
    np.testing.assert_allclose(twice[:-1], gain**2, atol=1e-6)


@pytest.mark.parametrize("design", [THESIS_ACCELERATION, THESIS_CURRENT])
def test_lines_pass_to_the_ends(design: Butterworth) -> None:
    line = np.linspace(-3, 5, 1500)[:, None]
    np.testing.assert_allclose(zero_phase_lowpass(line, RATE, *design), line, atol=1e-3)


def test_a_high_order_at_a_low_cutoff_is_stable() -> None:
    """As one polynomial it would not be: that is why the design is in sections."""
    noise = np.random.default_rng(0).normal(size=(5000, 1))
    cutoff = 0.1
    assert np.abs(causal_lowpass(noise, RATE, 8, cutoff)).max() < 1
    polynomials = signal.butter(8, cutoff, fs=RATE)
    assert not np.abs(signal.lfilter(*polynomials, noise, axis=0)).max() < 1


def test_a_response_beyond_nyquist_is_refused() -> None:
    with pytest.raises(ValueError, match="not below half the rate"):
        frequency_response(np.array([1.0]), RATE, 4, 62.5)
