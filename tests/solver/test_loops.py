"""Both loops: exact motions, the order of convergence, energy kept to rounding, and contact."""

import re
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from conserving_loop import assert_followed
from small_studies import cases_of
from varied import in_steps, varied

import snapmap
from snapmap import Study
from snapmap.beam.cosines import symmetric_cosines
from snapmap.beam.elements import hermite_elements
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.cost import steps_and_seconds
from snapmap.solver.kernel import rows as R
from snapmap.solver.ledger import CellRun, Ledger
from snapmap.solver.models import build_model
from snapmap.solver.nodal import System, nodal_system
from snapmap.solver.options import MODELS, Cosines
from snapmap.solver.plain_loop import follow
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap


def march(device, N, f0, C, dt, duration, target=-np.inf, change=lambda system: system):
    """Reference history at every step: t, u, du/dt, y, dy/dt, work, swept; and the results."""
    basis = hermite_elements(5)
    steps = int(np.ceil(duration / dt))
    history = np.zeros((steps, 2 * basis.load.size + 4))
    system = change(nodal_system(device, basis))
    shock = make_pulse().curve, N * device.gravity, f0
    result = follow(system, CellRun(*shock, C, target, dt, steps, history))
    return np.arange(steps) * dt, history, result


def versed_sine_response(t, amplitude, f0, omega):
    """Undamped oscillator at rest under -amplitude/2 (1 - cos 2 pi f0 t), pulse over at 1/f0."""
    forcing, tau = 2 * np.pi * f0, 1 / f0

    def forced(t):
        steady = (1 - np.cos(omega * t)) / omega**2
        swing = (np.cos(forcing * t) - np.cos(omega * t)) / (omega**2 - forcing**2)
        return -amplitude / 2 * (steady - swing)

    return np.where(t < tau, forced(t), forced(t) - forced(t - tau))


@pytest.mark.equation(2)
@pytest.mark.parametrize("f0", [0.4e-3, 1.5e-3, 6e-3])
def test_a_mass_that_flies_away_is_a_linear_oscillator(handout, f0):
    """Negative N pulls the mass off the beam at once: closed form, eq. (2) with P = 0."""
    omega = np.sqrt(handout.spring / handout.mass)
    t, history, _ = march(handout, -30.0, f0, 0.0, 0.03, 1 / f0 + 50.0)
    exact = versed_sine_response(t, -30.0 * handout.gravity, f0, omega)
    flying = exact > 0.01 * exact.max()
    assert flying.mean() > 0.5
    # The beam follows the frame a little and touches at the very start; 1e-5 of the peak is all.
    np.testing.assert_allclose(history[:, 18][flying], exact[flying], atol=2e-5 * exact.max())


def test_the_plain_loop_converges_with_order_two_before_first_separation(handout):
    duration, ends = 60.0, []
    for n in (2400, 4800, 9600, 19200):
        dt = duration / n
        _, history, _ = march(handout, 1000.0, 1.5e-3, 200.0, dt, duration + 1.5 * dt)
        assert history[n // 4 :, 18].max() < 0
        ends.append(history[n, [8, 18]])
    differences = np.abs(np.diff(ends, axis=0))
    assert np.log2(differences[:-1] / differences[1:]) == pytest.approx(2.0, abs=0.1)


def stability_limits(device, basis, mass):
    """2/omega_max, us, of bending, of the tangent at the start, and of that at -1.5 q0."""
    beam, n = device.beam, len(mass)
    axial, touch = 2 * beam.axial_stiffness, np.append(basis.midpoint, -1.0)
    inertia, limits = np.zeros((n + 1, n + 1)), []
    inertia[:n, :n], inertia[n, n] = mass, device.mass
    for stretched, q in (0, basis.start), (1, basis.start), (1, -1.5 * basis.start):
        slope, tangent = basis.geometric @ q, np.zeros((n + 1, n + 1))
        N = beam.axial_stiffness * (basis.start @ basis.geometric @ basis.start - q @ slope)
        stiff = basis.bending + stretched * (axial * np.outer(slope, slope) - N * basis.geometric)
        tangent[:n, :n], tangent[n, n] = stiff, device.spring
        tangent += stretched * device.contact * np.outer(touch, touch)
        limits.append(2 / np.sqrt(scipy.linalg.eigh(tangent, inertia, eigvals_only=True)[-1]))
    return limits


@pytest.mark.equation(12, 14)
def test_central_differences_are_stable_up_to_the_limit_of_the_tangent(handout):
    """Those of the page's table; a weak shock stays weak below the limit, and grows above it."""
    elements = hermite_elements(5).scaled_to(handout.beam)
    limits = stability_limits(handout, elements, elements.mass)
    assert limits == pytest.approx([0.03584, 0.03584, 0.03305], abs=5e-6)
    h = handout.beam.span / 10
    lumped = np.tile([1.0, h * h / 39], 5)[:-1] * 2 * h
    lumped[-1] /= 2
    lumped *= handout.beam.density * handout.beam.area
    # Here slopes are those by x / L.
    lumped[1::2] /= handout.beam.span**2
    found = stability_limits(handout, elements, np.diag(lumped))
    assert found == pytest.approx([0.07394, 0.07393, 0.06819], abs=5e-6)
    cosines = symmetric_cosines(3).scaled_to(handout.beam)
    found = stability_limits(handout, cosines, cosines.mass)
    assert found == pytest.approx([0.508, 0.472, 0.254], abs=5e-4)
    steps = (share * limits[1] for share in (0.99, 1.01))
    runs = (march(handout, 1e-3, 1.5e-3, 0.0, step, 200.0)[1] for step in steps)
    below, above = (abs(run[:, :9]).max() for run in runs)
    assert below < 1e-3 and not above < 1.0


def test_the_handouts_shock_snaps_the_beam_by_its_own_load(handout):
    """N = 1000 at 1500 Hz snaps; without the beam's own load, as in eq. (3), it would not."""
    w2 = handout.beam.second_equilibrium - handout.beam.rise
    asked = handout, 1000.0, 1.5e-3, 0.025, 0.0276, 2167.0, w2
    t_snap, *_ = march(*asked)[2]
    assert t_snap == pytest.approx(434.89, abs=0.02)
    t_snap, *_ = march(*asked, lambda system: system._replace(load=0 * system.load))[2]
    assert np.isnan(t_snap)


def test_the_ledger_closes_to_second_order_while_the_contact_holds_energy(handout):
    runs = (march(handout, 800.0, 1.5e-3, 25.0, dt, 300.0)[2] for dt in (0.03, 0.015))
    errors = [error for _, error, _ in runs]
    assert errors[0] < 1e-7 and errors[0] / errors[1] == pytest.approx(4, rel=0.1)


DEVICES = cases_of(__file__)


@pytest.mark.equation(36, 37, 38)
@pytest.mark.parametrize(("dt", "steps"), [(0.05, 1200), (0.4, 150)])
@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("kind", ["cosines", "elements"])
def test_the_kernel_follows_the_plain_loop_to_rounding(handout, kind, name, dt, steps):
    model = build_model(varied(handout, **DEVICES[name]), MODELS[kind](modes=3))
    motion, _ = assert_followed(model, make_pulse("half sine"), 3000.0, 2e4, 25.0, dt, steps)
    assert np.ptp(motion.y) > 1 and np.ptp(motion.u, axis=0).all()


@pytest.mark.equation(35)
@pytest.mark.parametrize("kind", ["cosines", "elements"])
@pytest.mark.parametrize("name", DEVICES)
def test_energy_is_conserved_to_rounding(handout, name, kind):
    """Over thousands of impacts, in steps a hundred times apart."""
    device = varied(handout, **DEVICES[name])
    model = build_model(device, MODELS[kind](modes=3))
    model = replace(model, barrier=model.barrier._replace(energy=0.0))
    cells = to_cells(device, 0, [880.0, 1100.0, 1500.0], 1500.0, [0.0, 0.025, 25.0], 5000.0)
    for factor in (1.0, 10.0, 100.0):
        moved = Run(horizon=5000.0).but(until="moved")
        seen = model.with_step(factor).follow_once(cells, moved)
        assert seen.energy_error.max() < 1e-11


def test_the_kernel_converges_with_order_two_until_contact_opens(handout, fix_step):
    """Position and speed of midpoint and mass at 300 us, pressed together by a long pulse."""
    ends = []
    for step in (0.4, 0.2, 0.1, 0.05):
        fix_step(step)
        run = snapmap.simulate(Study(handout, "3 cosines"), 800.0, 500.0, 25.0)
        early = run.sel(time=slice(20, 300))
        assert (early.contact_force > 0).all()
        end = run[["w_mid", "z_mass"]].interp(time=300.0, method="cubic")
        ends.append([end.w_mid.item(), end.z_mass.item()])
    errors = np.abs(np.diff(ends, axis=0))
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(np.full((2, 2), 2.0), abs=0.3)


def test_a_penalty_without_end_is_hard_contact_in_the_same_step(handout):
    """The step knows nothing of contact, and a penalty without end is hard contact."""
    devices = (varied(handout, contact=contact) for contact in (np.inf, 1e12))
    hard, stiff = (build_model(device, Cosines(modes=5)) for device in devices)
    assert hard.steps.longest == stiff.steps.longest
    cells = to_cells(handout, 0, np.linspace(700, 1900, 24), 1500.0, 25.0, 300.0)
    ended = Run(horizon=300.0, until="snap")
    t_snaps = [model.follow(cells, ended).t_snap for model in (hard, stiff)]
    np.testing.assert_allclose(*t_snaps, rtol=1e-6)
    assert np.isfinite(t_snaps[0]).any() and np.isnan(t_snaps[0]).any()


def threshold(device, name, C=0.025, step=None, **size):
    model, settings = build_model(device, MODELS[name](**size)), Run(horizon=300.0, until="snap")
    model = in_steps(model, step) if step else model
    probe = Probe(model, to_rows(0, 1500.0, C), settings)
    return lowest_snap(probe, (700.0, 1100.0), 1e-6).item()


def test_the_handouts_elements_have_the_threshold_of_the_reference(handout):
    """In small steps: two schemes of one equation."""
    reference = threshold(handout, "reference", 25.0, step=0.4, elements=3)
    fast = threshold(handout, "elements", 25.0, step=0.2, elements=3)
    assert fast == pytest.approx(reference, rel=1e-5)


@pytest.mark.equation(5)
def test_hard_contact_is_the_limit_of_a_rising_penalty(handout):
    size = {"elements": 20, "modes": 9}
    hard, *soft = (varied(handout, contact=k) for k in (np.inf, 40.0, 400.0, 4000.0))
    limit = threshold(hard, "cosines", modes=9, step=0.25)
    assert threshold(hard, "elements", **size, step=0.25) == pytest.approx(limit, rel=2e-4)
    shifts = [threshold(device, "elements", **size) / limit - 1 for device in soft]
    assert shifts[0] == pytest.approx(0.08, abs=0.005)
    assert shifts[0] > 8 * shifts[1] > 0 and shifts[1] > 5 * shifts[2] > 0


def test_every_row_and_every_variable_stands_in_the_table_of_symbols(root):
    section = (root / "docs" / "theory.md").read_text().split("## Symbols")[1].split("\n## ")[0]
    table = [line.split("|")[1:3] for line in section.splitlines() if line.startswith("| ")]
    columns = map(" ".join, zip(*table, strict=True))
    in_kernel, in_plain_loop = (re.findall(r"`(\w+)`", column) for column in columns)
    bounds = {"LANES", "STATE", "VECTORS"}
    assert sorted(in_kernel) == sorted({name for name in vars(R) if name.isupper()} - bounds)
    assert set(System._fields) <= set(in_plain_loop)
    of_loop = {*CellRun._fields, *Ledger._fields}
    of_loop |= {*System._fields, *follow.py_func.__code__.co_varnames}
    assert set(in_plain_loop) <= of_loop


def test_a_step_of_the_plain_loop_is_expected_to_take_longest(handout):
    def seconds_of_a_step(name):
        cells = to_cells(handout, 0, 900.0, [1000.0], 25.0, 1500.0)
        model = build_model(handout, MODELS[name]())
        dt, seconds = steps_and_seconds(model, cells, Run(until="snap"))
        return (seconds * dt / cells.t_end).item()

    assert seconds_of_a_step("reference") > 10 * seconds_of_a_step("elements")
