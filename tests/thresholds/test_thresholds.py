"""Thresholds against hand-made answers, against the models' own sweeps, and their error bars."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import (
    Seen,
    Window,
    amplitudes,
    around,
    asker,
    joined,
    near,
    refine,
    scan,
    stretches,
    walk,
)
from snapmap.thresholds.survey import (
    CLEAN_REACH,
    CLOSE_STEP,
    RAGGED_REACH,
    RAGGED_STEP,
    decide,
    find_islands,
    first_seen,
    island_limits,
    scan_ragged,
)
from snapmap.thresholds.survey import distance as distance_to


def told(snapped):
    """t_snap for whatever snaps."""
    return np.where(snapped, 1.0, np.nan)


def test_refinement_finds_the_step_of_a_known_function():
    exact = np.array([1.0, 2.5, 7.0])

    def ask(N):
        return told(exact[:, np.newaxis] <= N)

    low, high = refine(ask, np.array([0.5, 2.0, 6.0]), np.array([1.5, 3.0, 8.0]), 1e-9)
    assert (low < exact).all() and (exact <= high).all() and (high / low - 1 <= 1e-9).all()


def test_the_place_on_a_grid_does_not_depend_on_the_guess():
    exact, size = np.array([0, 1, 17, 63, 64]), 64

    def label(rows, places):
        return exact[rows, np.newaxis] <= places

    rows = np.arange(exact.size)
    for guess in (0, 5, 17, 63):
        assert (near(label, rows, np.full(exact.size, guess), size) == exact).all()
    assert (walk(label, rows, 0, size) == exact).all()
    assert walk(label, rows, 3, size, 10).tolist() == [3, 3, 23, 63, 64]


def test_amplitudes_reach_both_ends_in_even_steps():
    N = amplitudes(np.array([1.0, 2.0, np.nan]), np.array([1.5, 2.0, 3.0]), 0.1)
    assert N[0, 0] == 1.0 and np.nanmax(N[0]) == 1.5
    ratios = N[0, 1:-1] / N[0, :-2]
    np.testing.assert_allclose(ratios[np.isfinite(ratios)], 1.1)
    assert N[1, 0] == 2.0 and np.isnan(N[1, 1:]).all() and np.isnan(N[2]).all()


ISLANDS = np.array([[1.0, 1.02], [1.1, 1.2], [1.5, 9.0]])


def surveyed(coarse, fine, highest=None):
    """N_first, N_always and islands of one row and one that never snaps, for two given levels."""

    def asking(level):
        stretches = np.array([level, np.full((3, 2), np.inf)])

        def ask(N, rows=slice(None)):
            low, high = (stretches[rows][:, np.newaxis, :, end] for end in (0, 1))
            return told(((low <= N[..., np.newaxis]) & (N[..., np.newaxis] <= high)).any(axis=2))

        return ask

    wide = np.tile(np.geomspace(0.1, 8.0, 200), (2, 1))
    rough, _ = first_seen(asking(coarse), wide, np.full(2, 0.01))
    limits = island_limits(rough, None, highest, np.zeros(2, bool))
    window, ragged = find_islands(asking(coarse), limits)

    def closely(low, high):
        close = Window(low / CLEAN_REACH, high * CLEAN_REACH, np.full(low.size, CLOSE_STEP))
        return Seen(*scan(asking(fine), close.N), close.low, close.high)

    seen, clean = decide(asking(fine), closely, window, ragged)
    window = around(limits, window.low, window.high, RAGGED_REACH, RAGGED_STEP).of(~clean)
    scanned, _ = scan_ragged(asking(fine), [asking(coarse)], window, seen.of(~clean))
    edges, open_end = joined(seen.of(clean).edges, scanned.edges), ~clean & ~scanned.ends
    row, *ends, rising = edges
    low, high = refine(lambda N: asking(fine)(N, row), *ends, 1e-6, rising)
    edges = edges._replace(low=low, high=high)
    return stretches(edges, open_end)


def test_islands_are_found_and_their_ends_refined():
    N_first, N_always, (start, end) = surveyed(ISLANDS, ISLANDS)
    np.testing.assert_allclose(N_first, [1.0, np.nan], rtol=2e-6)
    np.testing.assert_allclose(N_always, [1.5, np.nan], rtol=2e-6)
    np.testing.assert_allclose(start, [[1.0, 1.1], [np.nan] * 2], rtol=2e-6)
    np.testing.assert_allclose(end, [[1.02, 1.2], [np.nan] * 2], rtol=2e-6)


def test_the_deciding_level_looks_farther_where_the_scanning_one_was_wrong():
    simple = np.array([[1.03, 9.0]] * 3)
    double = np.array([[1.0, 1.02], [1.05, 9.0], [1.05, 9.0]])
    N_first, N_always, (start, end) = surveyed(simple, double)
    found = [N_first[0], N_always[0], start[0, 0], end[0, 0]]
    np.testing.assert_allclose(found, [1.0, 1.05, 1.0, 1.02], rtol=2e-6)


def test_islands_that_two_looks_see_are_told_once():
    """The edge that is looked at closely lies at an end of the window of the cheapest level."""
    simple = np.array([[1.0, 9.0]] * 3)
    for ends in ([0.9965, 0.998, 1.015, 1.03, 1.032], [0.975, 0.977, 0.985, 1.001, 1.0015]):
        fine = np.reshape([*ends, 9.0], (3, 2))
        N_first, N_always, (start, end) = surveyed(simple, fine)
        found = [N_first[0], N_always[0], *start[0], *end[0]]
        exact = [ends[0], ends[4], ends[0], ends[2], ends[1], ends[3]]
        np.testing.assert_allclose(found, exact, rtol=2e-6)


def test_what_snaps_only_below_the_highest_amplitude_is_an_island():
    closed = np.array([[1.0, 1.4]] * 3)
    N_first, N_always, (start, end) = surveyed(closed, closed, highest=1.8)
    np.testing.assert_allclose([N_first[0], start[0, 0], end[0, 0]], [1.0, 1.0, 1.4], rtol=2e-6)
    assert np.isnan(N_always).all()


def test_the_distance_to_another_level_is_bracketed():
    exact = np.array([[1.003], [0.9], [3.0]])
    N_first = np.array([1.0, 1.0, np.nan])
    distance = distance_to(lambda N: told(exact <= N), N_first, 1e-4)
    assert 0.003 <= distance[0] <= 0.007 and 0.1 <= distance[1] <= 0.21 and np.isnan(distance[2])
    assert distance_to(lambda N: told(N > 9), N_first[:1], 1e-4) == np.inf


def test_thresholds_lie_within_their_error_bars(handout, fix_step):
    """On two devices: `auto` against a converged model, and the error bar against the truth."""
    stiff = dataclasses.replace(handout, mass=5e3, spring=8.0, contact=np.inf)
    rows = {"f0": [400.0, 1500.0], "C": [25.0], "horizon": 300.0}
    usual = [snapmap.threshold(device, **rows) for device in (handout, stiff)]
    fix_step(0.15)
    for device, found in zip((handout, stiff), usual, strict=True):
        fine = snapmap.threshold(device, **rows, model="cosines", modes=11)
        error = abs(found.N_first - fine.N_first)
        assert (error <= found.N_error + fine.N_error).all()
        assert (error <= 5e-4 * fine.N_first).all()
        assert (found.N_always == found.N_first).all() and not found.islands.any()


def test_narrow_islands_below_a_threshold_are_seen(handout):
    """At 11 kHz labels change five times within 0.5 %, as finer steps see them one by one."""
    found = snapmap.threshold(handout, [11078.0], [100.0], horizon=1500.0).squeeze()
    fine = build_model(handout, "cosines", modes=5).with_step(0.3)
    N = amplitudes(np.array([1420.0]), np.array([1460.0]), CLOSE_STEP)
    ask = asker(fine, to_rows(0, 11078.0, 100.0), Settings(1500.0))
    snapped = np.isfinite(ask(N))
    assert np.count_nonzero(np.diff(snapped)) > 1 and found.ragged and found.islands > 0
    first, last = N[snapped].min(), N[~snapped].max()
    assert abs(first - found.N_first) <= found.N_error
    assert abs(last - found.N_always) <= found.N_error


def test_a_threshold_is_where_the_sweep_changes(handout):
    found = snapmap.threshold(handout, f0=[1500.0], C=[0.025], model="elements", horizon=300.0)
    N = float(found.N_first.squeeze())
    assert pytest.approx(984.73, abs=0.1) == N
    asked = {"f0": [1500.0], "C": [0.025], "horizon": 300.0, "model": "elements"}
    cube = snapmap.sweep(handout, N=[0.9997 * N, 1.0001 * N], until="snap", **asked)
    assert np.isfinite(cube.t_snap.values).ravel().tolist() == [False, True]


def test_a_tolerance_that_bars_do_not_keep_is_said(handout):
    asked = {"f0": [1500.0], "C": [25.0], "model": "cosines", "modes": 3, "horizon": 300.0}
    with pytest.warns(UserWarning, match="tolerance: 1e-05 bounds only the refinement; .* 1 of 1"):
        close = snapmap.threshold(handout, **asked, tolerance=1e-5)
    assert close.N_error.item() > 2e-5 * close.N_first.item()
