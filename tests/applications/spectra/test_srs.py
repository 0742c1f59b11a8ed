"""Shock response spectra against another code, records that meet one, and what they trip."""

from dataclasses import replace

import numpy as np
import pytest
from pyyeti import srs as reference

import snapmap
from snapmap.applications.spectra.srs import (
    BAND,
    check_points,
    frequencies,
    level,
    record,
    response,
)
from snapmap.applications.spectra.trips import FACTORS, ends
from snapmap.applications.spectra.verdicts import check_spectra
from snapmap.solver.settings import Settings

CRASH = [(100.0, 100.0), (1000.0, 1500.0), (4000.0, 1500.0)]


def samples(drawn):
    """Acceleration, multiples of g, and the rate of its samples, Hz."""
    pieces = drawn.pulse.pieces
    return np.append(pieces[:, 1], 0.0) * drawn.peak, 1e6 * len(pieces) / drawn.pulse.duration


def test_the_spectrum_of_a_half_sine_is_that_of_another_code():
    f = np.array([200.0, 1600.0, 20_000.0])
    half_sine = np.sin(np.pi * np.linspace(0, 1, 4001))
    expected = reference.srs(half_sine, 8e6, f, 10, ic="zero", time="total", parallel="no")
    spectrum = response(half_sine, 1 / 8e6, f)
    np.testing.assert_allclose(spectrum, expected, rtol=1e-3)
    assert spectrum[2] == pytest.approx(1, abs=0.05)  # slow for it: as on the frame


def test_a_record_meets_its_spectrum_as_another_code_sees_it():
    f = frequencies(100.0, 4000.0)
    assert f.size == 33 and np.diff(np.log2(f))[:-1] == pytest.approx(1 / 6)
    drawn = record(check_points(CRASH), [1, 0])
    how = {"ic": "zero", "ppc": 2, "rolloff": "none", "parallel": "no"}
    spectrum = reference.srs(*samples(drawn), f, 10, **how)
    deviation = 20 * np.log10(spectrum / level(CRASH, f))
    np.testing.assert_allclose(deviation, drawn.deviation, atol=1e-9)
    assert abs(deviation).max() < BAND / 2 and deviation.std() < 1.5
    assert drawn.pulse.duration < 1e6 * 11 / 100


def test_a_record_leaves_no_velocity_and_is_drawn_by_its_seed():
    first, again, other = (record(check_points(CRASH), [1, seed]) for seed in (0, 0, 1))
    assert abs(first.pulse.area) < 1e-4 * first.pulse.gross_area
    np.testing.assert_array_equal(first.pulse.pieces, again.pulse.pieces)
    assert first.pulse.duration != other.pulse.duration


def test_a_spectrum_is_held_against_the_factors_at_which_its_records_snap(handout, study):
    levels, study = [(400.0, 700.0), (4000.0, 1500.0)], replace(study, settings=Settings(0.0))
    trips = snapmap.srs_test(handout, levels, [25.0], records=2, horizon=0.0, model=study.model)
    snaps = trips.snaps.values[0].sum(axis=0)
    first, last = np.argmax(snaps > 0), len(snaps) - 1 - np.argmax(snaps[::-1] < 2)
    asked = [
        {"name": f"{by:g}", "srs": np.array(levels) * [1, by], "direction": "+z", "snaps": must}
        for by in (1.0, 0.25, 4.0)
        for must in (False, True)
    ]
    rows = check_spectra(study, asked, [25.0], records=2)
    for row, end in zip(rows, (first, last + 1), strict=False):
        bar = row.N_first - row.N_error, row.N_first + row.N_error
        assert bar == (FACTORS[end - 1], FACTORS[end])
        assert row.margin == row.N_first and (row.N, row.shape) == (1.0, "spectrum")
    assert [row.verdict for row in rows[2:]] == ["met", "failed", "failed", "met"]
    assert [row.outcome for row in rows[2:]] == ["unsnapped"] * 2 + ["snapped"] * 2
    both = check_spectra(study, [asked[0] | {"direction": "both"}], [25.0], [20.0], records=2)
    assert [(row.direction, row.temperature) for row in both] == [("+z", 20.0), ("-z", 20.0)]
    assert both[0] == rows[0]


def test_ends_leave_out_what_fails():
    snaps = np.ones((2, len(FACTORS)))
    snaps[:, :5], snaps[0, 5], snaps[0, 6], snaps[1, 7] = 0.0, np.nan, 0.0, np.nan
    assert ends(snaps) == (FACTORS[4], FACTORS[5], FACTORS[6], FACTORS[8])
    assert ends(np.zeros((2, len(FACTORS)))) == (4.0, np.inf, 4.0, np.inf)
    assert ends(np.ones((2, len(FACTORS)))) == (0.0, 0.25, 0.0, 0.25)
