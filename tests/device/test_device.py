"""The device: what it refuses, its recipe, which is read back, and its temperature."""

import math
from dataclasses import replace

import numpy as np
import pytest
from small_studies import cases_of
from varied import varied

import snapmap
from snapmap import Study
from snapmap.config.devices import read_device
from snapmap.device.device import ALONE, FIXED, KINDS, VALUES, Beam, Device, batch
from snapmap.device.usual import USUAL
from snapmap.solver.cells import to_cells
from snapmap.study.axes import make_grid
from snapmap.study.provenance import device_sections

BEAM = Beam(span=600.0, rise=10.0, thickness=2.0, depth=22.0, youngs_modulus=1.5e5, density=0.00233)
NO_SECOND = r"^device\.beam: no .* rise/thickness = 4 um/2 um = 2 and "
DEVICE = Device(beam=BEAM, mass=1e4, spring=5.5, contact=40.0, gravity=9.81e-6)


def test_a_beam_without_a_second_shape_has_statics_alone():
    device, row = varied(DEVICE, rise=4.0), ([1500.0], [25.0])
    for ask, cells in (snapmap.threshold, row), (snapmap.sweep, ([900.0], *row)):
        with pytest.raises(ValueError, match=NO_SECOND):
            ask(device, *cells)
    with pytest.raises(ValueError, match=NO_SECOND):
        snapmap.simulate(device, 900.0, 1500.0, 25.0)
    statics = snapmap.statics(device)
    assert statics.largest_force > statics.least_force > 0  # it snaps, and returns by itself


SIZES = ["span", "thickness", "depth", "youngs_modulus", "density", "mass", "spring", "gravity"]


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_size_that_is_not_positive_and_finite_is_refused(value):
    for name in SIZES:
        part = BEAM if hasattr(BEAM, name) else DEVICE
        if (name, value) == ("mass", 0.0):  # a beam alone
            continue
        with pytest.raises(ValueError, match=rf"^{name}: {value} is not .*$"):
            replace(part, **{name: value})
    if value != math.inf:
        with pytest.raises(ValueError, match=rf"^contact: {value} is not .*$"):
            replace(DEVICE, contact=value)


CASES = cases_of(__file__)


@pytest.mark.parametrize("line", CASES["unfit"])
def test_values_that_do_not_fit_each_other_are_refused_in_a_line(line):
    with pytest.raises(ValueError, match=f"^{line}$"):
        varied(DEVICE, **CASES["unfit"][line])
    varied(DEVICE, imperfection=60.0, free=1.0), varied(DEVICE, rise=1.0, thickness=1e-6)


def test_a_device_has_the_stiffness_frequencies_and_mass_of_handbooks():
    """The clamps lie in series with the beam: together they hold as much as it does alone."""
    beam, EI, EA = DEVICE.beam, 150e3 * 22 * 8 / 12, 150e3 * 44
    soft = replace(beam, clamp_axial=2 * EA / 600, residual_stress=-5.0)
    assert (beam.bending_stiffness, beam.stiffness_unit) == pytest.approx((EI, EI / 600**3))
    assert (beam.held, soft.held) == (1.0, 0.5) and beam.weight == pytest.approx(2.33e-3 * 44 * 600)
    assert (beam.axial_stiffness, soft.axial_stiffness) == pytest.approx((EA / 1200, EA / 2400))
    assert beam.buckling_stress == pytest.approx(4 * np.pi**2 * EI / 44 / 600**2)
    assert soft.compression == pytest.approx(5.0 / beam.buckling_stress / 2)
    assert soft.bistability == pytest.approx(5.0 / math.sqrt(2))
    flat = replace(soft, rise=0.0, residual_stress=-50.0)
    c = 25.0 / beam.buckling_stress  # held, and w^2 (pi/2 L)^2 E = (c - 1) buckling stress
    height = 2.0 * math.sqrt(4 / 3 * (c - 1) / 0.5)
    assert (flat.height, flat.made_rise) == pytest.approx((height, 1e-8 * height), rel=1e-7)
    bending = 22.373285448 / 600**2 * math.sqrt(EI / (2.33e-3 * 44))
    assert beam.bending_frequency == pytest.approx(bending)
    heavy = DEVICE.own_frequency, replace(DEVICE, mass=1e-3).own_frequency
    assert heavy == pytest.approx((math.sqrt(5.5 / 1e4), bending))
    with pytest.raises(ValueError, match=r"a stress below -19\.\d+ MPa or, .* above 3\.347$"):
        replace(beam, rise=4.0, clamp_axial=2e4).require_second_shape()


def test_a_batch_is_its_devices_and_tells_of_each():
    several = [DEVICE, varied(DEVICE, **ALONE), replace(DEVICE, stop_away=3.0, contact_at=-4.0)]
    made = batch(several)
    assert len(made) == 3 and [made.pick(i) for i in range(3)] == several
    told = np.array([made.is_alone, made.has_stops, made.has_electrode], int)
    assert told.tolist() == [[0, 1, 0], [0, 0, 1], [0, 0, 1]]
    assert made.pick(np.array([False, True, True])).stop_away.tolist() == [math.inf, 3.0]
    with pytest.raises(ValueError, match=r"^mass: a beam alone is no value of an axis$"):
        made.vary({"mass": np.zeros(3)})
    with pytest.raises(ValueError, match=r"^span: -1\.0 is not a number above 0 in um$"):
        made.vary({"span": np.array([1.0, -1.0, 600.0])})


PUSHED = {**ALONE, "force": 2.0, "gravity": 1.0}


@pytest.mark.parametrize("of_beam", CASES["beams"])
@pytest.mark.parametrize("of_device", [*CASES["devices"], PUSHED])
def test_the_recipe_of_a_device_is_read_back(of_device, of_beam):
    device = replace(DEVICE, **of_device, beam=replace(BEAM, **of_beam))
    assert read_device(device_sections(device)["device"]) == device


def test_every_value_of_a_device_is_an_axis_or_fixed():
    values = {*Beam.__dataclass_fields__, *Device.__dataclass_fields__} - {"beam", "free"}
    assert values == {*VALUES, *FIXED} and not FIXED.intersection(VALUES)


def test_usual_values_lie_between_those_that_users_know():
    read = {key: tuple(map(KINDS[key].read, ends)) for key, ends in CASES["usual"].items()}
    assert read == USUAL


THERMAL = {"modulus_slope": -63e-6, "expansion_mismatch": -0.5e-6, "damper_exponent": 0.7}


@pytest.fixture(scope="module")
def silicon(handout):
    return replace(handout, **THERMAL)


def test_modulus_stress_and_damping_follow_the_temperature_whatever_the_way(silicon):
    hot = silicon.at(120.0)
    assert hot.beam.youngs_modulus == pytest.approx(150e3 * (1 - 63e-4), rel=1e-15)
    assert hot.beam.residual_stress == pytest.approx(150e3 * 0.5e-4, rel=1e-15)
    (C,) = to_cells(batch([hot]), [0], [1000.0], [1500.0], [25.0], 0.0).damping
    assert pytest.approx(25 * (393.15 / 293.15) ** 0.7, rel=1e-15) == C
    once, twice = silicon.at(-40.0), silicon.at(300.0).at(-40.0)
    assert twice.beam.youngs_modulus == pytest.approx(once.beam.youngs_modulus, rel=1e-14)
    assert twice.beam.residual_stress == pytest.approx(once.beam.residual_stress, rel=1e-12)
    assert silicon.at(20.0).beam == silicon.beam


def test_the_axis_is_the_device_with_other_values(silicon):
    how = {"model": "cosines", "horizon": 0}
    asked, C = {"f0": [1500.0]}, 25 * (393.15 / 293.15) ** 0.7
    axes = {"temperature": [-40.0, 20.0, 120.0]}
    along = snapmap.threshold(Study(silicon, **how), C=[25.0], **asked, axes=axes)
    hot = replace(silicon.at(120.0), damper_exponent=0.0)
    alone = snapmap.threshold(Study(hot, **how), C=[C], **asked)
    assert along.N_first.values[2].item() == pytest.approx(alone.N_first.item(), rel=1e-9)
    assert along.temperature.attrs["units"] == "degC"


@pytest.mark.parametrize("beam", [{"cosine_2": 0.2, "residual_stress": -20.0}, {"rise": 4.0}])
def test_a_second_shape_is_needed_at_the_temperature_alone(handout, beam):
    cold = varied(handout, **beam, expansion_mismatch=9e-6)
    grid = make_grid(cold, {"temperature": [20.0, 120.0]}, skip=True)
    assert grid.device_of.tolist() == [-1, 0]
    hot_stress = cold.beam.residual_stress - 150e3 * 9e-4
    assert grid.device.beam.residual_stress == pytest.approx([hot_stress])
    assert len(make_grid(cold, {"temperature": [120.0]}).device) == 1
    with pytest.raises(ValueError, match=r"temperature = 20 degC: device.beam: .* second stable"):
        make_grid(cold, {"temperature": [20.0, 120.0]})
