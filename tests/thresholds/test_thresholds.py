"""Thresholds against hand-made answers, against the models' own sweeps, and their error bars."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import amplitudes, asker, near, refine, walk
from snapmap.thresholds.survey import CLOSE_STEP
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
