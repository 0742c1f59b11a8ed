"""What is called proven: the barrier, the labels, and runs that try to prove the labels wrong."""

import dataclasses

import numpy as np
import pytest
from varied import in_steps, varied

import snapmap
from snapmap.applications.histories.motion import record
from snapmap.device.device import batch
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel.pulse import BLOCK
from snapmap.solver.models import build_model
from snapmap.solver.outcome import (
    FAILED,
    LATCHED,
    NEVER,
    OUTCOMES,
    RETURNED,
    SNAPPED,
    UNSNAPPED,
    label,
)
from snapmap.solver.settings import STAY, Settings

PROVEN = (NEVER, LATCHED, RETURNED)


def test_labels_say_what_was_observed():
    nan = np.nan
    t_snap = [nan, nan, 5, 5, 5, 5, nan, nan]
    t_settled, well = [nan, 9, nan, 9, 9, 9, nan, 9], [0, 1, 0, 2, 1, 2, 0, 1]
    seen = np.array([t_snap, t_settled, well, [0, 0, 0, 0, 0, 0.1, nan, np.inf]])
    expected = [UNSNAPPED, NEVER, SNAPPED, LATCHED, RETURNED, FAILED, FAILED, FAILED]
    assert label(*seen, 1e-3).tolist() == expected
    assert OUTCOMES[LATCHED] == "latched"


def random_cells(device, number, seed, C):
    rng = np.random.default_rng(seed)
    f0 = np.exp(rng.uniform(np.log(400), np.log(2e4), number))
    return rng.uniform(700, 1500, number), f0, rng.choice(C, number)


def follow(device, cells, horizon, step):
    built = in_steps(build_model(device, "cosines", modes=3), step)
    seen = built.follow(to_cells(device, 0, *cells, horizon), Settings(horizon))
    return seen, label(*seen[:4], Settings().energy_tolerance)


def test_latched_stays_in_well_two(handout):
    """Followed on in the same steps, the midpoint of a latched beam never rises past the saddle."""
    device = varied(handout, damping=4e-4)
    found = 0
    model = build_model(device, "cosines", modes=3)
    for N, f0, C in zip(*random_cells(device, 30, 2, [25.0, 200.0]), strict=True):
        cell = to_cells(device, [0], N, f0, C, 6000.0)
        dt = model.steps.of(cell, STAY).item()
        seen = model.follow_once(cell, Settings(6000.0))
        outcome = label(*seen[:4], Settings().energy_tolerance)
        if outcome[0] not in (LATCHED, RETURNED):
            continue
        load = (column.item() for column in cell[2:5])
        form, motions = record(model, make_pulse(), *load, dt, int(2e4 / dt))
        time, w = np.hstack([(part.time, part.u @ form.midpoint) for part in motions])
        after = device.beam.rise + w[time >= seen.t_settled[0]]
        saddle = -device.beam.rise / 3
        assert (after < saddle).all() if outcome[0] == LATCHED else (after > saddle).all()
        found += 1
    assert found > 10


@pytest.mark.parametrize("contact", [40.0, np.inf])
def test_no_proof_from_a_run_whose_energy_error_exceeds_its_margin(handout, contact):
    """On purpose: the roughest steps. What is proven must be what a fine step shows."""
    device = dataclasses.replace(handout, contact=contact)
    cells = random_cells(device, 100, 3, [0.025, 25.0])
    shares = np.array([[0.98], [1.0], [1.02]])
    fine, _ = follow(device, (shares * cells[0], *cells[1:]), 3000.0, 0.1)
    nearby = np.isnan(fine.t_snap)
    away = (nearby[0] == nearby[1]) & (nearby[1] == nearby[2])
    for step in (0.8, 1.0):
        seen, outcome = follow(device, cells, 3000.0, step)
        proven = np.isin(outcome, PROVEN)
        assert (seen.energy_error[proven] <= Settings().energy_tolerance).all()
        never = (outcome == NEVER) & away
        assert never.sum() > 20 and nearby[1][never].all()


def test_no_proof_below_the_energy_that_a_run_keeps(handout):
    """Without damping that is the work of the pulse."""
    N, shares = [600.0, 750.0, 850.0, 870.0, 880.0], [*(1 - np.geomspace(1e-7, 1e-2, 11)), 2.0]

    def follow_under(energy, device, which, N):
        built = in_steps(build_model(device, "elements"), 1.0)
        built = dataclasses.replace(built, barrier=built.barrier._replace(energy=energy))
        cells = to_cells(device, which, N, 3000.0, 0.0, 3000.0)
        return built.follow_once(cells, Settings(3000.0))

    work = follow_under(0.0, handout, 0, N).pulse_work
    barriers = np.outer(work, shares).ravel()
    many = batch([handout] * barriers.size)
    seen = follow_under(barriers, many, np.arange(barriers.size), np.repeat(N, len(shares)))
    proven = np.isfinite(seen.t_settled).reshape(len(N), -1)
    assert proven[:, -1].all() and not proven[:, :-1].any()


def test_a_snap_seen_together_with_the_end_of_its_pulse_is_followed_on(root):
    device = snapmap.load_device(root / "config" / "sensor.yaml")
    N, f0 = np.linspace(1240.0, 1280.0, 41), np.linspace(7900.0, 8000.0, 5)
    cells = {"model": "cosines", "cosines": 3, "horizon": 4000, "pulse": "half sine"}
    found = snapmap.sweep(device, N, f0, [100.0], **cells)
    assert ((found.well > 0) == np.isin(found.outcome, PROVEN)).where(found.well == 0, True).all()
    to_snap = snapmap.sweep(device, N, f0, [100.0], until="snap", **cells)
    assert not np.isin(to_snap.outcome, (LATCHED, RETURNED)).any()


def test_the_well_is_where_the_recorded_beam_spends_the_last_swing(handout):
    """Open cells: side and share against a recording of the same steps, sampled more finely."""
    built, horizon = build_model(handout, "cosines", modes=3), 900.0
    cells = to_cells(handout, 0, *random_cells(handout, 48, 7, [0.025, 25.0]), horizon)
    seen, own = built.follow_once(cells, Settings(horizon)), 2 * np.pi / handout.own_frequency
    dt = built.steps.of(cells, STAY)
    assert set(seen.well) == {1, 2}
    np.testing.assert_array_equal(seen.well_share[np.isfinite(seen.t_settled)], 1.0)
    open_ones, shares = np.flatnonzero(np.isnan(seen.t_settled)), []
    for i in open_ones:
        last, before = cells.t_end[i] / dt[i], (cells.t_end[i] - own) / dt[i]
        end, start = BLOCK * (int(last) // BLOCK + 1), BLOCK * max(0, int(before) // BLOCK)
        load = (column[i] for column in cells[2:5])
        form, motions = record(built, make_pulse(), *load, dt[i], end)
        w = np.concatenate([part.u @ form.midpoint for part in motions])
        is_second = w[start:] < built.barrier.midpoint
        shares.append(np.mean(is_second == (seen.well[i] == 2)))
    np.testing.assert_allclose(seen.well_share[open_ones], shares, atol=0.03)
    assert min(shares) < 0.9
