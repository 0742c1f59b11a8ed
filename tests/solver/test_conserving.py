"""The conserving scheme: the plain loop of its equations, its energy, order and limit."""

from dataclasses import replace

import numpy as np
import pytest
from conserving_loop import assert_followed
from varied import varied

import snapmap
from snapmap.pulse.pulse import make_pulse
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings

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
    model = replace(model, barrier=model.barrier._replace(energy=0.0))
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
        end = run[["w_mid", "z_mass"]].interp(time=300.0, method="cubic")
        ends.append([end.w_mid.item(), end.z_mass.item()])
    errors = np.abs(np.diff(ends, axis=0))
    assert np.log2(errors[:-1] / errors[1:]) == pytest.approx(np.full((2, 2), 2.0), abs=0.3)


def test_no_contact_is_too_stiff(handout):
    """The step knows nothing of contact, and a penalty without end is hard contact."""
    devices = (varied(handout, contact=contact) for contact in (np.inf, 1e12))
    hard, stiff = (build_model(device, "cosines", modes=5) for device in devices)
    assert hard.steps.longest == stiff.steps.longest
    cells = to_cells(handout, 0, np.linspace(700, 1900, 24), 1500.0, 25.0, 300.0)
    found = [model.follow(cells, Settings(300.0, until="snap")).t_snap for model in (hard, stiff)]
    np.testing.assert_allclose(*found, rtol=1e-6)
    assert np.isfinite(found[0]).any() and np.isnan(found[0]).any()
