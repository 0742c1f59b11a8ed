"""Beams of other shapes as made, straight ones, and clamps that give: by independent means."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Legendre, Polynomial
from scipy.optimize import brentq, root
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap.beam.cosines import antisymmetric_loads, symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.beam.equilibria import find_barrier
from snapmap.device import shape
from snapmap.device.arch import equilibria

SHAPES = cases_of(__file__)


def slopes(beam, x):
    """w0' of a beam, from its shape itself."""
    shares = [1.0, beam.cosine_2, beam.cosine_3, beam.cosine_4, beam.cosine_5]
    shares[0] -= beam.cosine_3 + beam.cosine_5  # so that the midpoint is at the rise
    turns = 2 * np.pi * np.arange(1, 6) / beam.span
    return beam.rise / 2 * (shares * turns) @ np.sin(np.outer(turns, x))


def test_the_rule_of_elements_is_that_of_gauss():
    points, weights = np.polynomial.legendre.leggauss(5)
    np.testing.assert_allclose([shape.POINTS, 2 * shape.WEIGHTS], [points, weights], rtol=1e-14)


class Polynomials:
    """The beam in polynomials (1 - s^2)^2 P_2k(s) over -1 < s < 1, by quadrature: another code."""

    def __init__(self, beam, terms=15):
        s, weights = np.polynomial.legendre.leggauss(200)
        self.x, half = (1 + s) * beam.span / 2, beam.span / 2
        clamped = Polynomial([1, 0, -1]) ** 2
        legendre = (Legendre.basis(2 * k).convert(kind=Polynomial) for k in range(terms))
        shapes = [clamped * shape / (1 + k) ** 2 for k, shape in enumerate(legendre)]
        self.values, self.middle = (np.array([shape(at) for shape in shapes]) for at in (s, 0))
        self.slopes = np.array([shape.deriv()(s) for shape in shapes]) / half
        self.bends = np.array([shape.deriv(2)(s) for shape in shapes]) / half**2
        self.weights, self.beam, self.start = weights * half, beam, slopes(beam, self.x)
        relief = beam.span / (beam.youngs_modulus * beam.area)
        self.compliance = 2 / beam.clamp_axial + relief
        self.stretch_at_rest = beam.residual_stress * beam.area * relief

    def tension(self, c):
        slope = c @ self.slopes
        stretch = self.weights @ (slope * (slope + 2 * self.start)) / 2
        return (stretch + self.stretch_at_rest) / self.compliance

    def energy(self, c):
        bending = self.beam.bending_stiffness * self.weights @ (c @ self.bends) ** 2 / 2
        return bending + self.tension(c) ** 2 * self.compliance / 2

    def force(self, c):
        bend, slope = c @ self.bends, c @ self.slopes + self.start
        stretching = self.tension(c) * (self.slopes * self.weights) @ slope
        return self.beam.bending_stiffness * (self.bends * self.weights) @ bend + stretching

    def held(self, displacement):
        """Least energy with the midpoint moved so far, and the force that it takes."""
        unit, ends = self.beam.stiffness_unit * self.beam.thickness, []
        for second in np.linspace(-2, 2, 5) * self.beam.thickness:
            turns = 2 * np.pi * self.x / self.beam.span
            towards = displacement * (1 - np.cos(turns)) + second * (1 - np.cos(2 * turns))
            guess = np.linalg.lstsq(self.values.T, towards / 2, rcond=None)[0]

            def residual(whole):
                c, push = whole[:-1], whole[-1]
                away = (self.middle @ c - displacement) / self.beam.thickness
                return np.append(self.force(c) / unit - push * self.middle, away)

            end = root(residual, np.append(guess, 0.0), tol=1e-10).x
            if np.abs(residual(end)).max() < 1e-5:
                ends.append((self.energy(end[:-1]), abs(end[-1])))
        return min(ends)


def one_mode_equilibria(beam):
    """c = w(L/2)/rise of all equilibria along the first cosine: roots of the cubic, by numpy."""
    first_load = beam.bending_stiffness * (2 * np.pi / beam.span) ** 2
    arch = 0.75 * beam.bistability**2
    push = -beam.residual_stress * beam.area / first_load
    roots = np.roots([arch, 0, 1 - arch - push, -1])
    return np.sort(roots[abs(roots.imag) < 1e-9].real)


@pytest.mark.equation(17, 23)
@pytest.mark.parametrize("stress", (-40.0, -5.0, 1.0, 60.0))
@pytest.mark.parametrize("thickness", [1.4, 2.0, 3.0])
def test_shapes_at_rest_are_the_roots_of_the_cubic(handout, stress, thickness):
    made = replace(handout.beam, thickness=thickness)
    beam = replace(made, residual_stress=min(stress, 0.99 * made.most_stress))
    low, *_, high = one_mode_equilibria(beam)
    assert beam.height == pytest.approx(high * beam.rise, rel=1e-12)
    assert beam.second_equilibrium == pytest.approx(low * beam.rise, rel=1e-12)
    assert replace(made, residual_stress=0.0).height == made.rise


@pytest.mark.equation(8, 23)
def test_a_stress_buckles_the_flat_beam_and_a_higher_one_ends_the_second_shape(handout):
    """The flat beam buckles at 5.483 MPa; state 2 goes at 69.45, and stays if free from -2.419."""
    beam = handout.beam
    load = 4 * np.pi**2 * beam.bending_stiffness / beam.span**2
    assert beam.buckling_stress == pytest.approx(load / beam.area) == pytest.approx(5.483, rel=1e-4)

    def force(stress):
        """The axial force in state 2 over the first load."""
        return 1 - 1 / one_mode_equilibria(replace(beam, residual_stress=stress))[0]

    assert force(beam.most_stress * (1 - 1e-9)) == pytest.approx(4, rel=1e-7)
    assert beam.most_stress == pytest.approx(69.45, rel=1e-4)
    tilt = (antisymmetric_loads(1)[0] / (2 * np.pi)) ** 2
    assert tilt == pytest.approx(2.0457, abs=5e-5) and force(0.0) == pytest.approx(2.0599, abs=5e-5)
    for Q in (5.645, 5.647):
        assert replace(beam, thickness=beam.rise / Q).stays_if_free == (Q > 5.646)
    stays = brentq(lambda stress: force(stress) - tilt, -5, 0)
    assert stays == pytest.approx(-2.419, rel=1e-3)
    assert replace(beam, residual_stress=1.001 * stays).stays_if_free
    assert not replace(beam, residual_stress=0.999 * stays).stays_if_free
    with pytest.raises(ValueError, match=r"69\.453 MPa"):
        replace(beam, residual_stress=70.0).require_second_shape()


def test_a_saddle_at_the_second_load_has_its_closed_form():
    """There the first shape grows by 1/(1 - 4), and all other stretch bows the second one."""
    made = equilibria(np.array([[1.0, 4.0]]), np.array([[3.0, 0.0]]), np.ones(1), np.zeros(1))
    np.testing.assert_allclose(made.saddle, [[-1.0, 2.0]])


@pytest.mark.equation(6, 25)
@pytest.mark.parametrize("values", SHAPES.values(), ids=SHAPES)
def test_equilibria_are_those_of_another_code(handout, values):
    """Held where an equilibrium is said to be, the beam takes no force, and has its energy."""
    made = replace(handout.beam, **values)
    other, barrier = Polynomials(made), find_barrier(made, symmetric_cosines(40))
    at = made.height, made.second_equilibrium, barrier.first + barrier.midpoint
    (low, *none), (_, *no), (top, *nil) = (other.held(place - made.rise) for place in at)
    assert [*none, *no, *nil] == pytest.approx([0, 0, 0], abs=0.05)  # of some 400
    assert barrier.energy == pytest.approx(top - low, rel=1e-4)


@pytest.mark.parametrize("values", SHAPES.values(), ids=SHAPES)
def test_elements_converge_to_the_cosines(handout, values):
    made = replace(handout.beam, **values)
    exact = find_barrier(made, symmetric_cosines(40))
    coarse, fine = (find_barrier(made, hermite_elements(n)).energy for n in (6, 12))
    assert abs(fine - exact.energy) < 2e-4 * exact.energy
    assert abs(coarse - exact.energy) > 8 * abs(fine - exact.energy)


def test_a_straight_beam_has_two_mirrored_shapes(handout):
    """Flat it has the energy ((c - 1) N_1)^2 / 4 (EA/2L) more, c the compression."""
    made = replace(handout.beam, rise=0.0, residual_stress=-12.0)
    barrier = find_barrier(made, symmetric_cosines(9))
    load = 4 * np.pi**2 * made.bending_stiffness / made.span**2
    flat = ((made.compression - 1) * load) ** 2 / (4 * made.axial_stiffness)
    assert made.second_equilibrium == pytest.approx(-made.height, rel=1e-7)
    assert barrier.midpoint == pytest.approx(-made.height, rel=1e-6)
    assert barrier.energy == pytest.approx(flat, rel=1e-6)


def test_a_shaped_beam_snaps_alike_in_elements_and_cosines(handout):
    device = varied(handout, cosine_2=0.05, cosine_3=-0.03)
    models = snapmap.Elements(modes=5), snapmap.Cosines()
    studies = (snapmap.Study(device, model=model) for model in models)
    N = [snapmap.threshold(study, 1500.0, 25.0).N_first.item() for study in studies]
    assert N[0] == pytest.approx(N[1], rel=1e-2)
    run = snapmap.simulate(snapmap.Study(device, model="cosines"), 1.02 * max(N), 1500.0, 25.0)
    assert run.w_mid[0] == pytest.approx(device.beam.rise)
    assert run.w_mid.min() < device.beam.second_equilibrium
