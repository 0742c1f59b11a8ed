"""Stops of the mass: closed forms, the ledger, both loops, and the statics."""

from itertools import pairwise

import numpy as np
import pytest
from varied import varied

import snapmap
from snapmap import Study
from snapmap.device.device import Beam, Device
from snapmap.pulse.pulse import make_pulse
from snapmap.solver import simd_loop
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.lanes import load
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.kernel.step import advance, rebound
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.settings import Run


def thrown(device, dt, steps, velocity, a=0.0):
    """Place of a mass far from its beam at each instant, um, from rest's place at a velocity there.

    Returns it with what its stops took, pJ.
    """
    model = build_model(varied(device, gap=1e4), Elements(elements=2))
    lanes = simd_loop.empty_lanes(model)
    X, shocks = lanes[0], np.full(LANES, a * dt**2)
    load(*lanes, 0, simd_loop.coefficients(model, -np.inf)[0], 0.0, 1.0, dt)
    # One step back on its free path, to third order.
    X[R.DY * LANES] = velocity * dt + a * dt**2 / 2
    X[R.DY * LANES] -= device.spring * velocity / device.mass * dt**3 / 6
    places = []
    for _ in range(steps):
        places.append(X[R.Y * LANES])
        advance(*lanes, shocks, 0, 1)
        rebound(X)
    return np.array([*places, X[R.Y * LANES]]), X[R.LOST * LANES] / dt**2


@pytest.mark.equation(40, 41)
def test_bounces_on_a_spring_are_those_of_the_closed_form_to_second_order(handout):
    """Thrown at v from rest; back at the stop s after 2 (pi - atan(v / omega s)) / omega."""
    e = 0.6
    device = varied(handout, stop_toward=2.0, restitution=e)
    omega, v, t = np.sqrt(device.spring / device.mass), 0.1, 500.0
    left, v = t - np.arcsin(2 * omega / v) / omega, np.sqrt(v**2 - (2 * omega) ** 2)
    while (swing := 2 * (np.pi - np.arctan2(e * v / omega, 2.0)) / omega) <= left + 1e-9:
        left, v = left - swing, e * v
    exact = -2 * np.cos(omega * left) + e * v / omega * np.sin(omega * left)
    errors = [abs(thrown(device, t / n, n, -0.1)[0][-1] - exact) for n in (500, 8000)]
    assert errors[1] < 1e-4 and errors[1] < errors[0] / 60  # of 256, as where a blow falls counts


@pytest.mark.equation(40, 41)
def test_a_dropped_mass_rebounds_by_e_each_time_and_comes_to_rest(handout):
    """From a height h it falls at g: the n-th rebound is e^2n h high; then it lies on the stop."""
    h, e, a = 5.0, 0.7, 1e-3
    device = varied(handout, spring=1e-9, stop_toward=h, restitution=e)
    y, lost = thrown(device, dt=0.25, steps=6000, velocity=0.0, a=a)
    falls = np.flatnonzero((y[1:-1] < y[:-2]) & (y[1:-1] <= y[2:])) + 1
    heights = [y[begin:end].max() + h for begin, end in pairwise(falls[:7])]
    assert heights == pytest.approx(h * e ** (2 * np.arange(1, 7)), abs=2e-4)
    assert y[-1000:] == pytest.approx(-h, abs=1e-8)
    assert lost == pytest.approx(device.mass * a * h, rel=1e-4)


@pytest.mark.equation(41)
@pytest.mark.parametrize("C", [0.0, 25.0])
def test_the_energy_is_known_to_rounding(handout, C):
    """With bounces on the beam and off both stops; with e = 1 the stops take none."""
    for e in (1.0, 0.5):
        device = varied(handout, stop_toward=14.0, stop_away=3.0, restitution=e)
        model = build_model(device, Cosines(modes=3))
        cells = to_cells(device, 0, [600.0, 1100.0, 5000.0], [1500.0, 1500.0, 2e4], C, 2000.0)
        assert model.follow_once(cells, Run(horizon=2000.0)).energy_error.max() < 1e-11
    elastic = varied(device, restitution=1.0)
    run = snapmap.simulate(Study(elastic, "3 cosines"), 5000.0, 2e4, 0.0)
    assert run.z_mass.max() - run.z_mass.min() == 17.0
    assert abs(run.dissipated_energy).max() < 1e-12 * run.pulse_work.max()


@pytest.mark.parametrize("model", [{"name": "cosines", "modes": 3}, {"name": "reference"}])
def test_a_stop_takes_energy_only_and_holds_a_mass_that_is_pressed_on_it(handout, model):
    """Pulled up by 2e5 g for 200 us, while the beam bows up against it."""
    device = varied(handout, contact=4000.0, stop_away=0.05)
    run = snapmap.simulate(Study(device, model, direction="-z", horizon=100.0), 2e5, 5e3, 0.025)
    assert np.diff(run.dissipated_energy).min() > -1e-12 * run.dissipated_energy.max()
    assert np.mean(run.z_mass[run.time < 200.0] == 10.05) > 0.9


def test_energy_that_a_stop_gives_counts_as_an_error(handout):
    """Of a mass beyond its stop that is slower than a fall from there would make it."""
    model = build_model(varied(handout, stop_away=1.0), Cosines(modes=3))
    lanes = simd_loop.empty_lanes(model)
    X = lanes[0]
    load(*lanes, 0, simd_loop.coefficients(model, -np.inf)[0], 0.0, 1.0, 1.0)
    for row, value in {R.Y: 1.1, R.DY: 0.1, R.OVERLAP: -9.0, R.A: -1.0}.items():
        X[row * LANES] = value
    rebound(X)
    assert X[R.Y * LANES] == 1.0 and X[R.DY * LANES] == 0.0 == X[R.LOST * LANES]


SMALL = Device(Beam(120.0, 0.8, 0.175, 20.0, 144e3, 2.33e-3, 5e-3), 75.0, 0.7, 800.0, 9.81e-6)
LIGHT = Device(Beam(180.0, 6.8, 1.24, 13.0, 146e3, 2.33e-3), 24.4, 4.5, 94.5, 9.81e-6)
STRONG = {
    "pressed": (SMALL, {"stop_away": 0.04, "restitution": 0.4}, "trapezoid", 1142.0, 3, 4e5),
    "bowed": (LIGHT, {"stop_away": 4.9, "gap": 2.1}, "versed sine", 157e3, 11, 2e8),
}
"""Devices with stops, the pulse and f0 (Hz) that pulls their mass up, cosines, and highest N."""


@pytest.mark.parametrize("name", STRONG)
def test_strong_shocks_against_a_stop_end_as_in_an_eighth_of_the_step(name):
    """Of a mass held on its stop, and of a beam that its own load bows."""
    device, stops, shape, f0, modes, highest = STRONG[name]
    device = varied(device, **stops)
    model = build_model(device, Cosines(modes=modes))
    N = np.linspace(0.25, 1.0, 16) * highest
    cells = to_cells(device, 0, N, f0, 0.0, 200.0, 0, (make_pulse(shape).reversed(),))
    settings = Run(horizon=200.0, until="snap")
    models = model, model.with_step(0.125)
    usual, fine = (np.isfinite(each.follow_once(cells, settings).t_snap) for each in models)
    np.testing.assert_array_equal(usual, fine)


@pytest.mark.parametrize("model", [{"name": "cosines", "modes": 3}, {"name": "reference"}])
def test_stops_out_of_reach_change_no_bit(handout, model):
    far = varied(handout, stop_toward=1e3, stop_away=1e3)
    studies = Study(handout, model), Study(far, model)
    free, held = (snapmap.simulate(study, 1300.0, 3000.0, 25.0) for study in studies)
    for key in free:
        np.testing.assert_array_equal(free[key], held[key])
