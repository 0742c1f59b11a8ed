"""The SIMD kernel against the plain loop, against itself, and past its limits."""

import re

import numpy as np
import pytest
from varied import in_steps, varied

import snapmap
from snapmap.solver import simd_loop
from snapmap.solver.cells import no_observations, to_cells, to_rows
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.models import build_model
from snapmap.solver.outcome import FAILED, NEVER
from snapmap.solver.plain_loop import System, follow
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import lowest_snap


def threshold(device, name, C=0.025, step=None, **size):
    model, settings = build_model(device, name, **size), Settings(300.0, until="snap")
    model = in_steps(model, step) if step else model
    return lowest_snap(model, to_rows(0, 1500.0, C), (700.0, 1100.0), settings, 1e-6).item()


def test_the_handouts_elements_have_the_threshold_of_the_reference(handout):
    """In small steps: two schemes of one equation."""
    reference = threshold(handout, "reference", 25.0, step=0.4, elements=3)
    fast = threshold(handout, "elements", 25.0, step=0.2, elements=3)
    assert fast == pytest.approx(reference, rel=1e-5)


def test_hard_contact_is_the_limit_of_a_rising_penalty(handout):
    size = {"elements": 20, "modes": 9}
    hard, *soft = (varied(handout, contact=k) for k in (np.inf, 40.0, 400.0, 4000.0))
    limit = threshold(hard, "cosines", modes=9, step=0.25)
    assert threshold(hard, "elements", **size, step=0.25) == pytest.approx(limit, rel=2e-4)
    shifts = [threshold(device, "elements", **size) / limit - 1 for device in soft]
    assert shifts[0] == pytest.approx(0.08, abs=0.005)
    assert shifts[0] > 8 * shifts[1] > 0 and shifts[1] > 5 * shifts[2] > 0


def test_a_cell_does_not_depend_on_order_number_or_threads(handout):
    rng = np.random.default_rng(5)
    model = build_model(handout, "cosines", modes=3)
    N, f0 = rng.uniform(600, 2400, 5 * LANES + 3), rng.uniform(300, 2e4, 5 * LANES + 3)
    cells = to_cells(handout, 0, N, f0, 0.025, 300.0)
    together, order = model.follow(cells, Settings())[:6], rng.permutation(N.size)
    shuffled = model.follow(cells.take(order), Settings(threads=2))[:6]
    first = model.follow(cells.take(slice(1)), Settings())[:6]
    for whole, mixed, single in zip(together, shuffled, first, strict=True):
        np.testing.assert_array_equal(whole[order], mixed)
        np.testing.assert_array_equal(whole[:1], single)


def test_threads_share_no_cells_that_one_has_lanes_for(handout, monkeypatch):
    model = build_model(handout, "cosines", modes=3)
    sizes = []

    def march(model, cells, dt, settings):
        sizes.append(cells.f0.size)
        return no_observations(cells.f0.shape)[:7]

    monkeypatch.setattr(simd_loop, "march", march)
    for size in (1, LANES, LANES + 1, 8 * LANES):
        cells = to_cells(handout, 0, np.full(size, 900.0), 1500.0, 0.025, 300.0)
        model.follow_once(cells, Settings(threads=4))
    assert sorted(sizes) == sorted([1, LANES, LANES // 2 + 1, LANES // 2, *[2 * LANES] * 4])


def test_a_hopeless_cell_is_failed_and_the_rest_goes_on(handout):
    cube = snapmap.sweep(handout, N=[900.0, 1e200], f0=[1500.0], C=[25.0], model="cosines")
    assert cube.outcome.values.ravel().tolist() == [NEVER, FAILED]


def test_every_row_and_every_variable_stands_in_the_table_of_symbols(root):
    section = (root / "docs" / "theory.md").read_text().split("## Symbols")[1].split("\n## ")[0]
    table = [line.split("|")[1:3] for line in section.splitlines() if line.startswith("| ")]
    in_kernel, in_plain_loop = (
        re.findall(r"`(\w+)`", " ".join(c)) for c in zip(*table, strict=True)
    )
    bounds = {"LANES", "STATE", "VECTORS"}
    assert sorted(in_kernel) == sorted({name for name in vars(R) if name.isupper()} - bounds)
    assert set(System._fields) <= set(in_plain_loop)
    assert set(in_plain_loop) <= {*System._fields, *follow.py_func.__code__.co_varnames}
