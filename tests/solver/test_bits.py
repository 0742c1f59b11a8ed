"""The same bits in any company: of other cells, in any order, on threads, and in a batch."""

import numpy as np
import pytest
from varied import varied

import snapmap
from snapmap import Study
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import batch
from snapmap.solver import simd_loop
from snapmap.solver.adaptive import choose_model
from snapmap.solver.cells import no_observations, to_cells
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.models import build_model
from snapmap.solver.options import Auto, Cosines, Elements
from snapmap.solver.outcome import FAILED, NEVER
from snapmap.solver.settings import Run
from studies.random_devices import draw_widest_device


def test_a_cell_does_not_depend_on_order_number_or_threads(handout):
    rng = np.random.default_rng(5)
    model = build_model(handout, Cosines(modes=3))
    N, f0 = rng.uniform(600, 2400, 5 * LANES + 3), rng.uniform(300, 2e4, 5 * LANES + 3)
    cells = to_cells(handout, 0, N, f0, 0.025, 300.0)
    together, order = model.follow(cells, Run())[:6], rng.permutation(N.size)
    shuffled = model.follow(cells.take(order), Run(threads=2))[:6]
    first = model.follow(cells.take(slice(1)), Run())[:6]
    for whole, mixed, single in zip(together, shuffled, first, strict=True):
        np.testing.assert_array_equal(whole[order], mixed)
        np.testing.assert_array_equal(whole[:1], single)


def test_threads_share_no_cells_that_one_has_lanes_for(handout, monkeypatch):
    model = build_model(handout, Cosines(modes=3))
    sizes = []

    def march(model, cells, dt, settings):
        sizes.append(cells.f0.size)
        return no_observations(cells.f0.shape)[:7]

    monkeypatch.setattr(simd_loop, "march", march)
    for size in (1, LANES, LANES + 1, 8 * LANES):
        cells = to_cells(handout, 0, np.full(size, 900.0), 1500.0, 0.025, 300.0)
        model.follow_once(cells, Run(threads=4))
    assert sorted(sizes) == sorted([1, LANES, LANES // 2 + 1, LANES // 2, *[2 * LANES] * 4])


def test_a_hopeless_cell_is_failed_and_the_rest_goes_on(handout):
    cube = snapmap.sweep(Study(handout, "cosines"), N=[900.0, 1e200], f0=[1500.0], C=[25.0])
    assert cube.outcome.values.ravel().tolist() == [NEVER, FAILED]


MODELS = {"all modes": Elements(), "elements": Elements(elements=10, modes=5)}
MODELS |= {"cosines": Cosines(modes=3), "auto": Auto()}


@pytest.fixture(scope="module")
def devices():
    """Devices at random: uneven, free to tilt, with stops, a hard contact or a damped beam."""
    draw = np.random.default_rng(11)
    return [varied(draw_widest_device(draw), damping=4e-4 * (i % 2)) for i in range(5)]


@pytest.mark.parametrize(
    "name", [pytest.param("all modes", marks=pytest.mark.long), "elements", "cosines", "auto"]
)
def test_a_device_in_a_batch_does_what_it_does_alone(devices, name):
    if name in ("elements", "auto"):  # with the tilting modes of free ones kernels take a minute
        devices = [device for device in devices if not device.beam.free]
    if name == "all modes":  # its modes depend on the contact
        devices = [device for device in devices if np.isfinite(device.contact)]
    together, settings = choose_model(batch(devices), MODELS[name]), Run(horizon=200.0)
    N = np.outer([static_threshold(device) for device in devices], np.linspace(0.7, 2.0, 14))
    f0, number = np.array([[700.0], [3000.0]]), np.arange(len(devices))[:, np.newaxis]
    loads = np.tile(N, (2, 1)), np.repeat(f0, len(devices), axis=0), 5.0, 200.0
    mixed = together.follow(to_cells(together.device, np.tile(number, (2, 1)), *loads), settings)
    assert 0.2 < np.isfinite(mixed.t_snap).mean() < 0.9
    for i, device in enumerate(devices):
        cells = to_cells(device, 0, N[[i, i]], f0, 5.0, 200.0)
        for model in (choose_model(device, MODELS[name]), together.pick(i)):
            for whole, alone in zip(mixed, model.follow(cells, settings), strict=True):
                if alone is not None:
                    np.testing.assert_array_equal(whole[[i, i + len(devices)]], alone)


@pytest.mark.parametrize(
    ("model", "contacts"), [("cosines", [40.0, 60.0]), ("auto", [40.0, np.inf])]
)
def test_thresholds_of_a_batch_are_those_of_each_device(handout, model, contacts):
    how = {"model": model, "horizon": 300.0}
    asked = {"f0": [1500.0, 9000.0], "C": [0.025, 25.0]}
    together = snapmap.threshold(Study(handout, **how), **asked, axes={"contact": contacts})
    for contact in contacts:
        alone = snapmap.threshold(Study(varied(handout, contact=contact), **how), **asked)
        slice_of_all = together.sel(contact=contact)
        for name in alone:
            single, whole = alone[name].values, slice_of_all[name].values
            if "island" in alone[name].dims:
                whole, beyond = np.split(whole, [single.shape[-1]], axis=-1)
                assert np.isnan(beyond).all()
            np.testing.assert_array_equal(whole, single, err_msg=name)
    assert (together.islands > 0).any()
