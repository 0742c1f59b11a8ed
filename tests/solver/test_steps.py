"""The rule of time steps, and what the steps do to thresholds."""

from dataclasses import replace

import numpy as np
import pytest
from varied import alone

from snapmap.beam.limit_loads import static_threshold
from snapmap.device.device import Beam, Device, batch
from snapmap.pulse.pulse import SHAPES, make_pulse
from snapmap.solver import steps
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines
from snapmap.solver.settings import FIRST, SECOND, SNAP, STAY, Run
from snapmap.thresholds.probe import Probe, lowest_snap


def test_the_arch_is_stiffer_than_its_bending_by_its_rise(handout):
    """Of a single cosine by 1 + 12 Q^2 / 8."""
    modal = build_model(handout, Cosines(modes=1)).modal
    ratio = steps.arch_frequency(modal) ** 2 / modal.stiffness[0]
    assert ratio == pytest.approx(1 + 1.5 * handout.beam.bistability**2, rel=1e-12)


def test_a_strike_tightens_a_single_cosine_by_the_closed_form(handout):
    """T = v sqrt(EA M/L) and omega^2 = T (2 pi/L)^2 / (3 rho A)."""
    modal, beam = build_model(handout, Cosines(modes=1)).modal, handout.beam
    tension = np.sqrt(beam.youngs_modulus * beam.area * handout.mass / beam.span)
    expected = tension * (2 * np.pi / beam.span) ** 2 / (3 * beam.density * beam.area)
    assert steps.strike_tightening(handout.mass, modal) == pytest.approx(expected, rel=1e-12)


def test_in_runs_to_the_end_a_tension_turns_the_fastest_mode_of_any_model_alike(handout):
    """Per step, but for what more cosines change of the slowest mode, by which steps count."""
    modals = [build_model(handout, Cosines(cosines)) for cosines in (5, 11, 17)]
    longest = [model.steps.longest for model in modals]
    stay, snap = ([steps[question].item() for steps in longest] for question in (STAY, SNAP))
    turns = [np.sqrt(model.modal.geometric[-1, -1]) for model in modals]
    np.testing.assert_allclose(np.multiply(stay, turns), stay[0] * turns[0], rtol=0.1)
    np.testing.assert_allclose(snap, snap[0], rtol=0.1)


@pytest.mark.parametrize("f0", [300.0, 4e3, 5e4])
def test_no_mass_on_its_spring_flies_faster(handout, f0):
    """By the answer to a half sine, which is near the bound where the pulse is short."""
    cells = to_cells(handout, 0, [-800.0], f0, 0.0, 0.0, 0, (make_pulse("half sine"),))
    bound, frequency = steps.largest_speed(handout, cells).item(), handout.mass_frequency
    turn, rate = np.linspace(0.0, np.pi, 2001), np.pi * f0 * 1e-6
    per_us = 800.0 * handout.gravity * rate / (rate**2 - frequency**2)
    during = per_us * (np.cos(turn * frequency / rate) - np.cos(turn))
    after = 2 * per_us * np.cos(np.pi * frequency / rate / 2)
    share = max(abs(during).max(), abs(after)) / bound
    assert share <= 1 + 1e-12 and (share > 0.99 or f0 < 5e4)
    assert steps.largest_speed(alone(handout), cells) == 0.0


def test_only_a_mass_that_was_thrown_far_or_against_a_stop_strikes_the_first_shape_fast(handout):
    up, down = (make_pulse(), make_pulse().reversed())
    cells = to_cells(handout, 0, 5000.0, 3e3, 0.0, 0.0, np.array([0, 1]), (up, down))
    fastest, stopped = steps.largest_speed(handout, cells), replace(handout, stop_away=2.0)
    weak = cells._replace(amplitude=cells.amplitude / 100)
    swing = fastest[1] / handout.mass_frequency
    assert 3.0 * handout.beam.rise < swing < 300 * handout.beam.rise
    np.testing.assert_array_equal(steps.strikes(handout, weak, FIRST), np.zeros((2, 2)))
    np.testing.assert_array_equal(steps.strikes(handout, cells, FIRST), [[0.0, fastest[1]], [0, 1]])
    np.testing.assert_array_equal(steps.strikes(handout, cells, SECOND)[0], fastest)
    expected = [[0.0, fastest[1] / 100], [1, 1]]
    np.testing.assert_allclose(steps.strikes(stopped, weak, FIRST), expected, rtol=1e-12)
    strong = cells._replace(amplitude=1e6 * fastest)
    models = (build_model(device, Cosines(modes=3)) for device in (handout, stopped))
    usual, shorter = (model.time_steps(strong, Run())[0] for model in models)
    assert shorter < usual / 5  # of the pressed mass by the beam's own load


@pytest.mark.parametrize("is_alone", [False, True])
def test_a_light_mass_thrown_far_and_a_beam_pulled_far_snap_where_they_do_in_short_steps(is_alone):
    """By eleven cosines they did from a quarter of the shock on that snaps them."""
    beam = Beam(1419.0, 7.6, 2.094, 29.0, youngs_modulus=1.44e5, density=2.33e-3)
    device = Device(beam, mass=25.7, spring=1.007, contact=17.54, gravity=9.81e-6)
    model = build_model(batch([device]), Cosines(modes=11))
    f0 = 0.365 * device.own_frequency / (2 * np.pi) * 1e6
    swings = device.beam.rise * device.mass_frequency * np.geomspace(3.1, 12.0, 12)
    pulse, C = make_pulse("trapezoid").reversed(), 0.05 * np.sqrt(device.spring * device.mass)
    one = to_cells(model.device, 0, [1.0], f0, C, 1e3, 0, (pulse,))
    N = swings / steps.largest_speed(model.device, one)
    if is_alone:
        model, N, C = build_model(alone(device), Cosines(modes=11)), np.geomspace(5e3, 7e4, 12), 0.0
    cells = to_cells(model.device, 0, N, f0, C, 1e3, 0, (pulse,))
    models, run = (model, model.with_step(0.25)), Run(horizon=1e3, until="snap")
    usual, short = (np.isfinite(each.follow(cells, run).t_snap) for each in models)
    np.testing.assert_array_equal(usual, short)


def threshold(model, f0, C, pulse, tolerance):
    rows, settings = to_rows(0, f0, C, 0, (pulse,)), Run(horizon=300.0, until="snap")
    reach = static_threshold(model.device) * np.array([0.5, 4.0])
    return lowest_snap(Probe(model, rows, settings), tuple(reach), tolerance)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("contact", [40.0, np.inf])
def test_thresholds_do_not_change_in_a_tenth_of_the_step(handout, shape, contact):
    """Within 0.1 %, in rows in which labels change once."""
    model = build_model(replace(handout, contact=contact), Cosines(modes=3))
    asked = [100.0, 300.0, 1000.0], 200.0, make_pulse(shape), 1e-5
    usual, fine = (threshold(each, *asked) for each in (model, model.with_step(0.1)))
    np.testing.assert_allclose(usual, fine, rtol=1e-3)


@pytest.mark.parametrize("values", [{}, {"mass": 1e6}, {"gap": 1.0}, {"gap": 1.0, "spring": 20.0}])
def test_slow_thresholds_are_exact_to_1e_4(handout, values):
    """At rest on the beam, a hundred times as heavy, or across a gap, on a stiff spring too."""
    device = replace(handout, **values)
    f0, model = device.own_frequency / 2e-6 / np.pi, build_model(device, Cosines(modes=3))
    asked = np.array([0.01, 0.028]) * f0, 25.0, make_pulse(), 1e-6
    usual, fine = (threshold(each, *asked) for each in (model, model.with_step(0.2)))
    np.testing.assert_allclose(usual, fine, rtol=1e-4)
    if "spring" in values:  # it presses the mass across its gap
        assert usual[0] == pytest.approx(static_threshold(device), rel=1e-3)
