"""Quiet time between blows: runs that jump over it agree with runs that follow every step."""

from dataclasses import replace

import numpy as np
import pytest
from varied import varied

from snapmap.applications.histories.motion import record
from snapmap.pulse.shocks import make_drop, make_train
from snapmap.solver.cells import to_cells
from snapmap.solver.models import build_model
from snapmap.solver.motion import stress_rows
from snapmap.solver.options import Cosines
from snapmap.solver.settings import Run
from snapmap.solver.simd_loop import watch

BLOW = {"shape": "half sine", "duration": 500.0}
DROP = make_drop({"height": 1e4, "duration": 300.0, "shape": "half sine", "rebound": 0.3})
RING = 2 * np.pi / np.sqrt(5.5e-4)
"""Period of the handout's mass on its spring, us."""


def train(wait, times=3):
    return make_train([BLOW, {"wait": wait}, {"repeat": times}])


def without_quiet(pulse):
    """The same, but for the last bits: waits and flights rise by next to nothing."""
    pieces = pulse.pieces.copy()
    flat = (pieces[:, 2] == 0) & (pieces[:, 3] == 0)
    pieces[flat, 2] = 1e-30
    return replace(pulse, pieces=pieces)


@pytest.fixture(scope="module")
def calm(handout):
    """The handout's device with some damping of the beam."""
    return build_model(varied(handout, damping=4e-3), Cosines(modes=3))


def follow(model, pulse, N, C, until="settled", start="first"):
    N, C = np.broadcast_arrays(N, C)
    cells = to_cells(model.device, 0, N, 1e6 / pulse.duration, C, 1500.0, 0, (pulse,))
    return model.follow(cells, Run(start=start).but(until=until))


def both(model, pulse, N, C, until="settled", start="first"):
    """Observations with jumps, and without."""
    asked = N, C, until, start
    return follow(model, pulse, *asked), follow(model, without_quiet(pulse), *asked)


def are_the_same(one, other):
    return all(a.tobytes() == b.tobytes() for a, b in zip(one[:8], other[:8], strict=True))


@pytest.mark.parametrize("until", ["settled", "snap", "edge"])
@pytest.mark.parametrize("pulse", [train(9000.0), train(20000.0), DROP], ids=["9", "20", "drop"])
def test_a_run_that_jumps_sees_what_one_does_that_follows_every_step(calm, pulse, until):
    """Snaps at the first and at later blows, and the well in which each beam ends."""
    N, C = np.array([300, 800, 960, 1010, 1040, 1100, 1300.0]), np.array([[25.0], [200.0]])
    jumped, followed = both(calm, pulse, N, C, until)
    assert not are_the_same(jumped, followed)
    np.testing.assert_array_equal(jumped.well, followed.well)
    errors = {"t_snap": 1e-2, "t_settled": 1e-2, "pulse_work": 0.02, "lowest": 1e-3}
    for key, error in errors.items():
        np.testing.assert_allclose(getattr(jumped, key), getattr(followed, key), atol=error)
    assert (jumped.energy_error < 1e-11).all()


@pytest.mark.parametrize("C", [5.0, 25.0, 200.0, 2000.0])
def test_what_a_jump_leaves_out_moves_no_later_blow(calm, C):
    """Whatever the wait; 2000 damps the mass so far that it creeps back."""
    for wait in (2000.0, 6000.0, 12000.0, 50000.0):
        jumped, followed = both(calm, train(wait, 2), [700.0], C, "edge")
        assert np.isnan(followed.t_snap).all()
        np.testing.assert_allclose(jumped.lowest, followed.lowest, rtol=1e-4)


def test_nothing_jumps_where_the_ring_matters(calm, handout):
    """Light damping, a beam without any, a blow that is timed on the ring, a history."""
    N, undamped = [500.0, 900.0, 1000.0], build_model(handout, Cosines(modes=3))
    assert are_the_same(*both(calm, train(20000.0), N, 0.025))
    assert are_the_same(*both(undamped, train(20000.0), N, 25.0))
    for periods in (2.0, 2.5, 4.0):
        assert are_the_same(*both(calm, train(periods * RING - 500.0), N, 25.0))
    assert are_the_same(*both(calm, train(20000.0), N, 25.0, "shown"))


def extremes(model, pulse, N, C):
    """Of w and stress in lanes, of the mass by itself, and the number of steps that were followed.

    Each is (kinds, N), the number (lanes or each cell alone,).
    """
    cells = to_cells(model.device, 0, N, 1e6 / pulse.duration, C, 1500.0, 0, (pulse,))
    dt = model.time_steps(cells, Run().but(until="moved"))
    steps = np.ceil(cells.t_end / dt).astype(int)
    stress = np.broadcast_to(stress_rows(model), (N.size, *stress_rows(model).shape[1:]))
    watched = watch(model, cells, dt, steps, "first", stress)
    seen = [[w.min(0), w.max(0), s.max(0)] for _, (w, s) in watched]
    each = (record(model, cells.take([i]), dt[[i]], jumps=True)[1] for i in range(N.size))
    alone = [[part.y for part in parts] for parts in each]
    ways = [(np.concatenate(y).min(), np.concatenate(y).max()) for y in alone]
    lows, highs, most = np.array(seen).swapaxes(0, 1)
    values = np.stack([lows.min(0), highs.max(0), most.max(0), *np.transpose(ways)])
    return values, len(seen), sum(map(len, alone))


@pytest.mark.parametrize("pulse", [train(20000.0), DROP], ids=["train", "drop"])
def test_extremes_are_those_of_every_step(calm, pulse):
    """Also of a weak shock, which shows its largest travel after the blow, at little energy."""
    asked = np.array([3.0, 30.0, 300.0, 900.0]), 25.0
    found = (extremes(calm, each, *asked) for each in (pulse, without_quiet(pulse)))
    (ours, *windows), (theirs, *all_windows) = found
    assert np.less(windows, np.divide(all_windows, 3)).all()
    np.testing.assert_allclose(ours, theirs, rtol=1e-5, atol=1e-9)


def test_a_jump_does_not_depend_on_other_lanes(calm):
    N = np.linspace(600, 1400, 40)
    together = follow(calm, DROP, N, 25.0)
    for i in (0, 17, 39):
        assert are_the_same(together.take(slice(i, i + 1)), follow(calm, DROP, N[i : i + 1], 25.0))


def test_a_run_from_the_second_shape_jumps_too(calm):
    jumped, followed = both(calm, train(20000.0), [300.0, 900.0, 3000.0], 200.0, start="second")
    assert not are_the_same(jumped, followed)
    np.testing.assert_array_equal(jumped.well, followed.well)
    np.testing.assert_allclose(jumped.t_snap, followed.t_snap, atol=1e-2)
    np.testing.assert_allclose(jumped.lowest, followed.lowest, atol=1e-3)
