"""Surfaces of thresholds: which rows are searched, which verified, and that both agree."""

import numpy as np
import pytest
import xarray as xr
from known_model import Known
from small_studies import cases_of
from varied import alone

import snapmap
from snapmap import Study
from snapmap.device.device import batch
from snapmap.numerics.portable import linear
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.adaptive import Survey
from snapmap.solver.cells import to_rows
from snapmap.solver.settings import Run
from snapmap.thresholds import surface, verified
from snapmap.thresholds.probe import Probe, nearby
from snapmap.thresholds.search import FAST_PULSE, RINGING, Search, is_fast, is_ringing
from snapmap.thresholds.verified import Expected, fill

HOW = {"model": "3 cosines", "horizon": 300.0}
ASKED = {"C": [25.0]}
AXES = [linear(1.0, 3.0, 21), linear(-1.0, 1.0, 16)]


def filled(N, clean, near=1e-3):
    """Numbers searched and verified of a surface whose thresholds are known, (n_1, n_2)."""
    N, clean, searched, verified = N.ravel(), clean.ravel(), [], []

    def search(which):
        searched.extend(which)
        return Expected(N[which], *np.zeros((2, which.size)), clean[which])

    def verify(which, expected):
        holds = clean[which] & (abs(expected.N / N[which] - 1) < near)
        verified.extend(which[holds])
        return holds

    rows = np.arange(N.size).reshape(1, *(x.size for x in AXES))
    fill(rows, AXES, search, verify)
    assert sorted([*searched, *verified]) == list(range(N.size))
    return searched, verified


def test_a_cubic_is_expected_as_it_is_and_only_what_departs_from_one_is_searched():
    x, y = np.meshgrid(*AXES, indexing="ij")
    N = 5 + x * x * x - x * y + 2 * y * y * y
    searched, _ = filled(N, np.ones(N.shape, bool), near=1e-12)
    assert len(searched) == 5 * 4
    unclean = np.hypot(x - 1.0, y + 1.0) < 0.5
    jump = np.where(x + y > 3.2, 1.1, 1.0)
    searched, verified = filled(jump * (5 + x * y), ~unclean)
    assert set(np.flatnonzero(unclean)) <= set(searched)
    assert len(verified) > x.size / 2


SLOW, EXACT = to_rows(0, 100.0, np.full(4, 1.00005 / 200)), 1.00005
"""Rows of a known threshold."""


def test_a_threshold_near_a_guess_does_not_depend_on_it(handout):
    guess = np.array([0.9994, 1.0, 1.0006, 1.01])
    low, N = nearby(Probe(Known(batch([handout])), SLOW, Run()), guess, 1e-4)
    assert N[0] == N[1] == N[2] > EXACT > low[2] > N[2] / 1.0001 and np.isnan(N[3])


@pytest.mark.parametrize(("ends", "highest"), cases_of(__file__))
def test_a_verified_threshold_is_as_near_as_its_bar_says(handout, monkeypatch, ends, highest):
    """None is where it is expected a thousandth off, or where a row snaps below it, too."""
    monkeypatch.setattr(verified, "least_amplitudes", lambda model, rows, start: 0.1 + 0 * rows.f0)
    model = Known(batch([handout]), ends)
    finer = Survey(model, model, model, (model,), None, np.ones(1))
    search = Search(finer._replace(finer=finer), SLOW, Run(), 1e-4, highest)
    N, level = np.array([1.0, 0.9994, 1.0006, 1.0013]), np.array([0, 1, 0, 0])
    made = verified._verify(search, Expected(N, np.full(4, 0.02), level, N > 0))
    exact = np.where((N < 1.001) & (len(ends) == 2), EXACT, np.nan)
    np.testing.assert_allclose(made["N_first"], exact, atol=7e-5)
    np.testing.assert_allclose(made["N_error"], 0.0201 * exact + abs(exact - N), atol=7.2e-5)
    np.testing.assert_array_equal(made["N_always"], made["N_first"] if not highest else np.nan * N)
    np.testing.assert_allclose([made["N_looked"], made["level"]], [1.9 * N, level])


def test_a_row_latches_from_the_lowest_N_on_above_which_all_do(handout, monkeypatch):
    monkeypatch.setattr(surface, "steps_and_seconds", lambda *_: np.ones((2, 1, 1)))
    low, high = np.array([1.0, 1.6, 1.0, 1.49]), np.array([2.0, 2.0, 1.4, 2.0])
    found = surface.lowest_latched(Probe(Known(batch([handout])), SLOW, Run()), low, high)
    np.testing.assert_allclose(found, [1.01**41, 1.6, np.nan, 1.49 * 1.01])


def test_rows_ring_or_are_fast_by_their_pulse_and_damper(handout):
    """Of a ramp of a tenth of the pulse; a beam alone has no damper."""
    ramps = make_pulse("trapezoid", rise=0.1, fall=0.1)
    for device, delay in ((handout, 25.0 / 5.5), (alone(handout), 0.0)):
        frequency, share = device.own_frequency, np.array([0.99, 1.01])
        f0 = share * RINGING / 20e-6 / (1 / frequency + delay)
        rings = is_ringing(batch([device]), to_rows(0, f0, 25.0, 0, [ramps]))
        f0 = share * FAST_PULSE * frequency / (2e-6 * np.pi)
        fast = is_fast(batch([device]), to_rows(0, f0, 25.0, 0, [ramps]))
        assert rings.tolist() == fast.tolist() == [False, True]


def test_verified_thresholds_are_those_of_a_search(handout, monkeypatch):
    """Each by itself is searched; bytes do not depend on blocks."""
    f0, thickness = [700.0, 9e3], linear(1.9, 2.1, 9)
    whole = snapmap.threshold(Study(handout, **HOW), f0, **ASKED, axes={"thickness": thickness})
    half = snapmap.threshold(Study(handout, **HOW), f0, **ASKED, axes={"thickness": thickness[::2]})
    assert whole.verified.sum() > 4 and not half.verified.any()
    for each, other in ((whole.isel(thickness=slice(None, None, 2)), half), (half, whole)):
        apart = abs(each.N_first - other.N_first.sel(thickness=each.thickness[:5:2]))
        assert (apart <= each.N_error).all()
    monkeypatch.setattr(verified, "ROWS", 1)
    asked = ASKED | {"axes": {"thickness": thickness}}
    again = snapmap.threshold(Study(handout, **HOW), f0, **asked)
    xr.testing.assert_identical(again, whole)
