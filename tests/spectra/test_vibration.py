"""Random vibration: records against closed forms, rates against Poisson's and Rice's laws."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import signal

import snapmap
from snapmap.shocks import make_shocks
from snapmap.spectra.psd import Spectrum
from snapmap.spectra.vibration import fit_rates, vibration_of
from snapmap.study import Study

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


def test_a_record_has_the_rms_of_its_spectrum_and_is_normal():
    a, _ = samples(Spectrum(FLAT), 4.0)
    rms = Spectrum(FLAT).rms
    # The phases leave only the lines at the ends of the band open.
    assert a.std() == pytest.approx(rms, rel=0.02)
    assert abs(np.mean(a**4) / rms**4 - 3) < 0.2


def test_a_spectrum_of_one_line_is_a_sine():
    narrow = Spectrum([(99.6, 3.0), (100.4, 3.0)])
    a, step = samples(narrow, 1.0)
    t = step * np.arange(a.size)
    wave = np.column_stack([np.cos(2 * np.pi * 100 * t), np.sin(2 * np.pi * 100 * t)])
    fitted = wave @ np.linalg.lstsq(wave[1:], a[1:])[0]
    assert abs(a - fitted)[1:].max() < 0.01 * abs(a).max()
    assert abs(a).max() == pytest.approx(math.sqrt(2 * 3.0), rel=0.01)


def test_an_oscillator_answers_as_miles_and_rice_say():
    f, Q, S = 500.0, 20.0, 0.04
    a, step = samples(Spectrum(FLAT), 20.0)
    omega = 2 * np.pi * f
    base = signal.lti([omega / Q, omega**2], [1, omega / Q, omega**2])
    answer = signal.lsim(base, a, step * np.arange(a.size))[1]
    rms = math.sqrt(np.pi / 2 * f * Q * S)
    assert answer.std() == pytest.approx(rms, rel=0.06)
    level = 2 * answer.std()
    crossings = np.count_nonzero((answer[:-1] < level) & (answer[1:] >= level))
    assert crossings / 20.0 == pytest.approx(f * math.exp(-2), rel=0.1)


def test_a_rate_that_obeys_the_law_is_found_with_its_bounds():
    draw, missed = np.random.default_rng(5), 0
    x = np.array([1.0, 0.7, 0.5, 0.35])
    for _ in range(200):
        counts = draw.poisson(16.0 * np.exp(2 - 6 * x))
        if counts.sum() == 0:
            continue
        a, b, variance = fit_rates(x, counts, [16.0] * 4)
        missed += abs(a - 0.4 * b - (2 - 6 * 0.4)) > 1.96 * math.sqrt(variance(0.4))
    assert missed <= 16


def test_vibration_tells_rate_bounds_and_level(handout):
    asked = {"C": [25.0, 200.0], "records": 4, "model": "cosines", "cosines": 3}
    high = snapmap.vibration(handout, [(20.0, 9.0), (2000.0, 9.0)], 0.2, **asked, reach=0.5)
    assert high.rms == pytest.approx(math.sqrt(9 * 1980)) and high.record_length == 0.2
    assert (high.snaps <= 4).all() and (high.failed == 0).all()
    assert np.allclose(high.probability, 1 - np.exp(-0.2 * high.rate))
    assert ((high.rate_low <= high.rate) & (high.rate <= high.rate_high)).all()
    assert ((high.level_low <= high.level) & (high.level <= high.level_high)).all()
    assert high.level[1] > high.level[0]  # damping helps
    again = snapmap.vibration(handout, [(20.0, 9.0), (2000.0, 9.0)], 0.2, **asked, reach=0.5)
    assert high.identical(again)
    calm = snapmap.vibration(handout, [(20.0, 0.09), (2000.0, 0.09)], 0.2, **asked, reach=0.5)
    assert (calm.snaps == 0).all()
    assert np.allclose(calm.rate_high, -math.log(0.025) / (4 * 0.2))
    assert np.allclose(calm.level, high.level, rtol=0.1)


def test_the_pulses_of_a_study_are_of_no_account(handout):
    plain = Study(device=handout, model={"name": "cosines", "cosines": 3})
    both = replace(plain, shocks=make_shocks(["half sine", "sawtooth"], "both"))
    spectrum = Spectrum([(20.0, 9.0), (2000.0, 9.0)])
    asked = {"duration": 0.2, "records": 2, "seed": 1, "reach": 0.01}
    found = (vibration_of(study, {"C": [25.0]}, spectrum, asked) for study in (plain, both))
    assert next(found).identical(next(found))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"psd": [(20.0, 1.0)]}, "psd: "),
        ({"psd": [(20.0, 1.0), (10.0, 1.0)]}, "psd: "),
        ({"psd": [(20.0, 1.0), (30.0, -1.0)]}, "psd: "),
        ({"duration": 0.0}, "duration: 0.0 is not a number above 0"),
        ({"records": 0}, "records: 0"),
        ({"reach": 1.0}, "reach: 1.0"),
    ],
)
def test_what_cannot_be_is_one_line(handout, change, said):
    asked = {"psd": FLAT, "duration": 1.0, "C": [25.0]} | change
    with pytest.raises(ValueError, match=said):
        snapmap.vibration(handout, **asked)
