"""Other units of length, mass and time, and samples more than are needed, change no result."""

import numpy as np
import pytest
from varied import varied

import snapmap
from snapmap.beam.limit_loads import static_threshold
from snapmap.pulse.pulse import sampled
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import lowest_snap


def scaled(device, length, mass, time):
    """A similar device: every value multiplied by the power of its unit."""
    stiffness = mass / time**2
    factors = dict.fromkeys(("span", "rise", "thickness", "depth", "imperfection"), length)
    factors |= dict.fromkeys(("youngs_modulus", "residual_stress"), stiffness / length)
    factors |= {"density": mass / length**3, "damping": 1 / time}
    factors |= dict.fromkeys(("spring", "contact"), stiffness) | {"gap": length, "mass": mass}
    factors["gravity"] = length / time**2
    parts = {key: device.beam if hasattr(device.beam, key) else device for key in factors}
    return varied(device, **{key: factors[key] * getattr(parts[key], key) for key in factors})


@pytest.fixture(scope="module")
def device(handout):
    """One with a gap, residual stress and a damped beam."""
    return varied(handout, residual_stress=-8.0, damping=4e-3, gap=0.5)


@pytest.mark.parametrize("factors", [(3.0, 0.2, 7.0), (0.02, 50.0, 0.3)])
def test_similar_devices_answer_alike(device, factors):
    def ask(verb, length, mass, time, **values):
        rows = {"f0": np.array([400.0, 1500.0]) / time, "C": [200.0 * mass / time], **values}
        how = {"model": "cosines", "modes": 3, "horizon": 1500.0 * time}
        return verb(scaled(device, length, mass, time), **rows, **how)

    N = [600.0, 900.0, 1300.0, 1800.0]
    cube, similar = (ask(snapmap.sweep, *each, N=N) for each in ((1, 1, 1), factors))
    assert 0 < cube.t_snap.notnull().sum() < cube.t_snap.size
    np.testing.assert_array_equal(similar.outcome, cube.outcome)
    for key in ("t_snap", "t_settled"):
        np.testing.assert_allclose(similar[key] / factors[2], cube[key], rtol=1e-12)
    edge, similar = (ask(snapmap.threshold, *each) for each in ((1, 1, 1), factors))
    for key in ("N_first", "N_always", "N_static", "N_bound"):
        np.testing.assert_allclose(similar[key], edge[key], rtol=1e-12)
    # At its threshold the time of a snap magnifies what rounding does to N.
    np.testing.assert_allclose(similar.t_snap / factors[2], edge.t_snap, rtol=1e-10)


@pytest.mark.parametrize(("key", "low", "high"), [("thickness", 1.0, 4.0), ("rise", 5.0, 30.0)])
@pytest.mark.parametrize("change", [{}, {"contact": np.inf}, {"spring": 1.0}, {"spring": 20.0}])
def test_thicker_and_higher_beams_need_more(handout, change, key, low, high):
    devices = [varied(handout, **change, **{key: value}) for value in np.linspace(low, high, 7)]
    assert (np.diff([static_threshold(device) for device in devices]) > 0).all()


def test_thresholds_of_many_swings_are_those_of_a_quarter_of_the_step(handout):
    """Each swing needs its own steps: with those of one, N is wrong by 0.1 % and more."""
    x = np.linspace(0, 1, 1601)
    beats = sampled(500 * x, np.sin(np.pi * x) ** 2 * (1 - np.cos(32 * np.pi * x)) / 2)
    assert beats.variation > 15
    model = build_model(handout, "cosines", modes=3)
    rows = to_rows(0, [1000.0, 2000.0], [[0.025], [200.0]], pulses=(beats,))
    static, settings = static_threshold(handout), Settings(300.0, until="snap")
    search = rows, (0.5 * static, 6.0 * static), settings, 1e-5
    coarse, fine = (lowest_snap(each, *search) for each in (model, model.with_step(0.25)))
    np.testing.assert_allclose(coarse, fine, rtol=2e-4)
