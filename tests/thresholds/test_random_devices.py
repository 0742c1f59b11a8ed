"""Thresholds of devices unlike the handout's: light masses, stiff springs, chance draws."""

import numpy as np
import pytest
from varied import in_steps, varied

import snapmap
from snapmap import Study
from snapmap.pulse.shocks import HANDOUT_SHOCK, make_shocks
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Auto, Cosines, Elements
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap
from studies import coverage
from studies.coverage import ask, draw_rows, judge, ratios
from studies.random_devices import draw_device, draw_shocks


def assert_covered(device, f0, C, within, reach, shock=HANDOUT_SHOCK):
    """The bar covers the first snap of 20 elements, and is small; returns the threshold."""
    edge = snapmap.threshold(Study(device, pulse=shock.pulse, threads=2), [f0], [C]).squeeze()
    fine = in_steps(build_model(device, Elements(elements=20, modes=9)), 0.3)
    rows, bracket = to_rows(0, f0, C, 0, shock.pulses), edge.N_first.item() * (1 + reach)
    truth = lowest_snap(Probe(fine, rows, Run(threads=2)), tuple(bracket), 1e-5, 0.002)[0]
    assert abs(truth - edge.N_first) < edge.N_error < within * edge.N_first
    return edge


@pytest.mark.parametrize(("change", "f0"), [({"mass": 0.6}, 144.6e3), ({"spring": 1e5}, 151e3)])
def test_a_beam_snaps_by_its_own_inertia(handout, change, f0):
    """With a mass of a hundredth of its own, or one that a spring holds: found, and bounded."""
    edge = assert_covered(varied(handout, **change), f0, 0.025, 0.01, np.array([-0.03, 0.03]))
    assert edge.N_static < edge.N_first and edge.velocity_change > 0


def test_ragged_rows_have_a_band_and_finite_bars(handout):
    study = Study(handout, threads=2)
    edges = snapmap.threshold(study, [1500.0, 5800.0, 9000.0], [0.025]).squeeze("C")
    assert edges.ragged.values.tolist() == [0, 1, 1]
    assert np.isfinite(edges.N_error).all()
    assert (edges.N_first <= edges.N_always).all()
    assert edges.N_always[0] == edges.N_first[0] and edges.N_always[1] > edges.N_first[1]
    lengths = (edges.island_to - edges.island_from).sum("island")
    assert (lengths <= edges.N_always - edges.N_first).all()


def test_errors_of_random_devices_lie_within_their_bars(monkeypatch):
    """On two devices drawn at random, against two independent discretisations."""
    judges = [Cosines(modes=11), Elements(elements=20, modes=9)]
    monkeypatch.setattr(coverage, "JUDGES", judges)
    draw = np.random.default_rng(5)
    over, asked = [], 0
    for _ in range(2):
        device = draw_device(draw)
        f0, C = draw_shocks(draw, device)
        run = ask(device, f0[1:3], C, Auto())
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
    first, second = {"duration": 123.72, "N": 0.50923}, {"duration": 153.31, "N": 0.86779}
    blows = [first, {"wait": 55.04}, second]
    train = [{"shape": "half sine"} | blow if "N" in blow else blow for blow in blows]
    reach, shock = np.array([-0.01, 0.01]), make_shocks({"train": train})
    assert_covered(varied(handout, **beam, **mass), 774.23, 2.0224, 5e-4, reach, shock)


def test_rows_too_slow_to_judge_are_counted(monkeypatch):
    """Few are of versed sines; of other pulses many, and the slowest are these."""

    def left_out(of_all):
        draw = np.random.default_rng(7)
        return np.array([draw_rows(draw, of_all)[-1] for _ in range(20)])

    few, some = left_out(False), left_out(True)
    assert few.mean() < 0.1 < some.mean() < 0.8
    assert some[:, 0].sum() > some[:, -1].sum()
    monkeypatch.setattr(coverage, "MOST_STEPS", np.inf)
    assert not left_out(True).any()
