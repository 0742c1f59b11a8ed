"""The rule of time steps, and what the steps do to thresholds."""

from dataclasses import replace

import numpy as np
import pytest

from snapmap.beam.equilibria import static_threshold
from snapmap.device import ALONE, batch
from snapmap.pulse import SHAPES, make_pulse, sampled
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import EDGE, MOVE, QUESTIONS, SNAP, STAY, Settings
from snapmap.solver.steps import (
    FEWEST,
    LONGEST,
    MORE,
    OF_LIMIT,
    PER_SWING,
    SHORTEST,
    STIFF,
    Steps,
    arch_frequency,
    bending_limit,
    fixed,
    stability_limit,
    stiffness_share,
)

LONGEST_STEPS = {SNAP: 3.0, EDGE: 3.0, STAY: 0.2, MOVE: 0.1}
RULE = Steps(
    {question: np.array([step]) for question, step in LONGEST_STEPS.items()},
    shortest=np.array([0.05]),
    blows=np.array([100.0]),
    apart=np.array([False]),
    chatter=np.array([0.0]),
    calms=np.array([1e3]),
    per_swing=500,
)
VERSED_SINE = (make_pulse(),)


def step_of(rule, handout, f0, question=SNAP, pulses=VERSED_SINE):
    """The step of one cell, us."""
    return rule.of(to_cells(handout, [0], 900.0, f0, 25.0, 300.0, 0, pulses), question).item()


@pytest.mark.parametrize(
    ("f0", "question", "expected"),
    [
        (10.0, SNAP, 3.0),  # slow: by the question
        (10.0, STAY, 0.2),
        (10.0, MOVE, 0.1),
        (2e3, SNAP, 1.0),  # 500 steps in 500 us
        (2e3, EDGE, 1.0),
        (5e3, EDGE, 0.2),  # twice as long as where blows decide: four times the shortest
        (2e4, EDGE, 0.05),
        (2e3, MOVE, 0.1),
        (1e5, SNAP, 0.05),  # 500 steps of 0.02 us are more than the device asks for
        (1e5, MOVE, 0.05),
        (2.5e6, SNAP, 0.4 / FEWEST),  # but the pulse has its fewest
        (2.5e6, MOVE, 0.4 / FEWEST),
    ],
)
def test_each_branch_of_the_rule(handout, f0, question, expected):
    assert step_of(RULE, handout, f0, question) == pytest.approx(expected, rel=1e-12)


def test_a_pulse_of_many_swings_has_steps_in_each(handout):
    zigzag = sampled(np.arange(7.0), np.array([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]))
    pulses = make_pulse("trapezoid"), zigzag
    few, many = (step_of(RULE, handout, 2e3, pulses=(pulse,)) for pulse in pulses)
    assert few == pytest.approx(1.0) and many == pytest.approx(1 / 3)


@pytest.mark.parametrize(
    ("direction", "shape", "apart", "expected"),
    [
        ("+z", "versed sine", False, 3.0),
        ("+z", "trapezoid", False, 1.2),  # corners ring the beam
        ("-z", "versed sine", False, 0.3),  # the mass flies off, and strikes on its way back
        ("-z", "trapezoid", False, 0.3),
        ("+z", "versed sine", True, 0.3),  # or crosses a gap
    ],
)
def test_what_strikes_is_followed_closely(handout, direction, shape, apart, expected):
    rule = replace(RULE, apart=np.array([apart]), cornered=0.4, striking=0.1)
    pulse = make_pulse(shape) if direction == "+z" else make_pulse(shape).reversed()
    for question, step in ((SNAP, expected), (EDGE, expected), (STAY, 0.2)):
        assert step_of(rule, handout, 10.0, question, (pulse,)) == pytest.approx(step)


@pytest.mark.parametrize(
    ("shape", "f0", "share"),
    [
        ("trapezoid", 10.0, 0.4 / 4),
        ("versed sine", 10.0, 1.0),  # slow: the mass stays on the beam
        ("versed sine", 1e3, 1 / 2.5),  # as long as what calms it
    ],
)
def test_a_mass_on_a_hard_contact_chatters(handout, shape, f0, share):
    rule = replace(RULE, chatter=np.array([3.0]), cornered=0.4, per_swing=1.0)
    step = step_of(rule, handout, f0, SNAP, (make_pulse(shape),))
    assert step == pytest.approx(3.0 * share, rel=1e-3)
    assert step_of(rule, handout, f0, STAY, (make_pulse(shape),)) == 0.2


def test_a_stiff_contact_is_nearly_hard_and_a_beam_alone_has_none(handout):
    clamped = 192 * handout.beam.stiffness_unit
    contacts = (1e-3 * STIFF * clamped, STIFF * clamped, 1e3 * STIFF * clamped, np.inf)
    shares = [stiffness_share(replace(handout, contact=contact)) for contact in contacts]
    np.testing.assert_allclose(shares, [0.001, 0.5, 0.999, 1.0], rtol=2e-3)
    assert stiffness_share(replace(handout, **ALONE)) == 0


def test_a_factor_leaves_very_short_pulses_their_steps(handout):
    assert step_of(RULE.times(0.5), handout, 2e3) == pytest.approx(0.5)
    assert step_of(RULE.times(0.5).times(4.0), handout, 2e3) == pytest.approx(2.0)
    short = 0.4 / FEWEST
    assert step_of(RULE.times(4.0), handout, 2.5e6) == pytest.approx(MORE * short)
    assert step_of(RULE.times(0.5), handout, 2.5e6) == pytest.approx(short / 2)


def test_a_fixed_step_is_that_of_every_question(handout):
    for question in QUESTIONS:
        assert step_of(fixed(np.array([0.07])), handout, 10.0, question) == 0.07
        assert step_of(fixed(np.array([0.07])), handout, 2.5e6, question) == 0.4 / FEWEST


def test_each_device_of_a_batch_has_its_own_steps(handout):
    slower = replace(handout, beam=replace(handout.beam, youngs_modulus=1e5))
    together = build_model(batch([handout, slower]), "cosines").steps
    for i, device in enumerate((handout, slower)):
        alone = build_model(device, "cosines").steps
        for steps in (together.pick(i), alone):
            assert steps.longest[SNAP] == together.longest[SNAP][i]
            assert steps.shortest == together.shortest[i]


def test_who_takes_which_rule(handout):
    """The kernel's by the arch, however many modes; the plain loop's and told steps are fixed."""
    for modes in (3, 12):
        model = build_model(handout, "cosines", modes=modes)
        period = np.atleast_1d(1 / arch_frequency(model.modal))
        assert model.steps.per_swing == PER_SWING
        np.testing.assert_allclose(model.steps.shortest, SHORTEST * period)
        for question in QUESTIONS:
            np.testing.assert_allclose(model.steps.longest[question], LONGEST[question] * period)
    plain = build_model(handout, "reference")
    own = OF_LIMIT * stability_limit(handout, plain.modal)
    told = build_model(handout, "cosines", modes=3, step=0.5)
    for model, dt in ((plain, own), (told, 0.5 * bending_limit(handout, told.modal))):
        assert all(step_of(model.steps, handout, 10.0, question) == dt for question in QUESTIONS)


def test_the_arch_is_stiffer_than_its_bending_by_its_rise(handout):
    """Of a single cosine by 1 + 12 Q^2 / 8."""
    modal = build_model(handout, "cosines", modes=1).modal
    ratio = arch_frequency(modal) ** 2 / modal.stiffness[0]
    assert ratio == pytest.approx(1 + 1.5 * handout.beam.bistability**2, rel=1e-12)


def threshold(model, f0, C, pulse, tolerance):
    rows, settings = to_rows(0, f0, C, 0, (pulse,)), Settings(300.0, until="snap")
    reach = static_threshold(model.device) * np.array([0.5, 4.0])
    return lowest_snap(model, rows, tuple(reach), settings, tolerance)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("contact", [40.0, np.inf])
def test_thresholds_are_those_of_a_tenth_of_the_step(handout, shape, contact):
    """Within 0.1 %, in rows in which labels change once."""
    device = replace(handout, contact=contact)
    model, pulse = build_model(device, "cosines", modes=4), make_pulse(shape)
    asked = np.array([100.0, 300.0, 1000.0]), 200.0, pulse, 1e-5
    found, fine = (threshold(one, *asked) for one in (model, model.with_step(0.1)))
    np.testing.assert_allclose(found, fine, rtol=1e-3)


@pytest.mark.parametrize(("f0", "coarse"), [(100.0, 250), (300.0, 500)])
def test_the_threshold_converges_with_order_two(handout, f0, coarse):
    """Where the first mode turns by more than 2 radians in both steps, or by less in both."""
    model = build_model(handout, "cosines", modes=4)
    numbers = 8000, 2 * coarse, coarse
    steps = [replace(model, steps=fixed(np.array([1e6 / f0 / n]))) for n in numbers]
    fine, *found = (threshold(one, f0, 25.0, make_pulse(), 1e-8).item() for one in steps)
    errors = np.abs(np.array(found) / fine - 1)
    assert np.log2(errors[1] / errors[0]) == pytest.approx(2.0, abs=0.3)
