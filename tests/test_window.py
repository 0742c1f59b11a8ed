"""Where over two axes required shocks are met."""

from dataclasses import replace

import numpy as np
import pytest

import snapmap
from snapmap.motion.history import extremes_of
from snapmap.shocks import make_shocks
from snapmap.solver.settings import Settings
from snapmap.study import Study
from snapmap.tolerances.samples import Tolerances
from snapmap.window import summary, window_of

CHEAP = {"model": "cosines", "modes": 3, "horizon": 300.0}
AXES = {"thickness": np.linspace(1.9, 2.4, 6), "C": [25.0, 60.0]}
SCATTERS = {"thickness": 0.05, "N": "2 %"}
NEEDS = [
    {"name": name, "N": N, "f0": 1500.0, "snaps": snaps, "survives": 0.999, "shocks": make_shocks()}
    for name, N, snaps in (("trip", 1300.0, True), ("stay", 1100.0, False))
]


@pytest.fixture(scope="module")
def study(handout):
    device, model = replace(handout, strength=1e3), {"name": "cosines", "modes": 3}
    return Study(device=device, model=model, settings=Settings(horizon=300.0))


@pytest.fixture(scope="module")
def found(study):
    return window_of(study, AXES, NEEDS, Tolerances(SCATTERS, samples=32))


def test_a_window_ends_where_a_design_does(handout, found):
    asked = {"C": 25.0, "between": (1.9, 2.4), "requirements": NEEDS}
    one, reserve = snapmap.design(handout, "thickness", **asked, **CHEAP), found.reserve.sel(C=25.0)
    for name, end in (("stay", one.low), ("trip", one.high)):
        along = reserve.sel(requirement=name).sortby(reserve.sel(requirement=name))
        assert np.interp(1.0, along, along.thickness) == pytest.approx(end.item(), abs=2e-3)
    met = int((found.reserve.min("requirement") >= 1).sum())
    assert f"met at {met} of 12 points" in summary(found)


def test_its_yields_and_stresses_are_those_of_one_device(handout, study, found):
    device = replace(handout, beam=replace(handout.beam, thickness=2.1))
    asked = {"requirements": NEEDS, "samples": 32, "index_samples": 2}
    made = snapmap.tolerance(device, SCATTERS, [1500.0], AXES["C"], **asked, **CHEAP)
    here = found.sel(thickness=2.1, method="nearest")
    np.testing.assert_array_equal(here["yield"], made["yield"])
    np.testing.assert_array_equal(here.yield_bound, made.yield_bound)
    for required in NEEDS:
        one = extremes_of(replace(study, device=device), required["N"], 1500.0, 60.0)
        stress = here.stress_max.sel(requirement=required["name"], C=60.0).item()
        assert stress == pytest.approx(one.stress_max, rel=1e-6)


def test_where_the_beam_breaks_a_requirement_fails(study, found):
    limit = found.stress_max.median().item()
    brittle = replace(study, device=replace(study.device, strength=limit))
    reserve = window_of(brittle, AXES, NEEDS).reserve
    np.testing.assert_array_equal(reserve, found.reserve.where(found.stress_max < limit, 0))
    # With a strength that scatters it fails where more than one in ten breaks.
    modulus, share = 8.0, 0.9
    scale = limit / (-np.log(share)) ** (1 / modulus)
    device = replace(study.device, strength=scale, strength_modulus=modulus)
    needs = [NEEDS[0] | {"survives": share}, NEEDS[1] | {"snaps": "any", "survives": share}]
    trip, any_way = window_of(replace(study, device=device), AXES, needs).reserve
    unbroken = found.stress_max < limit
    assert 0 < unbroken.mean() < 1
    np.testing.assert_array_equal(trip, found.reserve[0].where(unbroken[0], 0))
    np.testing.assert_array_equal(any_way, np.where(unbroken[1], np.inf, 0))


def test_under_several_shocks_the_worst_counts(study):
    axes, shapes = {"thickness": [2.0, 2.2], "C": [25.0]}, ["half sine", "versed sine"]
    alone = [window_of(study, axes, [NEEDS[1] | {"shocks": make_shocks(one)}]) for one in shapes]
    both = window_of(study, axes, [NEEDS[1] | {"shocks": make_shocks(shapes)}])
    least = np.minimum(alone[0].reserve, alone[1].reserve)
    np.testing.assert_array_equal(both.reserve, least)
    np.testing.assert_array_equal(both.N_first, least * 1100)
    np.testing.assert_array_equal(
        both.stress_max, np.maximum(alone[0].stress_max, alone[1].stress_max)
    )
