"""Runs to the end, which change their step: nothing of a run moves by that but its fineness."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from varied import varied

from snapmap.device.device import batch
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.lanes import Facts, Task, change_step
from snapmap.solver.kernel.step import advance
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.outcome import side_at_end
from snapmap.solver.settings import EDGE, SNAP, STAY, Run
from snapmap.solver.simd_loop import begin, coefficients

HORIZON = 3000.0


@pytest.fixture(scope="module")
def damped(handout):
    return batch([varied(handout, damping=4e-3)])


def random_cells(device, number, seed=1):
    rng = np.random.default_rng(seed)
    f0 = np.exp(rng.uniform(np.log(300.0), np.log(2e4), number))
    return to_cells(device, 0, rng.uniform(700.0, 4000.0, number), f0, 25.0, HORIZON)


def in_one_step(model):
    """The model in the steps of STAY from the start on."""
    stay = model.steps.longest[STAY]
    longest = dict(model.steps.longest) | {SNAP: stay, EDGE: stay}
    steps = replace(model.steps, longest=longest, shortest=stay, pressed=stay, most=np.inf * stay)
    return replace(model, steps=steps)


def follow(model, cells, until):
    return model.follow(cells, Run(horizon=HORIZON).but(until=until))


def test_until_the_snap_a_run_to_the_end_is_that_to_the_snap(damped):
    model, cells = build_model(damped, Cosines(modes=5)), random_cells(damped, 64)
    to_snap, to_end = (follow(model, cells, until) for until in ("snap", "settled"))
    np.testing.assert_array_equal(to_end.t_snap, to_snap.t_snap)
    assert np.isfinite(to_end.t_snap).sum() > 40 and (to_end.energy_error < 1e-9).all()


def test_ends_and_work_are_those_of_runs_in_the_shorter_step(damped):
    model, cells = build_model(damped, Cosines(modes=5)), random_cells(damped, 96)
    ours, all_short = (follow(each, cells, "end") for each in (model, in_one_step(model)))
    both = np.isfinite(ours.t_snap) & np.isfinite(all_short.t_snap)
    ends = [side_at_end(run, 1e-3)[both] for run in (ours, all_short)]
    assert both.sum() > 60 and np.mean(ends[0] == ends[1]) > 0.9
    work = ours.pulse_work[both] / all_short.pulse_work[both]
    assert np.median(abs(work - 1)) < 1e-2


@pytest.mark.parametrize("contact", [40.0, np.inf])
def test_a_step_changed_to_and_fro_leaves_a_run_as_it_was(damped, contact):
    """In shorter steps all energies but the stretch's are as before; back again, all is."""
    device = replace(damped, contact=np.full(1, contact))
    model, dt = build_model(device, Cosines(modes=5)), np.full(1, 0.05)
    cells = to_cells(device, 0, [3000.0], 5e3, 25.0, HORIZON).take(np.zeros(1, int))
    (work, shape, laws, state, pulses), _ = begin(model, cells, dt, "first")
    shocks = np.zeros(128 * R.LANES)
    shocks[:: R.LANES] = 3e4 * device.gravity * dt**2
    advance(work, shape, laws, shocks, 0, 128)
    state.steps[0] += 128
    facts, steps = Facts(*np.zeros((7, 1))), (dt, dt / 4, dt)
    task = Task(coefficients(model, -np.inf), pulses, *cells[:6], *steps, False, 1.0, facts)
    X = work[: R.VECTORS * R.LANES].reshape(-1, R.LANES)[:, 0]
    motion = work[R.VECTORS * R.LANES :].reshape(-1, R.LANES)[: R.U * 5, 0]
    before, moved = X.copy(), motion.copy()
    change = njit(lambda *given: change_step(*given))
    change(work, shape, laws, 0, dt[0] / 4, 0, state, task)
    assert X[R.DT] <= dt[0] / 4 and X[R.OVERLAP] == before[R.OVERLAP]
    energy = before[R.M] * before[R.DY] ** 2 / dt[0] ** 2
    assert X[R.M] * X[R.DY] ** 2 / X[R.DT] ** 2 == pytest.approx(energy, rel=1e-12)
    change(work, shape, laws, 0, dt[0], 0, state, task)
    state_rows = slice(R.STATE, R.VECTORS)
    np.testing.assert_allclose(X[state_rows], before[state_rows], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(motion, moved, rtol=1e-9, atol=1e-12)
    assert state.steps[0] == 128
