"""Thresholds of devices unlike the handout's: light masses, stiff springs, chance draws."""

import dataclasses

import numpy as np
import pytest
from varied import in_steps

import snapmap
from snapmap.pulse.shocks import make_shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import lowest_snap
from studies import coverage
from studies.coverage import ask, draw_rows, judge, ratios
from studies.random_devices import draw_device, draw_shocks

LIGHT, STIFF = {"mass": 0.6}, {"spring": 1e5}


@pytest.mark.parametrize(("change", "f0"), [(LIGHT, 144.6e3), (STIFF, 151e3)])
def test_a_beam_snaps_by_its_own_inertia(handout, change, f0):
    """With a mass of a hundredth of its own, or one that a spring holds: found, and bounded."""
    device = dataclasses.replace(handout, **change)
    found = snapmap.threshold(device, [f0], [0.025], threads=2)
    N, bar = found.N_first.item(), found.N_error.item()
    fine = in_steps(build_model(device, "elements", elements=20, modes=9), 0.3)
    rows = to_rows(0, f0, 0.025)
    settings = Settings(1500.0, threads=2)
    truth = lowest_snap(fine, rows, (0.97 * N, 1.03 * N), settings, 1e-5, 0.002)[0]
    assert abs(truth - N) < bar < 0.01 * N
    assert found.N_static.item() < N and found.velocity_change.item() > 0


def test_ragged_rows_have_a_band_and_finite_bars(handout):
    found = snapmap.threshold(handout, [1500.0, 5800.0, 9000.0], [0.025], threads=2).squeeze("C")
    assert found.ragged.values.tolist() == [0, 1, 1]
    assert np.isfinite(found.N_error).all()
    assert (found.N_first <= found.N_always).all()
    assert found.N_always[0] == found.N_first[0] and found.N_always[1] > found.N_first[1]
    lengths = (found.island_to - found.island_from).sum("island")
    assert (lengths <= found.N_always - found.N_first).all()


def test_errors_lie_within_their_bars(monkeypatch):
    """On two devices drawn at random, against two independent discretisations."""
    judges = [{"name": "cosines", "modes": 11}, {"name": "elements", "elements": 20, "modes": 9}]
    monkeypatch.setattr(coverage, "JUDGES", judges)
    draw = np.random.default_rng(5)
    over, asked = [], 0
    for _ in range(2):
        device = draw_device(draw)
        f0, C = draw_shocks(draw, device)
        run = ask(device, f0[1:3], C, {"model": "auto"})
        assert run.result is not None and np.isfinite(run.result).all()
        truth = judge(device, f0[1:3], C, run.result[0])
        over.append(ratios([(run, truth)]))
        asked += truth.size
    over = np.concatenate(over)
    assert over.size > asked / 2 and np.mean(over <= 1) > 0.95


def test_a_bar_covers_what_the_finest_model_sees(handout):
    """Under two blows across a gap three and five cosines agree by luck, as eleven do not."""
    beam = {"span": 1852.3, "rise": 49.715, "thickness": 15.306, "depth": 21.172}
    beam |= {"youngs_modulus": 131950.0, "residual_stress": -26.214}
    mass = {"mass": 200.15, "spring": 204.36, "contact": np.inf, "gap": 2.7397}
    device = dataclasses.replace(handout, beam=dataclasses.replace(handout.beam, **beam), **mass)
    blow, shocks = {"shape": "half sine"}, {}
    first, second = {"duration": 123.72, "N": 0.50923}, {"duration": 153.31, "N": 0.86779}
    shocks["train"] = [blow | first, {"wait": 55.04}, blow | second]
    found = snapmap.threshold(device, [774.23], [2.0224], pulse=shocks, threads=2)
    N, bar = found.N_first.item(), found.N_error.item()
    fine = in_steps(build_model(device, "elements", elements=20, modes=9), 0.3)
    rows = to_rows(0, 774.23, 2.0224, 0, (make_shocks(shocks).pulse,))
    truth = lowest_snap(fine, rows, (0.99 * N, 1.01 * N), Settings(), 1e-5, 0.002)[0]
    assert abs(truth - N) < bar < 5e-4 * N


def test_rows_too_slow_to_judge_are_counted(monkeypatch):
    """All of versed sines are judged; of other pulses some are not, and the slowest are these."""

    def left_out(of_all):
        draw = np.random.default_rng(7)
        return np.array([draw_rows(draw, of_all)[-1] for _ in range(20)])

    assert not left_out(False).any()
    some = left_out(True)
    assert 0 < some.mean() < 0.4 and some[:, 0].sum() > some[:, -1].sum()
    monkeypatch.setattr(coverage, "MOST_STEPS", np.inf)
    assert not left_out(True).any()
