"""Limits of thresholds: bounds by energy, statics, slow pulses, and where nothing snaps at all."""

import math
from dataclasses import replace

import numpy as np
import pytest
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap import Study
from snapmap.beam.equilibria import find_barrier, shapes_of
from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import batch
from snapmap.pulse.pulse import make_pulse, sampled
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.thresholds import slow
from snapmap.thresholds.summary import summary, tidy
from snapmap.thresholds.survey import FOUND, NOT_FOLLOWED, NOTHING_SNAPS

CASES = cases_of(__file__)


def compliance(device):
    """Of the mass on its spring and of the beam under their own loads, by handbooks."""
    beam = device.beam
    sag = beam.weight**2 * beam.span**3 / (720 * beam.bending_stiffness)
    return device.mass**2 / device.spring + sag


@pytest.mark.parametrize(("change", "N", "f0", "C", "shape", "direction"), CASES["runs"])
def test_no_run_has_more_energy_than_its_pulse_gives(handout, change, N, f0, C, shape, direction):
    """Held against histories."""
    device = replace(handout, **change)
    asked = {"horizon": 500.0, "pulse": shape, "direction": direction}
    run = snapmap.simulate(Study(device, "5 cosines", **asked), N, f0, C)
    parts = ("kinetic", "spring", "bending", "axial", "contact")
    energy = sum(run[f"{part}_energy"] for part in parts).values
    # Until it snaps, as the bounds are asked for no longer.
    energy = energy[: 1 + np.argmax(np.append(run.w_mid.values < 0, True))]
    pulse = make_pulse(shape)
    speed = N * device.gravity * pulse.gross_area / (1e-6 * f0)
    by_impulse = (device.mass + device.beam.weight) * speed**2 / 2
    by_sag = 2 * compliance(device) * (N * device.gravity * pulse.variation) ** 2
    assert 0 < energy.max() <= 1.001 * min(by_impulse, by_sag)


@pytest.mark.parametrize("tilts_out", [False, True])
def test_the_bound_is_that_of_the_saddle_or_of_bending(handout, tilts_out):
    """486.805 pJ; without a saddle those of a straight beam bent as far. Both are closed forms."""
    device, energy, beam = handout, 486.805, handout.beam
    if tilts_out:
        device = varied(handout, free=1.0, imperfection=1e-6)
        energy = 192 * beam.stiffness_unit * (beam.rise - beam.second_equilibrium) ** 2 / 2
    model = build_model(batch([device]), Cosines(modes=18))
    assert (model.barrier.energy.item() == 0) == tilts_out
    low, high = least_amplitudes(model, to_rows(0, [10.0, 1e5], 25.0))
    by_sag = np.sqrt(energy / 2 / compliance(handout)) / 2 / handout.gravity
    assert low == pytest.approx(by_sag, rel=1e-5)
    speed = np.sqrt(2 * energy / (handout.mass + beam.weight))
    assert high == pytest.approx(speed * 0.1 / 0.5 / handout.gravity, rel=1e-5)


@pytest.mark.parametrize(("values", "how", "f0", "C", "N", "digit", "share"), CASES["far below"])
def test_a_mass_in_swing_snaps_far_below_the_statics(handout, values, how, f0, C, N, digit, share):
    """By a code of others, or 20 elements in steps of 50; half a unit of their last digit."""
    edge = snapmap.threshold(Study(device := replace(handout, **values), **how), [f0], [C])
    assert edge.status == FOUND and abs(edge.N_first - N) <= edge.N_error + digit
    assert edge.N_bound < edge.N_first < share * max(map(static_threshold, (handout, device)))


def test_a_threshold_that_is_not_there_has_its_reason(handout):
    """Pulses that pull slowly, ordinary ones, and those too short for any step."""
    how = {"model": "3 cosines", "horizon": 100.0}
    back = snapmap.threshold(Study(handout, direction="-z", **how), [50.0], [25.0])
    there = snapmap.threshold(Study(handout, **how), [1500.0, 1e12], [25.0]).squeeze("C")
    assert back.status == NOTHING_SNAPS and back.N_looked > 4 * static_threshold(handout)
    assert there.status.values.tolist() == [FOUND, NOT_FOLLOWED]
    assert np.isfinite(there.N_first).values.tolist() == [True, False]
    assert tidy(there).status.tolist() == ["found", "not_followed"]
    assert summary(there).endswith("; not followed in 1")
    assert summary(back).endswith("; nothing snaps in 1")
    first, row = there.N_first[0].item(), there.isel(f0=[0])
    for low, high, side in (first + 1, 2 * first, "above"), (0.5 * first, first - 1, "below"):
        line = f"; the grid lies wholly {side} the threshold"
        assert summary(row, low, high).endswith(line)
        assert "grid" not in summary(row, low - first, high + first)


@pytest.mark.parametrize("is_ragged", [False, True])
def test_ever_shorter_pulses_tend_to_a_jump_in_velocity(handout, monkeypatch, is_ragged):
    """At 1e8 Hz only the shorter steps of the deciding level follow the pulse.

    Where the scan calls a row ragged, and here finds nothing, the search for islands finds it.
    """
    if is_ragged:
        ragged = lambda probe, _: (np.nan * probe.rows.f0, probe.rows.f0 > 0)  # noqa: E731
        monkeypatch.setattr("snapmap.thresholds.surface.nominal_thresholds", ragged)
    study = Study(handout, horizon=300.0 + is_ragged)  # of which nothing is kept
    edges = snapmap.threshold(study, [1e6, 1e7, 1e8], [200.0]).squeeze()
    change = edges.N_first * handout.gravity * 0.5 / (1e-6 * edges.f0)
    longer, shorter = abs(np.diff(change))
    assert shorter < longer / 10
    assert change[-1].item() == pytest.approx(edges.velocity_change.item(), rel=2e-3)


def test_a_gap_that_the_mass_does_not_cross_leaves_the_beam_alone(handout):
    alone = static_threshold(replace(handout, mass=1e-5))
    assert static_threshold(replace(handout, gap=1e4)) == alone
    # At that acceleration the mass has gone as far as its spring lets it, M a / K.
    reach = handout.mass * alone * handout.gravity / handout.spring
    assert static_threshold(replace(handout, gap=1.1 * reach)) == alone
    assert static_threshold(replace(handout, gap=0.5 * reach)) < alone


def test_a_light_mass_on_its_spring_does_not_bound_the_step(handout):
    """It swings hundreds of times in a step, and the ledger closes all the same."""
    light = replace(handout, mass=1e-5)
    model = build_model(light, Cosines(modes=3))
    assert model.steps.pressed > 100 * np.sqrt(light.mass / light.spring)
    cells = to_cells(light, 0, [1e5], 1e5, 0.025, 20.0)
    assert model.follow(cells, Run(horizon=20.0)).energy_error < 1e-6


SWINGS = math.pi / np.array([0.002, 0.02, 0.1, 0.2])


@pytest.mark.equation(43)
def test_the_handouts_mass_departs_in_68_us(handout):
    """From kappa = 1/(1/s - 1/lambda) - K, s = 64 pi^2 EI/L^3; and damped it departs slower."""
    s = 64 * math.pi**2 * 2.2e6 / 600**3
    for contact, kappa in ((40.0, 2.166601), (math.inf, 0.93352)):
        assert 1 / (1 / s - 1 / contact) - 5.5 == pytest.approx(kappa, rel=1e-6)
        for C in (0.0, 0.025, 25.0, 1e4):
            sigma = slow.departure_rate(varied(handout, contact=contact), C)
            assert 1e4 * sigma**2 + C * sigma == pytest.approx(kappa, rel=1e-6)
    assert slow.departure_rate(handout, 0.0) == pytest.approx(0.0147194, rel=1e-5)
    assert 2 / slow.departure_rate(handout, 0.025) == pytest.approx(135.89, rel=1e-4)


@pytest.mark.equation(44, 45)
def test_a_versed_sine_follows_its_closed_form_and_any_smooth_pulse_its_curvature():
    """I = (1 - cos(2 pi x + b) cos b)/2 with tan b = 2 pi f0/sigma, until the pulse ends."""
    factor = slow.slow_factor(make_pulse(), SWINGS)
    closed = 1 + np.tan(np.arctan(2 * np.pi / SWINGS) / 2) ** 2
    np.testing.assert_allclose(factor[:3], closed[:3], rtol=2e-7)
    for shape, bend in ("versed sine", 2 * np.pi**2), ("half sine", np.pi**2):
        excess = slow.slow_factor(make_pulse(shape), SWINGS)[1] - 1
        assert excess == pytest.approx(bend / 2 / SWINGS[1] ** 2, rel=2e-3)
    x = np.linspace(0, 1, 2001)
    record = sampled(1e4 * x, make_pulse().at(x))
    np.testing.assert_allclose(slow.slow_factor(record, SWINGS), factor, rtol=1e-6)
    twice = sampled(1e4 * x, 0.5 * make_pulse().at(2 * x) + make_pulse().at(2 * x - 1))
    np.testing.assert_allclose(slow.slow_factor(twice, 2 * SWINGS), factor, rtol=1e-5)
    flat = slow.slow_factor(make_pulse("trapezoid"), SWINGS[:2])
    assert flat == pytest.approx(np.ones(2), abs=1e-12)
    for pulse in (make_pulse("sawtooth"), make_pulse().reversed()):
        assert np.isnan(slow.slow_factor(pulse, SWINGS)).all()


@pytest.mark.equation(43, 44, 45)
def test_thresholds_of_slow_pulses_are_those_of_the_dwell(handout):
    f0, C = [50.0, 100.0, 200.0], [0.025, 25.0]
    edges = snapmap.threshold(Study(handout, "3 cosines"), f0, C, tolerance=1e-5)
    np.testing.assert_allclose(edges.N_slow, edges.N_first, rtol=1e-3)
    assert edges.dwell.values.tolist() == [2 / slow.departure_rate(handout, c) for c in C]
    # N_static of the exact beam is 2e-4 above that of three cosines.
    rise = (math.pi * 1e-6 / slow.departure_rate(handout, 0.025)) ** 2 * 37500
    for N in (edges.N_first, edges.N_slow):
        assert (N[0, 2] - N[0, 0]) / edges.N_static == pytest.approx(rise, rel=0.04)


def law_of(device):
    """Rate at C = 0.025, and why there is none."""
    static = static_threshold(device)
    return slow.growth_rate(device, 0.025, static), slow.first_obstacle(device, static)


@pytest.mark.parametrize(("values", "reason"), CASES["obstacles"])
def test_where_the_dwell_is_no_constant_it_is_unknown_for_a_reason(handout, values, reason):
    """By each distance that docs/applications/laws.md has errors of."""
    scale = {"mass": handout.beam.weight}
    values = {key: value * scale.get(key, 1.0) for key, value in values.items()}
    rate, told = law_of(varied(handout, **values))
    assert np.isnan(rate) and told.startswith(reason)


def test_what_is_far_from_the_corner_leaves_the_dwell_as_it_is(handout):
    for values in ({"stop_toward": 60.0, "stop_away": 5.0}, {"residual_stress": -3.0}):
        assert law_of(varied(handout, **values)) == (slow.departure_rate(handout, 0.025), "")


@pytest.mark.parametrize("values", [{}, {"residual_stress": -3.0}, {"cosine_3": 0.05}])
def test_the_fall_ends_at_the_saddle_where_the_spring_alone_holds_the_mass(handout, values):
    device = varied(handout, **values)
    static, beam = static_threshold(device), device.beam
    way = -find_barrier(beam, shapes_of(beam)).midpoint
    held = device.spring * way / (device.mass * device.gravity)
    assert slow.fall(device, static) == pytest.approx(1 - held / static, rel=1e-6)


def test_a_shock_is_slow_by_its_steepest_slope():
    """A versed sine up to an excess of a fifth of the fall; a pulse that jumps never is."""
    swings = math.pi / np.sqrt([0.0199, 0.0201, 1e-9])
    assert slow.is_slow(make_pulse(), swings, 0.1).tolist() == [True, False, True]
    assert slow.is_slow(make_pulse("trapezoid"), swings, 0.1).tolist() == [False, False, True]
    assert not slow.is_slow(make_pulse("sawtooth"), swings, 0.1).any()
