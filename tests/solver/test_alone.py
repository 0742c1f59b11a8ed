"""A beam that no mass meets: shaken, or pushed at its midpoint."""

import numpy as np
import pytest
from varied import alone, varied

import snapmap
from snapmap import Study
from snapmap.pulse.pulse import Pulse

F0, CHEAP = 20_000.0, {"model": "3 cosines"}
STEP = Pulse("step", np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]]))


def test_a_force_moves_the_beam_alike_in_the_plain_loop_and_the_kernel(handout):
    device, load = alone(handout, 1.0), (60.0, F0, 0.0)
    models = ({"name": name, "elements": 3} for name in ("reference", "elements"))
    runs = (snapmap.simulate(Study(device, model), *load) for model in models)
    oracle, fast = (np.ptp(run.w_mid.values) for run in runs)
    assert oracle > 1.0 and fast == pytest.approx(oracle, rel=1e-4)


@pytest.mark.parametrize(("Q", "bound"), [(5, 318.6), (12, 343.351)])
def test_a_step_below_the_energy_of_the_tilted_saddle_never_snaps(handout, Q, bound):
    """Proven: a force F held from rest on gives the beam F w at most, and the saddle takes more."""
    thickness = handout.beam.rise / Q
    made = {"free": 1.0, "thickness": thickness, "imperfection": 1e-4 * thickness}
    unit = alone(handout, **made).beam
    device = alone(handout, unit.stiffness_unit * unit.rise, **made)
    N, shock = bound * np.array([0.6, 0.9, 0.97, 0.999, 1.3]), {"pulse": STEP, "horizon": 0.0}
    cube = snapmap.sweep(Study(device, "3 cosines", until="snap", **shock), N, [500.0], [0.0])
    assert cube.t_snap.isnull().values.ravel().tolist() == [True] * 4 + [False]


def test_a_beam_alone_does_not_depend_on_its_mass(handout):
    """No C, spring or contact alters a bit, and both loops agree."""
    device, asked = alone(handout, damping=4e-3), {"until": "settled", "horizon": 300.0, **CHEAP}
    N = np.array([1e5, 1.3e5, 1.4e5])
    first = snapmap.sweep(Study(device, **asked), N, [F0], [0.0, 25.0])
    other = snapmap.sweep(Study(varied(device, spring=9.0, contact=7.0), **asked), N, [F0], [0.0])
    for key in ("t_snap", "t_settled", "pulse_work", "outcome"):
        np.testing.assert_array_equal(first[key][0], first[key][1])
        np.testing.assert_allclose(first[key][0], other[key][0], rtol=1e-10)
    slow = snapmap.sweep(Study(device, "reference"), N, [F0], [0.0])
    np.testing.assert_allclose(first.t_snap[0], slow.t_snap[0], rtol=1e-2)


def test_a_force_changes_no_velocity(handout):
    devices, asked = (alone(handout), alone(handout, 1.0)), CHEAP | {"horizon": 100.0}
    shaken, pushed = (snapmap.threshold(Study(device, **asked), [F0], [0.0]) for device in devices)
    assert shaken.velocity_change > 0 and pushed.velocity_change.isnull()
    assert pushed.N_first.notnull()


def test_a_history_has_the_beam_alone(handout):
    run = snapmap.simulate(Study(alone(handout, 1.0), **CHEAP), 60.0, F0, 0.0)
    assert np.isnan([run.toward_max, run.away_max, run.contact_force_max]).all()
    assert run.z_mass.isnull().all() and run.midpoint_force.max() == pytest.approx(60.0, rel=1e-4)
    kept = run.kinetic_energy + run.bending_energy + run.axial_energy - run.pulse_work
    assert abs(kept).max() < 1e-3 * run.pulse_work.max()
