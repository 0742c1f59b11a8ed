"""Balls hold what is known otherwise; python-flint is in the group `bench`."""

import pytest

from snapmap.solver.models import build_model

flint = pytest.importorskip("flint")


def test_no_shape_at_the_saddle_has_less_energy_than_its_closed_form(handout):
    from studies.enclosures.passes import floor, lowest

    model, beam = build_model(handout, "cosines", modes=2), handout.beam
    with flint.ctx.workprec(256):
        saddle = 16 / 3 - 32 / (3 * beam.bistability**2)
        exact = flint.arb.pi() ** 4 * beam.stiffness_unit * beam.rise**2 * saddle
        assert abs(floor(model.modal, model.barrier) / exact - 1) < 1e-14
        assert lowest(model.modal, model.barrier)[0].rad() < 1e-15 * exact


def test_a_polynomial_falls_below_zero_by_what_it_does():
    from studies.enclosures.motion import shortfall

    poly = flint.arb_poly([0, 0, -1, 1])  # t^3 - t^2, least at 2/3
    with flint.ctx.workprec(256):
        least = shortfall(poly, flint.arb(0), flint.arb(1))
        none = shortfall(-poly, flint.arb(0), flint.arb(1))
    assert 4 / 27 <= float(least) < 4 / 27 + 1e-9 and none < 1e-30
