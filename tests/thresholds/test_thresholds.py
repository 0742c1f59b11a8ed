"""Thresholds against hand-made answers, against the models' own sweeps, and their error bars."""

import dataclasses
import json

import numpy as np
import pytest

import snapmap
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.search import amplitudes, asker, first_snap, near, refine, walk
from snapmap.solver.settings import Settings
from snapmap.thresholds.bars import _distance
from snapmap.thresholds.islands import (
    NARROW,
    _closer_window,
    _decide,
    _whole_window,
    first_seen,
)
from snapmap.thresholds.transitions import stretches


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


def test_a_row_without_a_threshold_is_nan():
    N = np.tile([1.0, 2.0, 3.0], (3, 1))
    low, high = first_snap(N, np.array([[0, 0, 0], [1, 1, 1], [0, 1, 0]], bool))
    np.testing.assert_array_equal(low, [np.nan, np.nan, 1.0])
    np.testing.assert_array_equal(high, [np.nan, np.nan, 2.0])


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
    slow = np.zeros(2, bool)
    rough, _ = first_seen(asking(coarse), wide, np.full(2, 0.01))
    whole = _whole_window(rough, None, highest, slow)
    window, ragged = _closer_window(asking(coarse), whole, ~slow)
    edges, open_end, *_ = _decide(asking(fine), window, whole, ragged)
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


def test_what_snaps_only_below_the_highest_amplitude_is_an_island():
    closed = np.array([[1.0, 1.4]] * 3)
    N_first, N_always, (start, end) = surveyed(closed, closed, highest=1.8)
    np.testing.assert_allclose([N_first[0], start[0, 0], end[0, 0]], [1.0, 1.0, 1.4], rtol=2e-6)
    assert np.isnan(N_always).all()


def test_the_distance_to_another_level_is_bracketed():
    exact = np.array([[1.003], [0.9], [3.0]])
    N_first = np.array([1.0, 1.0, np.nan])
    distance = _distance(lambda N: told(exact <= N), N_first, 1e-4)
    assert 0.003 <= distance[0] <= 0.007 and 0.1 <= distance[1] <= 0.21 and np.isnan(distance[2])
    assert _distance(lambda N: told(N > 9), N_first[:1], 1e-4) == np.inf


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


def test_narrow_islands_below_a_threshold_are_seen(handout):
    """At 11 kHz labels change five times within 0.5 %, as finer steps see them one by one."""
    found = snapmap.threshold(handout, [11078.0], [100.0], horizon=1500.0).squeeze()
    fine = build_model(handout, "cosines", modes=5).with_step(0.3)
    N = amplitudes(np.array([1420.0]), np.array([1460.0]), NARROW / 2)
    ask = asker(fine, to_rows(0, 11078.0, 100.0), Settings(1500.0))
    snapped = np.isfinite(ask(N))
    assert np.count_nonzero(np.diff(snapped)) > 1 and found.ragged and found.islands > 0
    first, last = N[snapped].min(), N[~snapped].max()
    assert abs(first - found.N_first) <= found.N_error
    assert abs(last - found.N_always) <= found.N_error


def test_a_threshold_is_where_the_sweep_changes(handout):
    found = snapmap.threshold(handout, f0=[1500.0], C=[0.025], model="handout", horizon=300.0)
    N = float(found.N_first.squeeze())
    assert pytest.approx(984.73, abs=0.1) == N
    asked = {"f0": [1500.0], "C": [0.025], "horizon": 300.0, "model": "handout"}
    cube = snapmap.sweep(handout, N=[0.9997 * N, 1.0001 * N], until="snap", **asked)
    assert np.isfinite(cube.t_snap.values).ravel().tolist() == [False, True]


def test_islands_and_late_snaps_are_those_of_single_runs(handout):
    """Near 6 kHz with little damping the ringing after the pulse decides, in islands of N."""
    f0, options = np.array([5800.0, 6200.0]), {"modes": 7}
    asked = {"model": "cosines", "highest": 2400.0, **options}
    found = snapmap.threshold(handout, f0=f0, C=[0.025], **asked).squeeze("C")
    assert (found.islands >= 1).all() and (found.N_always > 1.01 * found.N_first).all()
    assert (found.t_snap > 1e6 / found.f0).all() and (found.N_pulse > found.N_first).all()
    model = build_model(handout, "cosines", **options)
    for row in range(2):
        one = found.isel(f0=row)
        ask = asker(model, to_rows(0, f0[row : row + 1], 0.025), Settings())
        start, end = (
            key.values[np.isfinite(key.values)] for key in (one.island_from, one.island_to)
        )
        assert (start <= end).all() and start[0] == one.N_first and start.size == one.islands
        gaps = np.linspace(end, np.append(start[1:], one.N_always), 22)[1:-1]
        N = np.array([*start, *end, float(one.N_always), *gaps.ravel()])
        snapped = np.isfinite(ask(N[np.newaxis])[0])
        known = 2 * start.size + 1
        assert snapped[:known].all() and not snapped[known:].reshape(gaps.shape).all(axis=0).any()
        # Just below, within the tolerance of the refinement: closer labels change back and forth.
        t_snap = ask(one.N_pulse.item() * np.array([[1 - 1e-4, 1.0]]))[0]
        assert (t_snap * f0[row] < 1e6).tolist() == [False, True]


def test_a_model_section_is_taken_whole(handout):
    """Both the refinement and `auto` have a tolerance."""
    section = {"name": "auto", "tolerance": 2e-3}
    found = snapmap.threshold(handout, f0=[1500.0], C=[25.0], model=section, tolerance=1e-3)
    assert found.N_first.item() == pytest.approx(990.3, rel=2e-3)
    assert json.loads(found.config)["model"] == section


def test_the_ledger_is_asked_for_as_much_as_in_a_sweep(handout):
    """A stricter ledger halves steps, and with them what the threshold leaves open in time."""
    rows = {"f0": [1500.0], "C": [25.0], "model": "reference", "elements": 2, "tolerance": 1e-5}
    loose, strict = (
        snapmap.threshold(handout, **rows, energy_tolerance=tolerance) for tolerance in (1e-2, 1e-5)
    )
    assert loose.N_first != strict.N_first
    assert json.loads(strict.config)["sweep"]["energy_tolerance"] == 1e-5


def test_nothing_is_always_above_the_highest_amplitude(handout):
    found = snapmap.threshold(handout, f0=[1500.0], C=[25.0], highest=900.0, model="cosines")
    assert found.N_first > 900 and np.isnan(found.N_always)


def test_the_static_and_the_impulsive_limit(handout):
    """937 g for slow pulses; a constant N/f0, 82 g/kHz with little damping, for short ones."""
    slow = snapmap.threshold(handout, f0=[25.0], C=[25.0])
    assert float(slow.N_first.squeeze()) == pytest.approx(float(slow.N_static), rel=1e-3)
    short = snapmap.threshold(handout, f0=[2e5, 4e5], C=[200.0])
    velocity = short.N_first.squeeze() * handout.gravity / (2e-6 * short.f0)
    np.testing.assert_allclose(velocity, short.velocity_change.item(), rtol=0.01)


@pytest.mark.parametrize(
    ("key", "value"), [("tolerance", 0.0), ("tolerance", 0.5), ("highest", np.nan), ("f0", [0.0])]
)
def test_what_cannot_be_asked_is_named(handout, key, value):
    with pytest.raises(ValueError, match=f"^{key}: "):
        snapmap.threshold(handout, **{"f0": [1500.0], "C": [25.0], key: value})
