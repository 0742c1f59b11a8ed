"""Peers of the study `peers` solve the same equations as snapmap, each in a way of its own."""

from functools import partial

import numpy as np
import pytest

from snapmap import Study, statics, threshold
from snapmap.solver.options import Cosines
from studies.peers import contenders, measure, opensees, structure
from studies.peers.exact import by_short_steps
from studies.peers.numba_loop import by_numba
from studies.peers.scene import COSINES, HORIZON, ROWS, lowest_snap, make_scene
from studies.peers.scipy_ivp import by_scipy

MISSING = "packages of locks/requirements-peers.lock are missing"


@pytest.fixture(scope="module")
def scene(handout):
    """Three cosines with the judge's thresholds of four rows."""
    return make_scene(handout, COSINES, ROWS[2::2][:2])


def test_the_bars_of_snapmap_have_the_thresholds_of_the_judge(scene, handout):
    assert scene.error < 3e-6
    study = Study(handout, Cosines(modes=3), horizon=HORIZON)
    edges = threshold(study, np.unique(scene.f0), np.unique(scene.C))
    edges = edges[["N_first", "N_error", "ragged"]].stack(row=("C", "f0"))
    assert not edges.ragged.any()
    assert (np.abs(edges.N_first - scene.N) <= edges.N_error).all()


def test_the_judge_is_of_fourth_order_and_the_loop_of_numba_of_second(scene):
    t = partial(snaps, scene)
    exact = t(by_short_steps(scene.equations, 0.004))
    for make, dt, order in ((by_short_steps, 0.256, 4), (by_numba, 0.05, 2)):
        error, halved = (abs(t(make(scene.equations, h)) - exact).max() for h in (dt, dt / 2))
        assert order - 0.5 < np.log2(error / halved)
    assert abs(t(by_scipy(scene.equations, "DOP853", 1e-8)) - exact).max() < 1e-3


@pytest.mark.parametrize("name", contenders.PEERS)
def test_a_peer_snaps_when_the_judge_does(scene, name):
    pytest.importorskip(name, reason=MISSING)
    peer = next(one for one in contenders.contenders() if one.solver == name)
    exact = snaps(scene, by_short_steps(scene.equations, 0.004))
    assert abs(snaps(scene, peer.make(scene)) - exact).max() < 0.2  # diffrax at the step's end
    assert scene.errors(peer.make(scene)).max() < 3e-6


def snaps(scene, follow):
    """When rows snap, us, 1 % above their thresholds."""
    return scene.asked(follow)(1.01 * scene.N[:, np.newaxis])[:, 0]


def test_a_lone_search_finds_the_lowest_snap_however_many_it_asks_at_once():
    def ask(N):
        return np.where((N > 1000.0) & (N < 2000.0), 1.0, np.nan)

    for width in (1, 4, 16):
        N, runs = lowest_snap(ask, width)
        assert abs(N / 1000 - 1) < 1e-4 and runs % width == 0
    assert np.isnan(lowest_snap(partial(np.full_like, fill_value=np.nan), 3)[0])


def test_what_is_not_installed_is_told(monkeypatch, handout):
    monkeypatch.setattr(contenders, "find_spec", lambda name: None)
    monkeypatch.setattr(opensees, "find_spec", lambda name: None)
    names = {one.solver for one in contenders.contenders()}
    assert not names & {*contenders.PEERS} and {"SciPy", "numba loop", "snapmap"} < names
    told = [[name, "not installed"] for name in contenders.PEERS]
    assert measure.map_table([]).rows == told
    assert structure.structure_table(handout).rows == [["openseespylinux is not installed"]]


def test_opensees_pushes_a_beam_as_a_shallow_one(handout):
    try:
        opensees.load()
    except ImportError as error:
        pytest.skip(str(error))
    beam, path = handout.beam, statics(handout)
    theirs, _ = structure.limit([structure.unbent(beam, n) for n in (20, 40, 80)])
    assert np.allclose([path.largest_force.item(), path.least_force.item()], theirs, rtol=0.003)
