"""Thresholds against hand-made answers, against the models' own sweeps, and their error bars."""

from dataclasses import replace

import numpy as np
import pytest
from known_model import Known
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap import Study
from snapmap.device.device import batch
from snapmap.pulse.shocks import HANDOUT_SHOCK
from snapmap.solver.adaptive import Survey
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.outcome import LATCHED, REPEATED_STEP, label
from snapmap.solver.settings import Run
from snapmap.thresholds.edges import stretches
from snapmap.thresholds.effort import CLOSE_PLACES, CLOSE_STEP
from snapmap.thresholds.probe import Probe, amplitudes, near, walk
from snapmap.thresholds.ragged import refine_edges
from snapmap.thresholds.search import Search, find_changes
from snapmap.thresholds.survey import distance, make_bars

HOW = {"model": "3 cosines", "horizon": 300.0}
CHEAP = {"f0": [1500.0], "C": [25.0]}


def test_amplitudes_reach_both_ends_in_even_steps():
    N = amplitudes(np.array([1.0, 2.0, np.nan]), np.array([1.5, 2.0, 3.0]), 0.1)
    assert N[0, 0] == 1.0 and np.nanmax(N[0]) == 1.5 and N[1, 0] == 2.0
    ratios = N[0, 1:-1] / N[0, :-2]
    np.testing.assert_allclose(ratios[np.isfinite(ratios)], 1.1)
    assert np.isnan(N[1, 1:]).all() and np.isnan(N[2]).all()


def test_the_place_on_a_grid_does_not_depend_on_the_guess():
    exact, size = np.array([0, 1, 17, 63, 64]), 64

    def label(rows, places):
        return exact[rows, np.newaxis] <= places

    rows = np.arange(exact.size)
    for guess in (0, 5, 17, 63):
        assert (near(label, rows, np.full(exact.size, guess), size) == exact).all()
    assert (walk(label, rows, 0, size) == exact).all()
    assert walk(label, rows, 3, size, 10).tolist() == [3, 3, 23, 63, 64]


class Bounded(Search):
    """A search whose models know no energy."""

    bound = np.full(2, 0.01)


SIMPLE = [1.0, 9.0]
ROWS = to_rows(0, 9e3, [1 / 18e3, 1e3])
"""Of a threshold of 1, in a beam 2 um thick, and of one far above all that is tried."""


@pytest.mark.parametrize(("scanned", "decided", "highest"), cases_of(__file__)["islands"])
def test_islands_are_seen_once_and_their_ends_refined(handout, scanned, decided, highest):
    scans, decides = (Known(batch([handout]), ends) for ends in (scanned, decided))
    models = Survey(scans, decides, decides, (scans,), None, np.ones(1))
    search = Bounded(models, ROWS, Run(), 1e-6, highest)
    changes = find_changes(search)
    edges = refine_edges(search.probe(decides), changes.edges, changes.ragged, 1e-6)
    N_first, N_always, islands = stretches(edges, changes.is_open)
    always = decided[-2] if highest is None else np.nan
    np.testing.assert_allclose(N_first, [decided[0], np.nan], rtol=2e-6)
    np.testing.assert_allclose(N_always, [always, np.nan], rtol=2e-6)
    below = np.reshape(decided, (-1, 2))[: -1 if highest is None else None]
    np.testing.assert_allclose(np.transpose(islands)[:, 0], below, rtol=2e-6)
    assert np.isnan(np.transpose(islands)[:, 1]).all()


@pytest.mark.parametrize("h", [0.3, 1.0, 3.0])
def test_a_bar_holds_the_error_of_a_step_of_second_order(handout, h):
    """By one other step; models differ in nothing else."""
    model = Known(batch([handout]), SIMPLE, (0.0, 1e-3), h)
    models = Survey(model, model, model, (model,), None, np.ones(1))
    search = Bounded(models, to_rows(0, 100.0, [1 / 200, 1e3]), Run(), 1e-6)
    changes = find_changes(search)
    (bar, _), (ragged, _) = make_bars(search, changes)
    error = changes.N_first[0] - 1
    assert not ragged and error == pytest.approx(1e-3 * h * h, abs=2e-6)
    assert error <= bar <= 2.5 * error + 1e-5


@pytest.mark.parametrize(("worse", "better", "finest", "bar"), cases_of(__file__)["bars"])
def test_a_bar_reaches_other_models_and_islands_that_only_the_finest_sees(
    handout, worse, better, finest, bar
):
    device = batch([handout])
    decides, *others = (Known(device, ends) for ends in (SIMPLE, worse, better))
    models = Survey(decides, decides, decides, tuple(others), None, np.ones(1))
    models = models._replace(finest=Known(device, finest) if finest else None)
    search = Bounded(models, ROWS, Run(), 1e-6)
    (made, none), (ragged, _) = make_bars(search, find_changes(search))
    step = CLOSE_STEP * CLOSE_PLACES[0] + 3e-6
    assert bar <= made <= 1.25 * bar + 2 * step and np.isnan(none) and not ragged


def test_the_distance_to_another_level_is_bracketed():
    exact, N_first = np.array([[1.003], [0.9], [3.0]]), np.array([1.0, 1.0, np.nan])
    apart = distance(lambda N: np.where(exact <= N, 1.0, np.nan), N_first, 1e-4)
    assert 0.003 <= apart[0] <= 0.007 and 0.1 <= apart[1] <= 0.21 and np.isnan(apart[2])
    assert distance(lambda N: np.where(N > 9, 1.0, np.nan), N_first[:1], 1e-4) == np.inf


def test_thresholds_lie_within_their_error_bars(handout, fix_step):
    """On two devices: `auto` against a converged model, and the error bar against the truth."""
    stiff = replace(handout, mass=5e3, spring=8.0, contact=np.inf)
    how = {"horizon": 300.0}
    rows = {"f0": [400.0, 1500.0], "C": [25.0]}
    usual = [snapmap.threshold(Study(device, **how), **rows) for device in (handout, stiff)]
    fix_step(0.15)
    for device, edges in zip((handout, stiff), usual, strict=True):
        fine = snapmap.threshold(Study(device, "11 cosines", **how), **rows)
        error = abs(edges.N_first - fine.N_first)
        assert (error <= edges.N_error + fine.N_error).all()
        assert (error <= 5e-4 * fine.N_first).all()
        assert (edges.N_always == edges.N_first).all() and not edges.islands.any()


def test_narrow_islands_below_a_threshold_are_seen(handout):
    """At 11 kHz labels change five times within 0.5 %, as finer steps see them one by one."""
    edges = snapmap.threshold(Study(handout, horizon=1500.0), [11078.0], [100.0]).squeeze()
    fine = build_model(handout, Cosines(modes=5)).with_step(0.3)
    N = amplitudes(np.array([1420.0]), np.array([1460.0]), CLOSE_STEP)
    snapped = Probe(fine, to_rows(0, 11078.0, 100.0), Run(horizon=1500.0)).snaps(N)
    assert np.count_nonzero(np.diff(snapped)) > 1 and edges.ragged and edges.islands > 0
    first, last = N[snapped].min(), N[~snapped].max()
    assert abs(first - edges.N_first) <= edges.N_error
    assert abs(last - edges.N_always) <= edges.N_error


def test_a_threshold_is_where_the_sweep_changes(handout):
    how = {"model": "elements", "horizon": 300.0}
    asked = {"f0": [1500.0], "C": [0.025]}
    N = snapmap.threshold(Study(handout, **how), **asked).N_first.item()
    assert pytest.approx(984.73, abs=0.1) == N
    cube = snapmap.sweep(Study(handout, until="snap", **how), N=[0.9997 * N, 1.0001 * N], **asked)
    assert np.isfinite(cube.t_snap.values).ravel().tolist() == [False, True]


def test_what_latches_from_a_shock_on_does_so_in_another_step_too(handout):
    """And a damped beam latches wherever it snaps."""
    f0, C = [400.0, 1500.0, 9000.0], [25.0, 200.0]
    ringing, damped = (varied(handout, damping=damping) for damping in (5e-4, 1e-2))
    edges = snapmap.threshold(Study(ringing, "cosines", horizon=1500.0), f0, C)
    lowest, highest = edges.N_latched.values.ravel(), 2 * edges.N_first.values.ravel()
    latching = np.isfinite(lowest)
    assert latching.any() and not latching.all()
    model, settings = build_model(batch([ringing]), Cosines()), Run(horizon=1500.0)
    rows = to_rows(0, np.tile(f0, 2), np.repeat(C, 3), 0, HANDOUT_SHOCK.pulses)
    N = np.column_stack([lowest, highest])[latching]
    for factor in (1.0, REPEATED_STEP):
        cells = rows.take(latching).cells(model.device, N, 1500.0)
        seen = model.with_step(factor).follow(cells, settings)
        latches = label(seen, settings.energy_tolerance) == LATCHED
        assert latches[:, 1].all() and (factor < 1 or latches.all())
    edges = snapmap.threshold(Study(damped, "cosines"), f0[:2], C)
    np.testing.assert_array_equal(edges.N_latched, edges.N_first)
