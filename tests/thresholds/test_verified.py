"""Surfaces of thresholds: which rows are searched, which verified, and that both agree."""

import numpy as np
import pytest
import xarray as xr

import snapmap
from snapmap import Study
from snapmap.numerics.portable import linear
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds import verified
from snapmap.thresholds.probe import Probe, nearby
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


def test_a_threshold_near_a_guess_does_not_depend_on_it(handout):
    model = build_model(handout, Cosines(modes=3))
    rows = to_rows(0, 1000.0, np.full(4, 25.0))
    known = snapmap.threshold(Study(handout, **HOW), [1000.0], **ASKED)
    guess = known.N_first.item() * np.array([0.9994, 1.0, 1.0006, 1.01])
    _, N = nearby(Probe(model, rows, Run(horizon=300.0)), guess, 1e-4)
    assert N[0] == N[1] == N[2] == pytest.approx(known.N_first.item(), rel=1e-4)
    assert np.isnan(N[3])


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
    xr.testing.assert_identical(
        snapmap.threshold(Study(handout, **HOW), f0, **ASKED, axes={"thickness": thickness}), whole
    )
