"""What is called proven: the barrier, the labels, and runs that try to prove the labels wrong."""

from dataclasses import replace

import numpy as np
import pytest
from varied import in_steps, varied

import snapmap
from snapmap import Study
from snapmap.applications.histories.motion import record
from snapmap.device.device import batch
from snapmap.solver.cells import Observations, to_cells
from snapmap.solver.kernel.pulse import BLOCK
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.outcome import LATCHED, NEVER, OUTCOMES, RETURNED, label
from snapmap.solver.settings import Run

PROVEN = (NEVER, LATCHED, RETURNED)


def test_labels_say_what_was_observed():
    nan = np.nan
    t_snap = [nan, nan, 5, 5, 5, 5, nan, nan]
    t_settled, well = [nan, 9, nan, 9, 9, 9, nan, 9], [0, 1, 0, 2, 1, 2, 0, 1]
    columns = t_snap, t_settled, well, [0, 0, 0, 0, 0, 0.1, nan, np.inf]
    seen = Observations(*map(np.array, columns), *[None] * 4)
    told = " ".join(OUTCOMES[number] for number in label(seen, 1e-3))
    assert told == "unsnapped never snapped latched returned failed failed failed"
    assert OUTCOMES[LATCHED] == "latched"


def random_cells(number, seed, C):
    rng = np.random.default_rng(seed)
    f0 = np.exp(rng.uniform(np.log(400), np.log(2e4), number))
    return rng.uniform(700, 1500, number), f0, rng.choice(C, number)


def recorded(model, cells, i, dt, steps):
    """Times, us, and w(L/2), um, of one of the cells."""
    end = np.array([(steps - 0.5) * dt])
    form, motions = record(model, cells.take([i])._replace(t_end=end), np.array([dt]))
    return np.hstack([(part.time, part.u @ form.midpoint) for part in motions])


def test_a_latched_beam_never_rises_past_the_saddle_again(handout):
    """Followed on in the same steps, the midpoint of a latched beam never rises past the saddle."""
    device = varied(handout, damping=4e-4)
    model, saddle = in_steps(build_model(device, Cosines(modes=3)), 1.0), -device.beam.rise / 3
    cells = to_cells(device, 0, *random_cells(30, 2, [25.0, 200.0]), 6000.0)
    seen, dt = model.follow_once(cells, Run(horizon=6000.0)), model.time_steps(cells, Run())
    outcome = label(seen, Run().energy_tolerance)
    snapped = np.flatnonzero(np.isin(outcome, (LATCHED, RETURNED)))
    for i in snapped:
        time, w = recorded(model, cells, i, dt[i], int(2e4 / dt[i]))
        after = device.beam.rise + w[time >= seen.t_settled[i]]
        assert (after < saddle).all() if outcome[i] == LATCHED else (after > saddle).all()
    assert snapped.size > 10


@pytest.mark.parametrize("contact", [40.0, np.inf])
def test_a_run_whose_energy_error_exceeds_its_margin_proves_nothing(handout, contact):
    """On purpose: the roughest steps. What is proven must be what a fine step shows."""
    device = varied(handout, contact=contact)
    N, *others = random_cells(100, 3, [0.025, 25.0])
    model, settings = build_model(device, Cosines(modes=3)), Run(horizon=3000.0)

    def follow(N, step):
        return in_steps(model, step).follow(to_cells(device, 0, N, *others, 3000.0), settings)

    nearby = np.isnan(follow(N * np.array([[0.98], [1.0], [1.02]]), 0.1).t_snap)
    away = (nearby[0] == nearby[1]) & (nearby[1] == nearby[2])
    for step in (0.8, 1.0):
        seen = follow(N, step)
        outcome = label(seen, settings.energy_tolerance)
        proven = np.isin(outcome, PROVEN)
        assert (seen.energy_error[proven] <= Run().energy_tolerance).all()
        never = (outcome == NEVER) & away
        assert never.sum() > 20 and nearby[1][never].all()


def test_a_run_proves_nothing_while_it_keeps_more_energy_than_the_barrier(handout):
    """Without damping that is the work of the pulse."""
    N, shares = [600.0, 750.0, 850.0, 870.0, 880.0], [*(1 - np.geomspace(1e-7, 1e-2, 11)), 2.0]

    def follow_under(energy, device, which, N):
        built = in_steps(build_model(device, Elements()), 1.0)
        built = replace(built, barrier=built.barrier._replace(energy=energy))
        return built.follow_once(to_cells(device, which, N, 3e3, 0.0, 3e3), Run(horizon=3e3))

    work = follow_under(0.0, handout, 0, N).pulse_work
    barriers = np.outer(work, shares).ravel()
    many = batch([handout] * barriers.size)
    seen = follow_under(barriers, many, np.arange(barriers.size), np.repeat(N, len(shares)))
    proven = np.isfinite(seen.t_settled).reshape(len(N), -1)
    assert proven[:, -1].all() and not proven[:, :-1].any()


def test_a_snap_seen_together_with_the_end_of_its_pulse_is_followed_on(root):
    device = snapmap.load_device(root / "config" / "sensor.yaml")
    N, f0 = np.linspace(1240.0, 1280.0, 41), np.linspace(7900.0, 8000.0, 5)
    asked = {"model": {"name": "cosines", "cosines": 3}, "horizon": 4000, "pulse": "half sine"}
    cube = snapmap.sweep(Study(device, **asked), N, f0, [100.0])
    assert not np.isin(cube.outcome.where(cube.well == 0), PROVEN).any()
    to_snap = snapmap.sweep(Study(device, until="snap", **asked), N, f0, [100.0])
    assert not np.isin(to_snap.outcome, (LATCHED, RETURNED)).any()


def test_the_well_is_where_the_recorded_beam_spends_the_last_swing(handout):
    """Open cells: side and share against a recording of the same steps, sampled more finely."""
    built, horizon = in_steps(build_model(handout, Cosines(modes=3)), 1.0), 900.0
    cells = to_cells(handout, 0, *random_cells(48, 7, [0.025, 25.0]), horizon)
    seen, swing = built.follow_once(cells, Run(horizon=horizon)), 2 * np.pi / handout.own_frequency
    dt = built.time_steps(cells, Run())
    assert set(seen.well) == {1, 2}
    np.testing.assert_array_equal(seen.well_share[np.isfinite(seen.t_settled)], 1.0)
    open_ones, shares = np.flatnonzero(np.isnan(seen.t_settled)), []
    for i in open_ones:
        last, before = cells.t_end[i] / dt[i], (cells.t_end[i] - swing) / dt[i]
        end, start = BLOCK * (int(last) // BLOCK + 1), BLOCK * max(0, int(before) // BLOCK)
        is_second = recorded(built, cells, i, dt[i], end)[1][start:] < built.barrier.midpoint
        shares.append(np.mean(is_second == (seen.well[i] == 2)))
    np.testing.assert_allclose(seen.well_share[open_ones], shares, atol=0.03)
    assert min(shares) < 0.9


def test_a_beam_without_a_saddle_that_rests_again_is_seen_on_the_side_of_its_only_shape(handout):
    tilts = varied(handout, free=1.0, imperfection=0.05, thickness=2.5, damping=0.03)
    built = build_model(tilts, Cosines(cosines=3))
    assert built.barrier.energy == 0
    N = np.array([100.0, 1500.0, 4000.0])
    seen = built.follow_once(to_cells(tilts, 0, N, 5e3, 100.0, 3000.0), Run(horizon=3000.0))
    assert np.isnan(seen.t_settled).all() and np.isfinite(seen.t_snap).any()
    assert set(seen.well) == {1} and set(seen.well_share) == {1}
