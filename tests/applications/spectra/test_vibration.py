"""Random vibration: records against closed forms, rates against Poisson's and Rice's laws."""

import math

import numpy as np
import pytest

import snapmap
from snapmap.applications.spectra.psd import Spectrum
from snapmap.applications.spectra.vibration import fit_rates

FLAT = [(20.0, 0.04), (2000.0, 0.04)]


def samples(spectrum, length, seed=1):
    """Acceleration of a record, multiples of g, and the time between its samples, s."""
    drawn, peak = spectrum.record(length, [seed, 0])
    return drawn.pieces[:, 1] * peak, length / len(drawn.pieces)


def test_rms_is_the_integral_of_straight_lines_on_logarithmic_scales():
    bent = Spectrum([(20.0, 0.01), (80.0, 0.04), (2000.0, 0.04)])
    assert bent.rms == pytest.approx(math.sqrt(0.01 * (80**2 - 20**2) / 40 + 0.04 * 1920))
    falling = Spectrum([(10.0, 1.0), (100.0, 0.1)])
    assert falling.rms == pytest.approx(math.sqrt(10 * math.log(10)))


def test_a_record_has_ten_periods_of_the_lowest_frequency_or_all_that_there_is():
    low, flat = Spectrum([(0.5, 0.04), (2000.0, 0.04)]), Spectrum(FLAT)
    assert (low.record_length(60.0), low.record_length(5.0)) == (20.0, 5.0)
    assert (flat.record_length(60.0), flat.record_length(0.25)) == (1.0, 0.25)


@pytest.mark.parametrize(
    ("points", "duration", "key"),
    [
        ([(0.01, 0.04), (2000.0, 0.04)], 3600.0, "psd"),
        ([(20.0, 0.04), (2e6, 0.04)], 3600.0, "psd"),
        ([(1000.2, 0.04), (1000.8, 0.04)], 3600.0, "psd"),
        *((FLAT, duration, "duration") for duration in (5e-324, 4e-4)),
    ],
)
def test_a_record_of_no_sine_or_of_too_many_samples_is_refused(points, duration, key):
    with pytest.raises(ValueError, match=f"^{key}: a record of .*; write "):
        Spectrum(points).require_record(duration)


def test_the_longest_and_the_shortest_record_have_samples():
    Spectrum([(1.0, 0.04), (10_000.0, 0.04)]).require_record(3600.0)
    Spectrum(FLAT).require_record(5e-4)
    drawn, peak = Spectrum(FLAT).record(5e-4, [1, 0])
    assert np.isfinite(drawn.pieces).all() and peak > 0


def test_an_oscillator_answers_as_miles_and_rice_say():
    f, Q, S = 500.0, 20.0, 0.04
    a, step = samples(Spectrum(FLAT), 20.0)
    omega = 2 * np.pi * f
    s = 2j * np.pi * np.fft.rfftfreq(a.size, step)  # a record begins anew where it ends
    transfer = (omega / Q * s + omega**2) / (s**2 + omega / Q * s + omega**2)
    answer = np.fft.irfft(transfer * np.fft.rfft(a), a.size)
    rms = math.sqrt(np.pi / 2 * f * Q * S)
    assert answer.std() == pytest.approx(rms, rel=0.06)
    level = 2 * answer.std()
    crossings = np.count_nonzero((answer[:-1] < level) & (answer[1:] >= level))
    assert crossings / 20.0 == pytest.approx(f * math.exp(-2), rel=0.1)


def test_a_rate_that_obeys_the_law_is_found_with_its_bounds():
    x, missed = np.array([1.0, 0.7, 0.5, 0.35]), 0
    for counts in np.random.default_rng(5).poisson(16.0 * np.exp(2 - 6 * x), (200, 4)):
        if counts.any():
            a, b, variance = fit_rates(x, counts, [16.0] * 4)
            missed += abs(a - 0.4 * b - (2 - 6 * 0.4)) > 1.96 * math.sqrt(variance(0.4))
    assert missed <= 16


def test_vibration_tells_rate_bounds_and_level(handout):
    asked = {"C": [25.0, 200.0], "records": 4, "model": "cosines", "cosines": 3, "reach": 0.5}
    high, again, calm = (
        snapmap.vibration(handout, [(20.0, density), (2000.0, density)], 0.2, **asked)
        for density in (9.0, 9.0, 0.09)
    )
    assert high.rms == pytest.approx(math.sqrt(9 * 1980)) and high.record_length == 0.2
    assert (high.snaps <= 4).all() and (high.failed == 0).all()
    assert np.allclose(high.probability, 1 - np.exp(-0.2 * high.rate))
    assert ((high.rate_low <= high.rate) & (high.rate <= high.rate_high)).all()
    assert ((high.level_low <= high.level) & (high.level <= high.level_high)).all()
    assert high.level[1] > high.level[0]  # damping helps
    assert high.identical(again) and (calm.snaps == 0).all()
    assert np.allclose(calm.rate_high, -math.log(0.025) / (4 * 0.2))
    assert np.allclose(calm.level, high.level, rtol=0.1)
