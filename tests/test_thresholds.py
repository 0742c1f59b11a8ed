"""Thresholds against hand-made answers, against the models' own sweeps, and their error bars."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap.survey import _islands
from snapmap.thresholds import first_snap, refine


def test_refinement_finds_the_step_of_a_known_function():
    exact = np.array([1.0, 2.5, 7.0])

    def snaps(N):
        return exact[:, np.newaxis] <= N

    low, high = refine(snaps, np.array([0.5, 2.0, 6.0]), np.array([1.5, 3.0, 8.0]), 1e-9)
    assert (low < exact).all() and (exact <= high).all() and (high / low - 1 <= 1e-9).all()


def test_a_row_without_a_threshold_is_nan():
    N = np.tile([1.0, 2.0, 3.0], (3, 1))
    low, high = first_snap(N, np.array([[0, 0, 0], [1, 1, 1], [0, 1, 0]], bool))
    np.testing.assert_array_equal(low, [np.nan, np.nan, 1.0])
    np.testing.assert_array_equal(high, [np.nan, np.nan, 2.0])


def test_islands_are_counted():
    def scan(N):
        return ((N > 1.0) & (N < 1.1)) | ((N > 1.2) & (N < 1.3)) | (N > 1.5)

    first, always, islands = _islands(scan, np.array([1.001]))
    assert first == pytest.approx(1.0, rel=0.005) and always == pytest.approx(1.5, rel=0.005)
    assert islands.tolist() == [2]


def test_thresholds_lie_within_their_error_bars(handout):
    """On two devices: `auto` against a converged model, and the error bar against the truth."""
    stiff = dataclasses.replace(handout, mass=5e3, spring=8.0, contact=np.inf)
    for device in (handout, stiff):
        rows = {"f0": [400.0, 1500.0], "C": [25.0], "horizon": 300.0}
        found = snapmap.threshold(device, **rows)
        fine = snapmap.threshold(device, **rows, model="cosines", modes=14, step=0.15)
        error = abs(found.N_first - fine.N_first)
        assert (error <= found.N_error + fine.N_error).all()
        assert (error <= 5e-4 * fine.N_first).all()
        assert (found.N_always == found.N_first).all() and not found.islands.any()


def test_a_threshold_is_where_the_sweep_changes(handout):
    found = snapmap.threshold(handout, f0=[1500.0], C=[0.025], model="handout", horizon=300.0)
    N = float(found.N_first.squeeze())
    assert pytest.approx(984.73, abs=0.1) == N
    cube = snapmap.sweep(handout, N=[0.9997 * N, 1.0001 * N], f0=[1500.0], C=[0.025], horizon=300.0)
    assert np.isfinite(cube.t_snap.values).ravel().tolist() == [False, True]


def test_the_static_and_the_impulsive_limit(handout):
    """937 g for slow pulses; a constant N/f0, 82 g/kHz, for short ones."""
    slow = snapmap.threshold(handout, f0=[25.0], C=[25.0])
    assert float(slow.N_first.squeeze()) == pytest.approx(937.0, abs=1.0)
    short = snapmap.threshold(handout, f0=[2e5, 4e5], C=[200.0])
    ratio = short.N_first.values.ravel() / [200.0, 400.0]
    assert ratio[0] == pytest.approx(ratio[1], rel=0.02)
