"""The SIMD kernel against the plain loop, against itself, and past its limits."""

import dataclasses
import re

import numba
import numpy as np
import pytest
from numba.core.codegen import get_host_cpu_features

import snapmap
from snapmap.device import batch
from snapmap.solver import simd_loop
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.pulse import BLOCK, go_on
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.kernel.step import advance
from snapmap.solver.models import build_model
from snapmap.solver.outcome import FAILED, NEVER, label
from snapmap.solver.plain_loop import System, follow
from snapmap.solver.settings import Settings


def threshold(device, f0, C=0.025, horizon=300.0, low=700.0, high=1100.0, **model):
    """Lowest N that snaps, by refining a grid of one lane call at a time, to 1e-6."""
    while high - low > 1e-6 * high:
        N = np.linspace(low, high, 17)
        cube = snapmap.sweep(device, N=N, f0=[f0], C=[C], horizon=horizon, until="snap", **model)
        first = int(np.argmax(np.isfinite(cube.t_snap.values.ravel())))
        low, high = N[first - 1], N[first]
    return high


def labels(follow, cells):
    return label(*follow(cells, Settings())[:4], Settings().energy_tolerance)


@pytest.fixture(scope="module")
def hard(handout):
    return dataclasses.replace(handout, contact=np.inf)


@pytest.mark.parametrize("mass_matrix", ["consistent", "hrz"])
def test_the_handouts_elements_have_the_threshold_of_the_reference(handout, mass_matrix):
    """In small steps: two schemes of one equation."""
    asked = {"elements": 3, "mass_matrix": mass_matrix}
    found = threshold(handout, 1500.0, C=25.0, model="handout", step=0.2, **asked)
    reference = threshold(handout, 1500.0, C=25.0, model="reference", step=0.4, **asked)
    assert found == pytest.approx(reference, rel=1e-5)


def test_the_history_is_the_sweeps_run(handout):
    """Both see the same midpoint at the same instants: the snap times agree to the last bit."""
    cell = {"N": 1000.0, "f0": 1500.0, "C": 0.025, "model": "cosines", "horizon": 300.0}
    run = snapmap.simulate(handout, **cell, step=0.1)
    after = int(np.argmax(run.w_mid.values <= handout.beam.second_equilibrium))
    t, w = run.time.values[after - 1 : after + 1], run.w_mid.values[after - 1 : after + 1]
    crossing = t[0] + (w[0] - handout.beam.second_equilibrium) / (w[0] - w[1]) * (t[1] - t[0])
    cube = snapmap.sweep(
        handout, **{k: [cell[k]] for k in ("N", "f0", "C")}, model="cosines", step=0.1
    )
    assert crossing == pytest.approx(float(cube.t_snap.squeeze()), rel=1e-4)


@pytest.mark.parametrize("model", ["handout", "cosines", "elements"])
def test_no_pulse_no_motion_to_the_last_bit(handout, model):
    run = snapmap.simulate(handout, N=0.0, f0=1500.0, C=0.025, model=model)
    assert (run.w_mid == handout.beam.rise).all() and (run.z_mass == handout.beam.rise).all()
    assert not run.kinetic_energy.any() and not run.bending_energy.any()


@pytest.mark.parametrize("f0", [500.0, 1500.0])
def test_few_cosines_give_the_converged_threshold(handout, hard, f0):
    for device in (handout, hard):
        converged = threshold(device, f0, model="cosines", modes=12, step=0.25)
        for modes in (3, 4):
            found = threshold(device, f0, model="cosines", modes=modes)
            assert found == pytest.approx(converged, rel=5e-4)


def test_elements_converge_to_the_cosines(handout):
    converged = threshold(handout, 1500.0, model="cosines", modes=12, step=0.25)
    errors = [
        threshold(handout, 1500.0, model="elements", elements=n, step=0.25) / converged - 1
        for n in (5, 10)
    ]
    assert errors[0] == pytest.approx(1.5e-3, rel=0.1)
    assert 3.5 < np.log2(errors[0] / errors[1]) < 4.5


def test_hard_contact_is_the_limit_of_a_rising_penalty(handout, hard):
    limit = threshold(hard, 1500.0, model="cosines", modes=8, step=0.25)
    by_elements = threshold(hard, 1500.0, model="elements", elements=20, modes=8, step=0.25)
    assert by_elements == pytest.approx(limit, rel=2e-4)
    shifts = [
        threshold(
            dataclasses.replace(handout, contact=penalty),
            1500.0,
            model="elements",
            elements=20,
            modes=8,
        )
        / limit
        - 1
        for penalty in (40.0, 400.0, 4000.0)
    ]
    assert shifts[0] == pytest.approx(0.08, abs=0.005)
    assert shifts[0] > 8 * shifts[1] > 0 and shifts[1] > 5 * shifts[2] > 0


def test_the_handouts_elements_with_hard_contact(handout, hard):
    """Leaving out the highest modes costs less than 0.03 % against ever stiffer penalties."""
    stiff = [
        threshold(dataclasses.replace(handout, contact=penalty), 1500.0, model="handout", step=0.3)
        for penalty in (2.5e4, 1e5)
    ]
    limit = stiff[1] + (stiff[1] - stiff[0]) / 3
    assert threshold(hard, 1500.0, model="handout") == pytest.approx(limit, rel=3e-4)


def test_lanes_with_different_devices_give_what_each_gives_alone(handout):
    """To the last bit, each in its own steps, however the cells are mixed."""
    beam = handout.beam
    others = [
        handout,
        dataclasses.replace(handout, mass=0.8e4, spring=7.0, contact=60.0),
        dataclasses.replace(handout, beam=dataclasses.replace(beam, thickness=2.2, span=620.0)),
    ]
    model = build_model(batch(others), "cosines", modes=4)
    device_of = np.arange(75) % 3
    cells = to_cells(model.device, device_of, np.linspace(700, 1900, 75), 1500.0, 5.0, 300.0)
    dt = np.array([0.05, 0.4, 0.11])[device_of]
    mixed = simd_loop.march(model, cells.take(np.arange(75)), dt, Settings())
    for number, device in enumerate(others):
        mine = device_of == number
        single = build_model(device, "cosines", modes=4)
        own = cells.take(mine)._replace(device=np.zeros(mine.sum(), int))
        found = simd_loop.march(single, own, dt[mine], Settings())
        for together, alone in zip(mixed, found, strict=True):
            np.testing.assert_array_equal(together[mine], alone)
    assert np.isfinite(mixed[0]).any() and np.isnan(mixed[0]).any()


def test_a_cell_does_not_depend_on_order_number_or_threads(handout):
    rng = np.random.default_rng(5)
    model = build_model(handout, "cosines", modes=3)
    N, f0 = rng.uniform(600, 2400, 5 * LANES + 3), rng.uniform(300, 2e4, 5 * LANES + 3)
    cells = to_cells(handout, 0, N, f0, 0.025, 300.0)
    together = model.follow(cells, Settings())[:6]
    order = rng.permutation(N.size)
    shuffled = model.follow(cells.take(order), Settings(threads=2))[:6]
    one = model.follow(cells.take(slice(1)), Settings())[:6]
    for whole, mixed, single in zip(together, shuffled, one, strict=True):
        np.testing.assert_array_equal(whole[order], mixed)
        np.testing.assert_array_equal(whole[:1], single)


@pytest.mark.parametrize("factor", [1.3, 2.0, 50.0])
def test_a_blow_up_of_the_reference_is_failed(handout, factor):
    """Steps over the limit: no cell may pass for unsnapped or snapped."""
    model = build_model(handout, "reference", elements=2, step=1.0)
    cells = to_cells(handout, 0, np.linspace(1000, 2400, 5), 1500.0, 0.025, 300.0)
    assert (labels(model.with_step(factor).follow_once, cells) == FAILED).all()


def test_a_hopeless_cell_is_failed_and_the_rest_goes_on(handout):
    cube = snapmap.sweep(handout, N=[900.0, 1e200], f0=[1500.0], C=[25.0], model="cosines")
    assert cube.outcome.values.ravel().tolist() == [NEVER, FAILED]


def test_a_failed_ledger_is_given_smaller_steps(handout):
    """At a rough step some ledgers do not close; the retries close them."""
    model = build_model(handout, "reference", elements=2, step=1.0)
    N, f0 = np.meshgrid(np.linspace(600, 2400, 6), np.geomspace(1e3, 3e4, 6))
    cells = to_cells(handout, 0, N.ravel(), f0.ravel(), 0.025, 300.0)
    assert (labels(model.follow_once, cells) == FAILED).any()
    assert not (labels(model.follow, cells) == FAILED).any()


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


@pytest.mark.skipif("+avx512f" not in get_host_cpu_features(), reason="no vectors of 512 bits")
def test_kernels_take_the_widest_vectors_and_leave_other_functions_alone():
    """LLVM by itself stops at 256 bits on some processors that have more."""
    X, shocks = simd_loop.work_array(2), np.zeros(BLOCK * LANES)
    asked = {
        advance: (X, (0, 0), shocks, 0, 1),
        go_on: (X, shocks),
    }
    for function, arguments in asked.items():
        kernel = numba.njit(error_model="numpy")(function.py_func)
        kernel(*arguments)
        assert "zmm" in "".join(kernel.inspect_asm().values())
    assert (numba.config.CPU_NAME, numba.config.CPU_FEATURES) == (None, None)
