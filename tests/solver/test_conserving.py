"""The conserving scheme: its equations, energy, order and limit, and where it is not believed."""

import dataclasses

import numpy as np
import pytest
from conserving_loop import assert_followed, inertia
from varied import varied

import snapmap
from snapmap.pulse.pulse import make_pulse, table
from snapmap.solver import simd_loop
from snapmap.solver.cells import to_cells
from snapmap.solver.kernel import rows as R
from snapmap.solver.kernel.lanes import load
from snapmap.solver.kernel.pulse import BLOCK, begin_pulse, no_pulse, set_out
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.kernel.step import advance
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings

CONTACTS = (40.0, 4000.0, np.inf)


def states(model, N, C, dt, steps):
    """Every row of X after each step of one cell, (steps, rows)."""
    lanes, device = simd_loop.empty_lanes(model), simd_loop.coefficients(model, -np.inf)[0]
    load(*lanes, 0, device, C, N * model.device.gravity, dt)
    pulses, shocks, state = table([make_pulse()]), np.zeros(BLOCK * LANES), no_pulse()
    begin_pulse(lanes[0], 0, state, pulses, 0, 1.5e-3 * dt)
    found = []
    for step in range(steps):
        if step % BLOCK == 0:
            state.steps[:] = step
            set_out(lanes[0], shocks, state, pulses)
        advance(*lanes, shocks, step % BLOCK, 1)
        found.append(lanes[0][::LANES].copy())
    return np.array(found)


def vector(found, which, modes):
    return found[:, R.VECTORS + which * modes :][:, :modes]


@pytest.mark.parametrize("dt", [0.1, 2.0])
@pytest.mark.parametrize("contact", CONTACTS)
def test_each_step_solves_the_equations_of_the_scheme(handout, contact, dt):
    """With stretch, gap and all means written out from three instants, in numpy."""
    device, C = varied(handout, contact=contact, damping=4e-4), 25.0
    model = build_model(device, "cosines", modes=5)
    modal, modes = model.modal, model.modes
    found = states(model, 1500.0, C, dt, 4000)
    heavier = inertia(modal.stiffness, dt)
    p, y = vector(found, R.P, modes) / np.sqrt(heavier), found[:, R.Y]
    a = found[2:, R.A] / dt**2

    ahead = p[:-1] @ modal.geometric
    q = np.sum(ahead * p[1:], axis=1) + (p[:-1] + p[1:]) @ modal.slope_start
    x = (p[:-1] + p[1:]) @ modal.midpoint / 2 - (y[:-1] + y[1:]) / 2
    stiffness = simd_loop.contact_stiffness(device, modal.residual)
    closed = np.maximum(x, 0.0) ** 2
    with np.errstate(invalid="ignore"):
        P = stiffness / 2 * (closed[1:] - closed[:-1]) / (x[1:] - x[:-1])
    mean_q = (q[1:] + q[:-1]) / 2
    u = p[1:-1] @ modal.geometric + modal.slope_start
    mean_p, mean_y = ((z[2:] + 2 * z[1:-1] + z[:-2]) / 4 for z in (p, y))
    force = -modal.stiffness * mean_p - (modal.axial * mean_q)[:, np.newaxis] * u
    force -= a[:, np.newaxis] * modal.load + P[:, np.newaxis] * modal.midpoint
    own = heavier - dt**2 * modal.stiffness / 4
    swings = own * (p[2:] - 2 * p[1:-1] + p[:-2])
    drag = device.beam.damping * dt / 2 * heavier * (p[2:] - p[:-2])
    residual = swings + drag - dt**2 * force
    pull = P - device.mass * a - device.spring * mean_y
    swings = device.mass * (y[2:] - 2 * y[1:-1] + y[:-2])
    of_mass = swings + C * dt / 2 * (y[2:] - y[:-2]) - dt**2 * pull
    scale = dt**2 * np.abs(force).max(), dt**2 * np.abs(pull).max()
    # The difference quotient of P loses digits where the gap hardly moves.
    sure = np.abs(x[1:] - x[:-1]) > 1e-3 * np.abs(x[1:] - x[:-1]).max()
    assert np.abs(residual[sure]).max() < 1e-8 * scale[0]
    assert np.abs(of_mass[sure]).max() < 1e-8 * scale[1]

    kinds = (x[1:] > 0).astype(int) + 2 * (x[:-1] > 0)
    assert np.unique(kinds[sure]).tolist() == [0, 1, 2, 3], "a kind of contact is not there"
    np.testing.assert_allclose(found[1:, R.Q], q, atol=1e-9 * np.abs(q).max())
    np.testing.assert_allclose(found[1:, R.OVERLAP], x, atol=1e-9 * np.abs(x).max())


DEVICES = {
    "soft": {},
    "hard": {"contact": np.inf},
    "gap": {"gap": 1.0, "contact": 4000.0},
    "stops": {"stop_toward": 4.0, "stop_away": 1.0, "restitution": 0.8},
    "damped": {"damping": 4e-3},
    "tilting": {"free": 1.0, "imperfection": 0.05, "residual_stress": -8.0},
}


@pytest.mark.parametrize(("dt", "steps"), [(0.05, 1200), (0.4, 150)])
@pytest.mark.parametrize("name", DEVICES)
@pytest.mark.parametrize("kind", ["cosines", "elements"])
def test_the_kernel_follows_the_plain_loop_to_rounding(handout, kind, name, dt, steps):
    model = build_model(varied(handout, **DEVICES[name]), kind, modes=3)
    motion, _ = assert_followed(model, make_pulse("half sine"), 3000.0, 2e4, 25.0, dt, steps)
    assert np.ptp(motion.y) > 1 and np.ptp(motion.u, axis=0).all()


@pytest.mark.parametrize("kind", ["cosines", "elements"])
@pytest.mark.parametrize("name", DEVICES)
def test_energy_is_conserved_to_rounding(handout, name, kind):
    """Over thousands of impacts, in steps a hundred times apart."""
    device = varied(handout, **DEVICES[name])
    model = build_model(device, kind, modes=3)
    model = dataclasses.replace(model, barrier=model.barrier._replace(energy=0.0))
    cells = to_cells(device, 0, [880.0, 1100.0, 1500.0], 1500.0, [0.0, 0.025, 25.0], 5000.0)
    for factor in (1.0, 10.0, 100.0):
        seen = model.with_step(factor).follow_once(cells, Settings(5000.0))
        assert seen.energy_error.max() < 1e-11


def test_the_order_is_two_until_contact_opens(handout, fix_step):
    """Position and speed of midpoint and mass at 300 us, pressed together by a long pulse."""
    ends = []
    for step in (0.4, 0.2, 0.1, 0.05):
        fix_step(step)
        run = snapmap.simulate(handout, 800.0, 500.0, 25.0, "cosines", modes=3)
        early = run.sel(time=slice(20, 300))
        assert (early.contact_force > 0).all()
        ends.append(
            [float(run[key].interp(time=300.0, method="cubic")) for key in ("w_mid", "z_mass")]
        )
    errors = np.abs(np.diff(ends, axis=0))
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders == pytest.approx(np.full(orders.shape, 2.0), abs=0.3)


def test_no_contact_is_too_stiff(handout):
    """The step knows nothing of contact, and a penalty without end is hard contact."""
    hard = build_model(varied(handout, contact=np.inf), "cosines", modes=5)
    stiff = build_model(varied(handout, contact=1e12), "cosines", modes=5)
    assert hard.steps.longest == stiff.steps.longest
    cells = to_cells(handout, 0, np.linspace(700, 1900, 24), 1500.0, 25.0, 300.0)
    found = [model.follow(cells, Settings(300.0, until="snap")).t_snap for model in (hard, stiff)]
    np.testing.assert_allclose(*found, rtol=1e-6)
    assert np.isfinite(found[0]).any() and np.isnan(found[0]).any()
