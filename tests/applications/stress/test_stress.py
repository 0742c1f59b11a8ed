"""The largest stress of cells, against their histories."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from small_results import AXES, SETTINGS, swept
from varied import varied

import snapmap
from snapmap.applications.stress import application
from snapmap.applications.stress.stress import _window, stress_of_cube
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import MOVE
from snapmap.study.study import Study


@pytest.fixture(scope="module")
def brittle(handout):
    """Of a Weibull strength, of which 63 % break at 1500 MPa."""
    return replace(handout, strength=1300.0, strength_threshold=200.0, strength_modulus=8.0)


def stress_of(device, cube, settings=SETTINGS):
    model = json.loads(cube.attrs["config"])["model"]
    return stress_of_cube(Study(device, model=model, **vars(settings)), cube)


@pytest.fixture(scope="module")
def cube(brittle):
    return swept(brittle)


@pytest.fixture(scope="module")
def stress(brittle, cube):
    return stress_of(brittle, cube, SETTINGS.but(threads=2))


@pytest.mark.parametrize(("N", "C"), [(800.0, 200.0), (2200.0, 200.0), (1000.0, 0.025)])
def test_the_largest_stress_is_that_of_the_history(brittle, cube, stress, monkeypatch, N, C):
    """To a swing beyond the proof."""
    monkeypatch.setattr("snapmap.applications.histories.history.SAMPLES", 10**6)
    shock, model = {"N": N, "f0": 1000.0, "C": C}, Cosines(modes=3)
    run = snapmap.simulate(Study(brittle, model, horizon=SETTINGS.horizon), **shock)
    dt = build_model(brittle, model).steps.of(to_cells(brittle, 0, *shock.values(), 0.0), MOVE)
    window = cube.t_settled.sel(shock).item() + 2 * np.pi / brittle.own_frequency
    window = run.time.values[-1] if np.isnan(window) else window
    steps = int(np.ceil(window / dt.item()))
    largest = run.stress.values[:steps].max()
    assert stress.stress_max.sel(shock).item() == pytest.approx(largest, rel=1e-6)
    assert stress.strength == 1500


def test_the_stress_does_not_depend_on_threads_or_order(brittle, cube, stress):
    mixed = cube.isel(N=[2, 0, 3, 1], f0=[1, 2, 0])
    xr.testing.assert_equal(stress_of(brittle, mixed), stress)


def test_devices_have_the_stress_of_each_alone(brittle):
    """Also those of two kinds of model, with a contact that is hard and one that is not."""
    points, asked = {"thickness": [1.8, 4.4], "contact": [40.0, np.inf]}, {**AXES, "cosines": 4}
    whole = stress_of(brittle, swept(brittle, **asked, **points, skip=True)).stress_max
    for contact in points["contact"]:
        device = varied(brittle, thickness=1.8, contact=contact)
        alone = stress_of(device, swept(device, **asked)).stress_max
        np.testing.assert_array_equal(whole.sel(thickness=1.8, contact=contact), alone)
    assert whole.sel(thickness=4.4).isnull().all()


@pytest.mark.parametrize(("until", "first"), [("snap", 30.0), ("end", 100.0)])
def test_a_cell_is_followed_for_a_swing_beyond_its_proof_or_to_its_end(until, first):
    """Of two frequencies; the first cell snaps, the second settles, the third swings on."""
    cells = SimpleNamespace(device=np.array([0, 1, 1]), t_end=np.full(3, 100.0))
    device = SimpleNamespace(own_frequency=np.array([0.1, 0.2]))
    cube = {"t_settled": [np.nan, 50.0, np.nan], "t_snap": [30.0, 20.0, np.nan]}
    cube = xr.Dataset({key: ("N", column) for key, column in cube.items()})
    expected = [first, 50 + 10 * np.pi, 100.0]
    assert _window(device, cube, cells, SETTINGS.but(until=until)) == pytest.approx(expected)


def test_stress_is_sought_where_a_device_may_break(handout, brittle):
    for device, outputs in ((handout, {}), (brittle, {"stress": "results/stress.nc"})):
        assert application.outputs(Study(device)) == outputs
