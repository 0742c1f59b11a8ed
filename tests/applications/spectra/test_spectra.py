"""Shock response spectra by another method; random vibration against closed forms, and laws."""

import math
from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from scipy.signal import cont2discrete, lfilter
from scipy.stats import chi2
from small_studies import cases_of

import snapmap
from snapmap import Study
from snapmap.applications.spectra import srs
from snapmap.applications.spectra import trips as spectra_trips
from snapmap.applications.spectra.psd import Density, Spectrum
from snapmap.applications.spectra.required import RequiredSpectrum, RequiredVibration
from snapmap.applications.spectra.trips import FACTORS, ends
from snapmap.applications.spectra.vibration import RUNG, _climb, _level, _rates, fit_rates
from snapmap.values.kinds import kind_of

CASES = cases_of(__file__)
CRASH = [(100.0, 100.0), (1000.0, 1500.0), (4000.0, 1500.0)]


def samples(drawn):
    """Acceleration, multiples of g, and the rate of its samples, Hz."""
    pieces = drawn.pulse.pieces
    return np.append(pieces[:, 1], 0.0) * drawn.peak, 1e6 * len(pieces) / drawn.pulse.duration


def spectrum_by_states(acceleration, rate, f):
    """Largest accelerations of oscillators of Q = 10 on a frame, by exponentials of matrices."""
    largest = []
    for frequency in f:
        omega = 2 * np.pi * frequency
        oscillator = [omega / 10, omega**2], [1.0, omega / 10, omega**2]
        (b,), a, _ = cont2discrete(oscillator, 1 / rate, "foh")
        frame = np.append(acceleration, np.zeros(math.ceil(rate / frequency)))
        largest.append(abs(lfilter(b, a, frame)).max())
    return np.array(largest)


def test_the_spectrum_of_a_half_sine_is_that_of_another_method():
    f = np.array([200.0, 1600.0, 20_000.0])
    half_sine = np.sin(np.pi * np.linspace(0, 1, 4001))
    expected = spectrum_by_states(half_sine, 8e6, f)
    spectrum = srs.response(half_sine, 1 / 8e6, f)
    np.testing.assert_allclose(spectrum, expected, rtol=1e-3)
    assert spectrum[2] == pytest.approx(1, abs=0.05)  # slow for it: as on the frame


def test_a_record_meets_its_spectrum_as_another_method_sees_it():
    f = srs.frequencies(CRASH)
    assert f.size == 33 and np.diff(np.log2(f))[:-1] == pytest.approx(1 / 6)
    drawn = srs.record(srs.check_points(CRASH), [1, 0])
    spectrum = spectrum_by_states(*samples(drawn), f)
    deviation = 20 * np.log10(spectrum / srs.level(CRASH, f))
    np.testing.assert_allclose(deviation, drawn.deviation, atol=1e-9)
    assert abs(deviation).max() < srs.BAND == 3.0 and deviation.std() < 1.5
    assert drawn.pulse.duration < 1e6 * 11 / 100


NOTCH = [(150.0, 80.0), (600.0, 900.0), (840.0, 180.0), (1200.0, 900.0), (4000.0, 900.0)]


def test_records_meet_a_spectrum_with_a_notch_or_it_is_refused():
    f, duration = srs.frequencies(NOTCH), []
    for number in range(2):
        drawn = srs.record(srs.check_points(NOTCH), [7, number])
        spectrum = spectrum_by_states(*samples(drawn), f)
        assert abs(20 * np.log10(spectrum / srs.level(NOTCH, f))).max() < 3.1
        duration.append(drawn.pulse.duration)
    assert max(duration) < 1e6 * 11 / 150  # twice 11 half periods
    deep = [(f, by * (0.2 if f == 840 else 1)) for f, by in NOTCH]
    with pytest.raises(ValueError, match=r"^srs: no record meets it within 3 dB; write a smoother"):
        srs.record(srs.check_points(deep), [7, 0])
    widest = [(1.0, 0.5), (9e3, 1.0), (1e4, 1.0)]
    assert srs.check_points(widest).tolist() == [[*point] for point in widest]
    with pytest.raises(ValueError, match=r"^srs: frequencies span more than 1:10000; write"):
        srs.check_points([*widest, (10_001.0, 1.0)])


def test_the_deviation_of_a_record_keeps_its_sign(handout):
    levels, cheap = [(500.0, 200.0), (5000.0, 200.0)], {"model": "cosines", "horizon": 0.0}
    trips = snapmap.srs_test(Study(handout, **cheap), levels, [25.0], records=6)
    drawn = [srs.record(srs.check_points(levels), [1, number]).deviation for number in range(6)]
    for dB, deviation in zip(trips.deviation.values, drawn, strict=True):
        assert dB in (deviation.min(), deviation.max()) and abs(dB) == abs(deviation).max()
    assert {*np.sign(trips.deviation.values)} == {-1.0, 1.0}


def test_a_record_leaves_no_velocity_and_is_drawn_by_its_seed():
    first, again, other = (srs.record(srs.check_points(CRASH), [1, seed]) for seed in (0, 0, 1))
    assert abs(first.pulse.area) < 1e-4 * first.pulse.gross_area
    np.testing.assert_array_equal(first.pulse.pieces, again.pulse.pieces)
    assert first.pulse.duration != other.pulse.duration


def test_a_spectrum_is_held_against_the_factors_at_which_its_records_snap(
    handout, study, monkeypatch
):
    monkeypatch.setattr(spectra_trips, "RECORDS", 2)
    levels, study = [(400.0, 700.0), (4000.0, 1500.0)], replace(study, horizon=0.0)
    trips = snapmap.srs_test(Study(handout, study.model, horizon=0.0), levels, [25.0], records=2)
    snaps = trips.snaps.values[0].sum(axis=0)
    first, last = np.argmax(snaps > 0), len(snaps) - 1 - np.argmax(snaps[::-1] < 2)
    each = product((1.0, 0.25, 4.0), (False, True))
    asked = [RequiredSpectrum("a", must, np.array(levels) * [1, by], "+z") for by, must in each]
    rows = [row for one in asked for row in one.judged(study, "", [25.0])]
    for row, end in zip(rows, (first, last + 1), strict=False):
        bar = row.N_first - row.N_error, row.N_first + row.N_error
        assert bar == (FACTORS[end - 1], FACTORS[end])
        assert row.margin == row.N_first and (row.N, row.shape) == (1.0, "spectrum")
    assert [row.verdict for row in rows[2:]] == ["met", "failed", "failed", "met"]
    assert [row.outcome for row in rows[2:]] == ["unsnapped"] * 2 + ["snapped"] * 2
    both = [*(required := replace(asked[0], direction="both")).judged(study, "", [25.0])]
    assert [(row.direction, row.temperature) for row in both] == [("+z", 20.0), ("-z", 20.0)]
    assert both[0] == rows[0] and len(required.shocks.pulses) == len(both)
    assert {row.must_snap for row in rows} == {False, "arrives"}


def test_ends_leave_out_what_fails():
    snaps = np.ones((2, len(FACTORS)))
    snaps[:, :5], snaps[0, 5], snaps[0, 6], snaps[1, 7] = 0.0, np.nan, 0.0, np.nan
    assert ends(snaps) == (FACTORS[4], FACTORS[5], FACTORS[6], FACTORS[8])
    assert ends(np.zeros((2, len(FACTORS)))) == (4.0, np.inf, 4.0, np.inf)
    assert ends(np.ones((2, len(FACTORS)))) == (0.0, 0.25, 0.0, 0.25)


@pytest.mark.parametrize(("hint", "power"), [(Density, 2), (srs.Levels, 1)])
def test_levels_of_a_spectrum_count_in_standard_gravity_or_si(hint, power):
    """A config names the unit of each; a number in Python counts multiples of g, or g^2/Hz."""
    kind = kind_of(hint)
    in_g, in_si = CASES["units"][kind.noun]
    sizes = dict.fromkeys(in_g, 1.0) | dict.fromkeys(in_si, 9.80665**-power)
    for unit, size in sizes.items():
        points = [["20 Hz", f"3.5 {unit}"], ["2 kHz", f"7e0{unit}"]]
        for read in (kind.read, kind.take):
            assert read(points)[:, 1] == pytest.approx([3.5 * size, 7.0 * size], rel=1e-14)
    assert kind.take([(20.0, 3.5), (2000.0, 7.0)])[:, 1].tolist() == [3.5, 7.0]
    assert ("Hz and multiples of g, " in kind.need) == (power == 1)
    assert kind.take(np.array([(20.0, 3.5), (2000.0, 7.0)]))[:, 1].tolist() == [3.5, 7.0]
    for points, line in CASES["wrong points"]:
        with pytest.raises(ValueError, match=line):
            kind.take(points)
    for wrong in CASES["wrong levels"]:
        with pytest.raises(ValueError, match=rf"\[1\]\[1\]: .*; write a {kind.noun} in one of g"):
            kind.read([["20 Hz", f"3.5 {in_g[0]}"], ["2 kHz", wrong]])


FLAT = [(20.0, 0.04), (2000.0, 0.04)]


def vibration_samples(spectrum, length, seed=1):
    """Acceleration of a record, multiples of g, and the time between its samples, s."""
    drawn, peak = spectrum.record(length, [seed, 0])
    return drawn.pieces[:, 1] * peak, length / len(drawn.pieces)


def test_rms_is_the_integral_of_straight_lines_on_logarithmic_scales():
    bent = Spectrum([(20.0, 0.01), (80.0, 0.04), (2000.0, 0.04)])
    assert bent.rms == pytest.approx(math.sqrt(0.01 * (80**2 - 20**2) / 40 + 0.04 * 1920))
    inside, outside = bent.at(np.array([20.0, 40.0, 80.0, 2e3])), bent.at(np.array([19.9, 2001.0]))
    assert inside == pytest.approx([0.01, 0.02, 0.04, 0.04]) and not outside.any()
    falling = Spectrum([(10.0, 1.0), (100.0, 0.1)])
    assert falling.rms == pytest.approx(math.sqrt(10 * math.log(10)))


def test_a_record_has_ten_periods_of_the_lowest_frequency_or_all_that_there_is():
    low, flat = Spectrum([(0.5, 0.04), (2000.0, 0.04)]), Spectrum(FLAT)
    assert (low.record_length(60.0), low.record_length(5.0)) == (20.0, 5.0)
    assert (flat.record_length(60.0), flat.record_length(0.25)) == (1.0, 0.25)


@pytest.mark.parametrize(("f", "duration", "line"), CASES["too long or short"])
def test_a_record_of_no_sine_or_of_too_many_samples_is_refused(f, duration, line):
    with pytest.raises(ValueError, match=f"^{line}"):
        Spectrum([(end, 0.04) for end in f]).require_record(duration)


def test_the_longest_and_the_shortest_record_have_samples():
    Spectrum([(1.0, 0.04), (10_000.0, 0.04)]).require_record(3600.0)
    Spectrum(FLAT).require_record(5e-4)
    drawn, peak = Spectrum(FLAT).record(5e-4, [1, 0])
    assert np.isfinite(drawn.pieces).all() and peak > 0


def test_an_oscillator_answers_as_miles_and_rice_say():
    f, Q, S = 500.0, 20.0, 0.04
    a, step = vibration_samples(Spectrum(FLAT), 20.0)
    omega = 2 * np.pi * f
    s = 2j * np.pi * np.fft.rfftfreq(a.size, step)  # a record begins anew where it ends
    transfer = (omega / Q * s + omega**2) / (s**2 + omega / Q * s + omega**2)
    answer = np.fft.irfft(transfer * np.fft.rfft(a), a.size)
    rms = math.sqrt(np.pi / 2 * f * Q * S)
    assert answer.std() == pytest.approx(rms, rel=0.06)
    height = 2 * answer.std()
    crossings = np.count_nonzero((answer[:-1] < height) & (answer[1:] >= height))
    assert crossings / 20.0 == pytest.approx(f * math.exp(-2), rel=0.1)


BOUNDS = [(8.0, 11.0, "met", "failed"), (3.0, 4.0, "failed", "met")]
BOUNDS += [(*ends, *["unclear"] * 2) for ends in ((4.0, 6.0), (5.0, 7.0), (3.0, 5.0))]


@pytest.mark.parametrize(("low", "high", "rests", "trips"), BOUNDS)
def test_a_vibration_is_judged_by_the_bounds_of_its_level_at_the_allowed_probability(
    study, monkeypatch, low, high, rests, trips
):
    """Here of 5 g rms; where it must trip, of the probability that it does not."""
    asked, told = [], {"snaps": [1.0], "level_low": [low], "level_high": [high]}
    told = {key: ("C", row) for key, row in (told | {"level": [low + 1.0]}).items()} | {"rms": 5.0}

    def rates(study, axes, spectrum, drawn):
        asked.append((drawn["reach"], drawn["duration"]))
        return xr.Dataset(told)

    monkeypatch.setattr("snapmap.applications.spectra.vibration.vibration_of", rates)
    for must, verdict in ((False, rests), (True, trips)):
        shaken = RequiredVibration("a", must, FLAT, 1e6, probability=0.1)
        (row,) = shaken.judged(study, "", [25.0])
        assert (row.verdict, row.must_snap) == (verdict, must and "arrives")
        assert (row.N, row.duration, row.margin) == (5.0, 1e3, (low + 1.0) / 5.0)
        assert row.margin_error == max(high - low - 1.0, 1.0) / 5.0 and row.outcome == "snapped"
    assert asked == [(0.1, 1.0), (0.9, 1.0)]


def test_a_rate_that_obeys_the_law_is_found_with_its_bounds():
    x, missed = np.array([1.0, 0.7, 0.5, 0.35]), 0
    for counts in np.random.default_rng(5).poisson(16.0 * np.exp(2 - 6 * x), (200, 4)):
        if counts.any():
            a, b, variance = fit_rates(x, counts, [16.0] * 4)
            missed += abs(a - 0.4 * b - (2 - 6 * 0.4)) > 1.96 * math.sqrt(variance(0.4))
    assert missed <= 16


def test_a_fit_has_the_variance_of_its_likelihood_raised_by_the_scatter_of_the_counts():
    """Of the inverse of Fisher's information, and Pearson's sum over its two degrees of freedom."""
    x, steps = np.array([1.0, 0.7, 0.5, 0.35]), np.array([1.0, -1.0, 1.0, -1.0])
    slopes, law = np.stack([np.ones(4), -x]), 16.0 * np.exp(2 - 6 * x)
    for counts in (law, law * (1 + 0.9 * steps)):
        a, b, variance = fit_rates(x, counts, [16.0] * 4)
        expected = 16.0 * np.exp(a - b * x)
        assert slopes @ (counts - expected) == pytest.approx([0, 0], abs=1e-6)
        scatter = max(1, ((counts - expected) ** 2 / expected).sum() / 2)
        assert (scatter > 1) == (counts is not law)
        inverse = np.linalg.inv(slopes * expected @ slopes.T)
        for at in np.array([0.4, 1.2]):
            row = np.stack([1.0, -at])
            assert variance(at) == pytest.approx(scatter * row @ inverse @ row)


def test_vibration_tells_rate_bounds_and_level(handout, monkeypatch):
    how = {"model": {"name": "cosines", "cosines": 3}}
    asked = {"C": [25.0, 200.0], "records": 4, "reach": 0.5}
    each = [[(20.0, density), (2000.0, density)] for density in (9.0, 0.09)]
    ask = lambda psd: snapmap.vibration(Study(handout, **how), psd, 0.05, **asked)  # noqa: E731
    high, calm = map(ask, each)
    monkeypatch.setattr("snapmap.applications.spectra.vibration.PIECES", 1)  # one by one
    again = ask(each[0])
    assert high.rms == pytest.approx(math.sqrt(9 * 1980)) and high.record_length == 0.05
    assert (high.snaps <= 4).all() and (high.failed == 0).all()
    assert ((high.level_low <= high.level) & (high.level <= high.level_high)).all()
    assert high.level[1] > high.level[0]  # damping helps
    assert high.identical(again) and (calm.snaps == 0).all()
    assert np.allclose(calm.rate_high, -math.log(0.025) / (4 * 0.05))
    assert np.allclose(calm.level, high.level, rtol=0.1)


def test_a_single_record_that_snaps_at_the_top_alone_does_not_determine_the_level():
    ladder = {rung: np.array([[float(rung == 2)], [0.0], [1.0]]) for rung in range(3)}
    found, low, high = _level(ladder, 0, 0.01)
    assert math.isnan(found) and (low, high) == (0.0, math.inf)


def test_a_level_has_the_needed_rate_of_a_law_that_counts_obey():
    """ln(rate) = 2 - 3/level^2; none without a snap, or without a run."""
    counts = {rung: 16.0 * math.exp(2 - 3 * RUNG ** (-2 * rung)) for rung in range(-2, 6)}
    column = lambda count: np.array([[count, 0.0], [0.0, 0.0], [16.0, 0.0]])  # noqa: E731
    ladder = {rung: column(count) for rung, count in counts.items()}
    found, low, high = _level(ladder, 0, 0.01)
    assert found == pytest.approx(((2 - math.log(0.01)) / 3) ** -0.5, rel=1e-6)
    assert low < found < high
    assert np.isnan(_level(ladder, 1, 0.01)).all()
    quiet = {0: np.array([[0.0], [0.0], [16.0]])}
    assert _level(quiet, 0, 0.01) == (math.inf,) * 3


def test_rungs_are_followed_from_where_none_snaps_to_where_all_do():
    """Every one about the lowest snap, else every fourth, to 60; of rows that have a device."""
    edges = np.array([2.5, -5.5, 0.0, np.inf])

    def follow(which, reached):
        snaps = np.where(math.log(reached, RUNG) > edges[which], 8.0, 0.0)
        return np.stack([snaps, 0 * snaps, 0 * snaps + 8.0])

    ladder = _climb(follow, np.array([True, True, False, True]), 8)
    known = [[at for at in sorted(ladder) if ladder[at][2, row] > 0] for row in range(4)]
    assert known == [[0, 1, 2, 3, 4], [*range(-8, 1)], [], [*range(0, 61, 4)]]


def test_rates_have_the_bounds_of_poissons_distribution():
    n, time = np.array([1.0, 3.0]), np.array([4.0, 5.0])
    found = _rates(np.stack([n, [1.0, 2.0], time]), 0.2)
    low, high = chi2.ppf(0.025, 2 * n) / 2, chi2.ppf(0.975, 2 * n + 2) / 2
    for key, count in (("", n), ("_low", low), ("_high", high)):
        assert found[f"rate{key}"] == pytest.approx(count / time)
        assert found[f"probability{key}"] == pytest.approx(1 - np.exp(-0.2 * count / time))
    assert _rates(np.array([[0.0], [0.0], [4.0]]), 0.2)["rate_low"] == 0


def test_a_record_has_the_lines_of_its_spectrum_but_for_straight_parts_between_samples():
    a, step = vibration_samples(Spectrum([(20.0, 0.01), (2000.0, 0.04)]), 1.0)
    assert a.size == 2**15 and step * a.size == 1.0
    f = np.arange(20, 2001)
    density = 0.01 * (f / 20) ** (math.log(4) / math.log(100))
    lines = abs(np.fft.rfft(a))[20:2001] * 2 / a.size * np.sinc(f / a.size) ** 2
    np.testing.assert_allclose(lines, np.sqrt(2 * density), atol=1e-3)


def test_a_spectrum_has_the_direction_of_its_study_unless_it_has_its_own():
    one = RequiredSpectrum("a", False, np.array(CRASH))
    for own, of_study, way in ((None, None, "+z"), (None, "-z", "-z"), ("both", "-z", "both")):
        pulse = of_study and SimpleNamespace(direction=of_study)
        assert replace(one, direction=own).under(pulse, 9.81e-6).direction == way
