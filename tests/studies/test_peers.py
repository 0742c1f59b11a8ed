"""Peers of the study `peers` solve the same equations as snapmap, each in a way of its own."""

from functools import partial

import numpy as np
import pytest

from snapmap import Study, statics, threshold
from snapmap.beam.cosines import symmetric_cosines
from snapmap.solver.options import Cosines
from studies.peers import contenders, measure, opensees, structure
from studies.peers.exact import by_short_steps
from studies.peers.numba_loop import by_numba
from studies.peers.scene import COSINES, HORIZON, lowest_snap, make_scene
from studies.peers.scipy_ivp import by_scipy
from studies.tables import Table

PAIR = slice(2, 9, 6)
"""Of the rows, one of little damping and one of much."""


@pytest.fixture(scope="module")
def scene(handout):
    """Three cosines with the thresholds of the judge."""
    return make_scene(handout, COSINES)


def test_the_judge_agrees_with_its_longer_steps_and_with_heyoka(scene):
    assert scene.error < 3e-7
    pytest.importorskip("heyoka", reason="packages of locks/requirements-peers.lock are missing")
    heyoka = next(one for one in contenders.contenders() if one.solver == "heyoka")
    assert scene.errors(heyoka.make(scene)).max() < 1e-6


def test_thresholds_of_snapmap_have_those_of_the_judge_in_their_bars(scene, handout):
    study = Study(handout, Cosines(modes=3), run={"horizon": HORIZON})
    edges = threshold(study, np.unique(scene.f0), np.unique(scene.C)).stack(row=("C", "f0"))
    clean = edges.ragged.values == 0
    assert clean.sum() > 10
    assert (np.abs(edges.N_first - scene.N) <= edges.N_error)[clean].all()


def test_a_loop_of_numba_and_scipy_find_the_same_thresholds(scene):
    two = scene.take(PAIR)
    coarse, fine = (two.errors(by_numba(scene.equations, dt)) for dt in (0.1, 0.025))
    assert (fine < 3e-5).all() and (fine <= coarse + 1e-6).all()
    assert two.take(slice(1)).errors(by_scipy(scene.equations, "DOP853", 1e-6)).max() < 1e-5


def test_a_lone_search_finds_the_lowest_snap_however_many_it_asks_at_once():
    def ask(N):
        return np.where((N > 1000.0) & (N < 2000.0), 1.0, np.nan)

    for width in (1, 4, 16):
        N, runs = lowest_snap(ask, width)
        assert abs(N / 1000 - 1) < 1e-4 and runs % width == 0
    assert np.isnan(lowest_snap(partial(np.full_like, fill_value=np.nan), 3)[0])
