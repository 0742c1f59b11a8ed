"""Thresholds of devices unlike the handout's: light masses, stiff springs, chance draws."""

import dataclasses
import math

import numpy as np
import pytest

import snapmap
from snapmap.beam.equilibria import static_threshold
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.outcome import FAILED, label
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import Settings
from snapmap.thresholds.islands import SLOW
from studies import coverage
from studies.coverage import ask, judge, ratios
from studies.random_devices import draw_device, draw_shocks

SNAP_ONLY = Settings(300.0, until="snap")
LIGHT, STIFF = {"mass": 0.6}, {"spring": 1e5}


@pytest.mark.parametrize(("change", "f0"), [(LIGHT, 144.6e3), (STIFF, 151e3)])
def test_a_beam_snaps_by_its_own_inertia(handout, change, f0):
    """With a mass of a hundredth of its own, or one that a spring holds: found, and bounded."""
    device = dataclasses.replace(handout, **change)
    found = snapmap.threshold(device, [f0], [0.025], threads=2)
    N, bar = found.N_first.item(), found.N_error.item()
    fine = build_model(device, "elements", elements=20, modes=8, step=0.3)
    rows = to_rows(0, f0, 0.025)
    settings = Settings(1500.0, threads=2)
    truth = lowest_snap(fine, rows, (0.97 * N, 1.03 * N), settings, 1e-5, 0.002)[0]
    assert abs(truth - N) < bar < 0.01 * N
    assert found.N_static.item() < N and found.velocity_change.item() > 0


@pytest.mark.parametrize("change", [LIGHT, STIFF, {"mass": 10.0}])
def test_slow_pulses_tend_to_the_static_limit_of_a_light_mass(handout, change):
    """Also where the beam leaves the mass and goes on to its own limit."""
    device = dataclasses.replace(handout, **change)
    slow = 0.02 * device.own_frequency / (2 * math.pi) * 1e6
    found = snapmap.threshold(device, [slow], [0.025], threads=2)
    assert found.N_first.item() == pytest.approx(static_threshold(device), rel=2e-3)


@pytest.mark.parametrize("change", [{}, LIGHT, STIFF])
def test_short_pulses_tend_to_a_jump_in_velocity(handout, change):
    """With damping that leaves no ragged rows, in which a first snap is a matter of digits."""
    device = dataclasses.replace(handout, **change)
    short = np.array([40.0, 400.0]) * device.own_frequency / (2 * math.pi) * 1e6
    damping = 0.3 * math.sqrt(device.spring * device.mass)
    found = snapmap.threshold(device, short, [damping], threads=2).squeeze("C")
    jumps = found.N_first * device.gravity / (2e-6 * short)
    apart = abs(jumps.values / found.velocity_change.item() - 1)
    assert apart[0] < 0.04 and apart[1] < 0.02


def test_a_static_limit_of_nothing_but_the_beam(handout):
    """Whatever the mass, if it is light enough to be left behind at once."""
    light, lighter = (dataclasses.replace(handout, mass=mass) for mass in (0.6, 0.01))
    assert static_threshold(light) == static_threshold(lighter)


def test_the_own_frequency_is_that_of_what_swings_more_slowly(handout):
    assert handout.own_frequency == np.sqrt(handout.spring / handout.mass)
    light = dataclasses.replace(handout, **LIGHT)
    beam = handout.beam
    stiffness, per_length = beam.bending_stiffness, beam.density * beam.area
    first = 22.3733 / beam.span**2 * np.sqrt(stiffness / per_length)
    assert light.own_frequency == pytest.approx(first, rel=1e-5)


def test_a_pulse_shorter_than_a_step_still_pushes(handout):
    """It gets the steps that it takes; without end it is failed, not passed for quiet."""
    model = build_model(handout, "cosines", modes=3)
    f0 = np.array([1e4, 3e5, 2e6, 1e12])
    cells = to_cells(handout, 0, 0.3 * f0, f0, 0.0, 300.0)
    seen = model.follow(cells, SNAP_ONLY)
    dt = model.steps.of(cells, SNAP_ONLY.question)
    np.testing.assert_allclose(dt[2:], 1 / (16 * cells.f0[2:]))
    assert np.isfinite(seen.t_snap[1:3]).all() and np.isnan(seen.t_snap[3])
    outcome = label(*seen[:4], Settings().energy_tolerance)
    assert outcome[3] == FAILED and (outcome[:3] != FAILED).all()


def test_a_long_search_is_told_before_it_begins(handout, monkeypatch):
    """And one without end is refused; what is quick, as a smooth pulse, goes without a word."""
    monkeypatch.setattr("snapmap.thresholds.surface._look", lambda *_: pytest.fail("it began"))
    asked = {"model": "cosines", "pulse": "half sine"}
    told = pytest.warns(UserWarning, match=r"about [\d.]+ min; f0 = 0.005 Hz takes longest")
    with told, pytest.raises(pytest.fail.Exception):
        snapmap.threshold(handout, [0.005, 1500.0], [25.0], **asked)
    with pytest.raises(ValueError, match="f0 = 1e-09 Hz takes longest; write a higher f0"):
        snapmap.threshold(handout, [1e-9], [25.0], **asked)


def test_a_slow_pulse_costs_no_wide_scan(handout):
    """It snaps a little above the static limit, by the wide scan as by the short one."""
    own = handout.own_frequency / (2 * math.pi) * 1e6
    f0 = own * SLOW * np.array([0.99, 1.01])
    found = snapmap.threshold(handout, f0, [0.025], model="cosines", threads=2).squeeze("C")
    assert found.N_first[0].item() == pytest.approx(found.N_first[1].item(), rel=1e-3)
    assert (found.N_first > found.N_static).all() and (found.N_always == found.N_first).all()


def test_ragged_rows_have_a_band_and_finite_bars(handout):
    found = snapmap.threshold(handout, [1500.0, 5800.0, 9000.0], [0.025], threads=2).squeeze("C")
    assert found.ragged.values.tolist() == [0, 1, 1]
    assert np.isfinite(found.N_error).all() and np.isfinite(found.half_error).all()
    assert (found.N_first <= found.N_half).all() and (found.N_half <= found.N_always).all()
    assert found.N_half[0] == found.N_first[0] and found.N_half[1] > found.N_first[1]
    islands = (found.island_to - found.island_from).sum("island")
    apart = abs(found.N_always - islands - found.N_half)
    assert (apart <= 1e-4 * found.islands * found.N_always).all()


QUICK = (
    {"name": "cosines", "modes": 10, "step": 0.4},
    {"name": "elements", "elements": 20, "modes": 8, "step": 0.4},
)
"""Judges whose kernels other tests compile as well."""


@pytest.mark.parametrize(
    ("count", "judges"), [(2, QUICK), pytest.param(12, coverage.JUDGES, marks=pytest.mark.long)]
)
def test_errors_lie_within_their_bars(monkeypatch, count, judges):
    """On devices drawn at random, against two independent discretisations."""
    monkeypatch.setattr(coverage, "JUDGES", judges)
    draw = np.random.default_rng(5)
    over, asked = [], 0
    for _ in range(count):
        device = draw_device(draw)
        f0, C = draw_shocks(draw, device)
        run = ask(device, f0[1:3], C, {"model": "auto"})
        assert run.result is not None and np.isfinite(run.result).all()
        truth = judge(device, f0[1:3], C, run.result[0])
        over.append(ratios([(run, truth)]))
        asked += truth.size
    over = np.concatenate(over)
    assert over.size > asked / 2 and np.mean(over <= 1) > 0.95
