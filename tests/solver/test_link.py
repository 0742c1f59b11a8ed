"""The weak link: another integrator, the plain loop, limits, energy, statics, and the door."""

import numpy as np
import pytest
from modal_by_scipy import time_of_snap
from varied import alone, varied

import snapmap
from snapmap.beam.equilibria import find_barrier, shapes_of
from snapmap.beam.statics import statics
from snapmap.config.devices import read_device
from snapmap.device import batch
from snapmap.figures.states import HELD, REST_PROVEN, end_states
from snapmap.io.provenance import device_sections
from snapmap.pulse import make_pulse
from snapmap.solver.bounds import least_amplitudes
from snapmap.solver.cells import to_cells, to_rows
from snapmap.solver.models import build_model
from snapmap.solver.outcome import OUTCOMES
from snapmap.solver.search import lowest_snap
from snapmap.solver.settings import Settings

SHOCK = 1500.0, 25.0


def linked(device, at, stiffness, strength):
    values = {"link_at": at, "link_stiffness": stiffness, "link_strength": strength}
    return varied(device, **values)


@pytest.mark.parametrize("link", [(-6.0, 200.0, 150.0), (-3.0, 2000.0, 60.0)])
def test_when_the_link_breaks_by_another_integrator(handout, link):
    model = build_model(linked(handout, *link), "cosines", modes=3)
    N = np.array([900.0, 1100.0, 1800.0])
    cells = to_cells(handout, 0, N, *SHOCK, 0.0)
    fine = model.with_step(0.1).follow_once(cells, Settings(0.0, until="snap"))
    f0, C = 1e-6 * SHOCK[0], SHOCK[1]
    theirs = [time_of_snap(model, make_pulse(), each, f0, C, 1 / f0) for each in N]
    assert np.isnan(theirs[0]) and np.isfinite(theirs[1:]).all()
    np.testing.assert_allclose(fine.t_snap, theirs, rtol=2e-5)


def test_the_plain_loop_breaks_it_at_the_same_time_with_the_same_energy_left(handout):
    device = linked(handout, -6.0, 200.0, 50.0)
    seen = [
        build_model(device, name)
        .with_step(step)
        .follow_once(to_cells(device, 0, [900.0, 1050.0, 1300.0], *SHOCK, 0.0), Settings(0.0))
        for name, step in (("handout", 0.1), ("reference", 0.5))
    ]
    np.testing.assert_allclose(*(one.t_snap for one in seen), rtol=3e-5)
    np.testing.assert_allclose(*(one.energy_left for one in seen), rtol=0.01)
    assert np.isfinite(seen[0].t_snap).tolist() == [False, True, True]
    device = linked(handout, -6.0, 200.0, 150.0)
    for name, closed in (("handout", 1e-9), ("reference", 1e-3)):
        run = snapmap.simulate(device, 1100.0, *SHOCK, name, horizon=0.0)
        energy = sum(run[key] for key in run if key.endswith("_energy") and key[:4] != "diss")
        whole = energy + run.dissipated_energy - run.pulse_work
        assert abs(whole).max() < closed * run.pulse_work.max()
        assert 100.0 < run.link_force.max() <= 150.0
        assert run.link_energy.max() <= 150.0**2 / (2 * 200.0)


def test_the_limits_of_no_strength_and_of_one_without_end(handout):
    """What breaks at a touch changes no motion; what no shock can break is never broken."""
    free = snapmap.simulate(handout, 1300.0, *SHOCK, "cosines", modes=3, step=0.05)
    brittle = linked(handout, -6.0, 200.0, 1e-9)
    run = snapmap.simulate(brittle, 1300.0, *SHOCK, "cosines", modes=3, step=0.05)
    np.testing.assert_allclose(run.w_mid[:-400], free.w_mid[:-400], atol=1e-3)
    # H <= m/2 (integral of |a|)^2, `solver/bounds.py`.
    pushed = 1800.0 * handout.gravity / (2e-6 * SHOCK[0])
    energy = (handout.mass + handout.beam.weight) / 2 * pushed**2
    strong = linked(handout, -8.0, 200.0, np.sqrt(2 * 200.0 * energy))
    cube = snapmap.sweep(strong, [900.0, 1100.0], *([each] for each in SHOCK), "cosines", modes=3)
    assert cube.t_snap.isnull().all()
    assert [OUTCOMES[code] for code in cube.outcome.values.ravel()] == ["never", "held"]
    assert end_states(cube).values.ravel().tolist() == [REST_PROVEN, HELD]


def test_a_bound_of_the_energy_to_break_it_lies_below_the_static_path(handout):
    """Equal to it where the second mode is active, a parabola about the saddle."""
    path = statics(handout).isel(branch=0)
    barrier = find_barrier(handout.beam, shapes_of(handout.beam))
    before = path.displacement.values < -barrier.midpoint
    points = path.displacement.values[before][::40], path.energy.values[before][::40]
    for d, energy in zip(*points, strict=True):
        device = linked(handout, barrier.first - d - 1e-12, 1e9, 1e-3)
        least = build_model(device, "cosines", modes=5).least_energy
        assert least < energy + 1e-6 * barrier.energy
        if d > 2.4:
            assert least == pytest.approx(min(energy, barrier.energy), rel=1e-5)
    rows = to_rows(0, [500.0, 5000.0], 25.0)
    model = build_model(batch([linked(handout, 5.0, 200.0, 50.0)]), "cosines", modes=5)
    found = lowest_snap(model, rows, (np.full(2, 500.0), np.full(2, 6e3)), Settings(0.0), 1e-3)
    assert (least_amplitudes(model, rows) < found).all()


def test_a_slow_push_breaks_it_at_its_strength_and_the_beams_own_force(handout):
    """A force on the midpoint of a beam alone, with damping that no ringing survives."""
    path = statics(handout).isel(branch=0)
    device = linked(alone(handout, 1.0, gravity=1.0, damping=0.5), 9.0, 1000.0, 30.0)
    static = np.interp(1.03, path.displacement[:400], path.force[:400]) + 30.0
    rows, bracket = to_rows(0, [200.0], 0.0), (np.full(1, 20.0), np.full(1, 200.0))
    errors = []
    for modes in (5, 11):
        model = build_model(batch([device]), "cosines", modes=modes)
        N = lowest_snap(model, rows, bracket, Settings(0.0), 1e-5).item()
        errors.append(abs(N - static) / static)
    assert errors[1] < 2e-3 and errors[1] < errors[0] / 4  # modes left out give by 1/modes^3


def test_the_door(handout):
    document = device_sections(linked(handout, -3.0, 200.0, 50.0))["device"]
    assert read_device(document) == linked(handout, -3.0, 200.0, 50.0)
    section = dict(document["link"])
    del section["strength"]
    by_energy = read_device(document | {"link": {**section, "energy": "6.25 pJ"}})
    assert by_energy.link_strength == pytest.approx(50.0)
    for both in (document["link"] | {"energy": "1 pJ"}, section):
        with pytest.raises(ValueError, match="link: write one of strength and energy"):
            read_device(document | {"link": both})
    off = "link.at: -9.5 um is not between the second shape, -9.434"
    with pytest.raises(ValueError, match=off):
        snapmap.threshold(linked(handout, -9.5, 200.0, 50.0), [1500.0], [25.0])
    cube = snapmap.sweep(by_energy, [1100.0], [1500.0], [25.0], link_strength=[0.0, 20.0],
                         model="cosines", until="snap")  # fmt: skip
    assert (cube.energy_left.notnull().values.ravel() == [False, True]).all()
