"""The rule of time steps, and what the steps do to thresholds."""

from dataclasses import replace

import numpy as np
import pytest
from varied import alone

from snapmap.beam.limit_loads import static_threshold
from snapmap.pulse.pulse import SHAPES, make_pulse
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import EDGE, MOVE, QUESTIONS, SNAP, STAY, Settings
from snapmap.solver.steps import (
    FEWEST_STEPS,
    HEAVY,
    MORE,
    MOST_ALONE,
    STRIKE_TURN,
    Steps,
    arch_frequency,
    largest_speed,
    most_steps,
    strike_tightening,
)
from snapmap.thresholds.search import lowest_snap

LONGEST = {SNAP: 3.0, EDGE: 3.0, STAY: 0.2, MOVE: 0.1}
LIMITS = {"shortest": 0.05, "blows": 100.0, "pressed": 6.0, "returns": False, "most": np.inf}
LIMITS |= {"tightening": 0.04}
STEPS, LIMITS = ({key: np.array([one]) for key, one in part.items()} for part in (LONGEST, LIMITS))
RULE = Steps(STEPS, **LIMITS, per_swing=500)
VERSED_SINE = (make_pulse(),)


def step_of(rule, handout, f0, question=SNAP, pulses=VERSED_SINE):
    """The step of one cell, us."""
    return rule.of(to_cells(handout, [0], 900.0, f0, 25.0, 300.0, 0, pulses), question).item()


@pytest.mark.parametrize(
    ("f0", "question", "expected"),
    [
        (10.0, SNAP, 6.0),  # slow: by the question, of a mass that is pressed on the beam
        (10.0, EDGE, 6.0),
        (10.0, STAY, 0.2),
        (2e3, SNAP, 1.0),  # 500 steps in 500 us
        (5e3, EDGE, 0.2),  # twice as long as where blows decide: four times the shortest
        (2e3, MOVE, 0.1),
        (1e5, SNAP, 0.05),  # 500 steps of 0.02 us are more than the device asks for
        (2.5e6, MOVE, 0.4 / FEWEST_STEPS),  # but the pulse has its fewest
    ],
)
def test_each_branch_of_the_rule(handout, f0, question, expected):
    assert step_of(RULE, handout, f0, question) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("direction", "shape", "returns", "expected"),
    [
        ("+z", "versed sine", False, 6.0),
        ("+z", "trapezoid", False, 6.0),
        ("-z", "versed sine", False, 3.0),  # the mass flies off, and strikes on its way back
        ("+z", "versed sine", True, 3.0),
    ],
)
def test_what_strikes_is_followed_closely(handout, direction, shape, returns, expected):
    rule = replace(RULE, returns=np.array([returns]))
    pulse = make_pulse(shape) if direction == "+z" else make_pulse(shape).reversed()
    for question, step in ((SNAP, expected), (EDGE, expected), (STAY, 0.2)):
        assert step_of(rule, handout, 10.0, question, (pulse,)) == pytest.approx(step)


def test_slow_pulses_take_as_many_steps_however_slow(handout):
    """More where the mass is heavy, or its spring holds the beam back."""
    rule = replace(RULE, most=np.array([2000.0]))
    for question in (SNAP, EDGE):
        assert step_of(rule, handout, 10.0, question) == pytest.approx(1e5 / 2000)
    assert step_of(rule, handout, 10.0, EDGE, (make_pulse("trapezoid"),)) == 6.0
    assert step_of(replace(rule, returns=np.array([True])), handout, 10.0) == 3.0
    beam = handout.beam
    of_beam = HEAVY * beam.mass_per_length * beam.span
    masses = (1e-9 * of_beam, 15 * of_beam, 80 * of_beam)
    light, *heavy = (most_steps(replace(handout, mass=mass, spring=1e-6)) for mass in masses)
    assert heavy == pytest.approx([2 * light, 3 * light])
    assert most_steps(replace(handout, spring=1e9)) == pytest.approx(MOST_ALONE, rel=1e-6)
    assert most_steps(alone(handout)) == MOST_ALONE


def test_the_arch_is_stiffer_than_its_bending_by_its_rise(handout):
    """Of a single cosine by 1 + 12 Q^2 / 8."""
    modal = build_model(handout, "cosines", modes=1).modal
    ratio = arch_frequency(modal) ** 2 / modal.stiffness[0]
    assert ratio == pytest.approx(1 + 1.5 * handout.beam.bistability**2, rel=1e-12)


@pytest.mark.parametrize("question", QUESTIONS)
def test_the_tension_of_a_strike_turns_the_fastest_mode_a_few_radians_a_step(handout, question):
    cells = to_cells(handout, [0], 900.0, 10.0, 25.0, 300.0)
    for speed in (1e4, 1e6):
        turn = [
            RULE.times(factor).of(cells, question, speed).item() * np.sqrt(0.04 * speed)
            for factor in (0.5, 1.0, 4.0)
        ]
        assert turn == pytest.approx([STRIKE_TURN / 2, STRIKE_TURN, MORE * STRIKE_TURN], rel=1e-12)
    assert RULE.of(cells, question, 1e-3).item() == LONGEST[question]


def test_a_strike_tightens_a_single_cosine_by_the_closed_form(handout):
    """T = v sqrt(EA M/L) and omega^2 = T (2 pi/L)^2 / (3 rho A)."""
    modal, beam = build_model(handout, "cosines", modes=1).modal, handout.beam
    area = beam.thickness * beam.depth
    tension = np.sqrt(beam.youngs_modulus * area * handout.mass / beam.span)
    expected = tension * (2 * np.pi / beam.span) ** 2 / (3 * beam.density * area)
    assert strike_tightening(handout, modal) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("f0", [300.0, 4e3, 5e4])
def test_no_mass_on_its_spring_flies_faster(handout, f0):
    """By the answer to a half sine, which is near the bound where the pulse is short."""
    cells = to_cells(handout, 0, [-800.0], f0, 0.0, 0.0, 0, (make_pulse("half sine"),))
    bound, own = largest_speed(handout, cells).item(), handout.mass_frequency
    turn, rate = np.linspace(0.0, np.pi, 2001), np.pi * f0 * 1e-6
    per_us = 800.0 * handout.gravity * rate / (rate**2 - own**2)
    during = per_us * (np.cos(turn * own / rate) - np.cos(turn))
    after = 2 * per_us * np.cos(np.pi * own / rate / 2)
    share = max(abs(during).max(), abs(after)) / bound
    assert share <= 1 + 1e-12
    assert share > 0.99 or f0 < 5e4


def test_a_beam_without_a_mass_is_struck_by_none(handout):
    cells = to_cells(alone(handout), 0, [[800.0]], 1e3, 0.0, 0.0)
    assert largest_speed(alone(handout), cells) == 0.0


def threshold(model, f0, C, pulse, tolerance):
    rows, settings = to_rows(0, f0, C, 0, (pulse,)), Settings(300.0, until="snap")
    reach = static_threshold(model.device) * np.array([0.5, 4.0])
    return lowest_snap(model, rows, tuple(reach), settings, tolerance)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("contact", [40.0, np.inf])
def test_thresholds_are_those_of_a_tenth_of_the_step(handout, shape, contact):
    """Within 0.1 %, in rows in which labels change once."""
    device = replace(handout, contact=contact)
    model, pulse = build_model(device, "cosines", modes=3), make_pulse(shape)
    asked = np.array([100.0, 300.0, 1000.0]), 200.0, pulse, 1e-5
    found, fine = (threshold(one, *asked) for one in (model, model.with_step(0.1)))
    np.testing.assert_allclose(found, fine, rtol=1e-3)


@pytest.mark.parametrize("values", [{}, {"mass": 1e6}, {"gap": 1.0}])
def test_slow_thresholds_are_exact_to_1e_4(handout, values):
    """At rest on the beam, a hundred times as heavy, or across a gap."""
    device = replace(handout, **values)
    model, own = build_model(device, "cosines", modes=3), device.own_frequency / (2 * np.pi) * 1e6
    asked = np.array([0.01, 0.028]) * own, 25.0, make_pulse(), 1e-6
    found, fine = (threshold(one, *asked) for one in (model, model.with_step(0.2)))
    np.testing.assert_allclose(found, fine, rtol=1e-4)
