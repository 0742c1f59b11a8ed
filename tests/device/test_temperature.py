"""Temperature: the axis that sets modulus, stress and damping together."""

import dataclasses

import numpy as np
import pytest

import snapmap
from snapmap.device.device import batch
from snapmap.solver.cells import to_cells
from snapmap.study.axes import make_grid

THERMAL = {"modulus_slope": -63e-6, "expansion_mismatch": -0.5e-6, "damper_exponent": 0.7}


@pytest.fixture(scope="module")
def silicon(handout):
    return dataclasses.replace(handout, **THERMAL)


def at(device, temperature, **values):
    columns = {key: np.array([value]) for key, value in values.items()}
    return batch([device]).vary({"temperature": np.array([temperature]), **columns}).pick(0)


def test_modulus_stress_and_damping_follow_the_temperature(silicon):
    hot = at(silicon, 120.0)
    assert hot.beam.youngs_modulus == pytest.approx(150e3 * (1 - 63e-4), rel=1e-15)
    assert hot.beam.residual_stress == pytest.approx(150e3 * 0.5e-4, rel=1e-15)
    (C,) = to_cells(batch([hot]), [0], [1000.0], [1500.0], [25.0], 0.0).damping
    assert pytest.approx(25 * (393.15 / 293.15) ** 0.7, rel=1e-15) == C


def test_the_way_there_does_not_matter(silicon):
    once, twice = at(silicon, -40.0), at(at(silicon, 300.0), -40.0)
    assert twice.beam.youngs_modulus == pytest.approx(once.beam.youngs_modulus, rel=1e-14)
    assert twice.beam.residual_stress == pytest.approx(once.beam.residual_stress, rel=1e-12)
    assert at(silicon, 20.0).beam == silicon.beam


def test_the_axis_is_the_device_with_other_values(silicon):
    asked = {"f0": [1500.0], "model": "cosines", "horizon": 0}
    along = snapmap.threshold(silicon, C=[25.0], temperature=[-40.0, 20.0, 120.0], **asked)
    hot = at(silicon, 120.0)
    factor = (393.15 / 293.15) ** 0.7
    apart = dataclasses.replace(hot, damper_exponent=0.0)
    alone = snapmap.threshold(apart, C=[25.0 * factor], **asked)
    assert along.N_first.values[2].item() == pytest.approx(alone.N_first.item(), rel=1e-9)
    assert along.temperature.attrs["units"] == "degC"


@pytest.mark.parametrize("beam", [{"cosine_2": 0.2, "residual_stress": -20.0}, {"rise": 4.0}])
def test_a_second_shape_is_needed_at_the_temperature_alone(handout, beam):
    made = dataclasses.replace(handout.beam, **beam)
    cold = dataclasses.replace(handout, beam=made, expansion_mismatch=9e-6)
    grid = make_grid(cold, {"temperature": [20.0, 120.0]}, skip=True)
    assert grid.device_of.tolist() == [-1, 0]
    assert grid.device.beam.residual_stress == pytest.approx([made.residual_stress - 150e3 * 9e-4])
    assert len(make_grid(cold, {"temperature": [120.0]}).device) == 1
    with pytest.raises(ValueError, match=r"temperature = 20 degC: device.beam: .* second stable"):
        make_grid(cold, {"temperature": [20.0, 120.0]})
