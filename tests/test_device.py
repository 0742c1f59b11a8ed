"""The device's closed forms and limits."""

import math
from dataclasses import replace

import pytest

import snapmap
from snapmap.device import STRENGTH, THERMAL, VALUES, Beam, Device

BEAM = Beam(span=600.0, rise=10.0, thickness=2.0, depth=22.0, youngs_modulus=1.5e5, density=0.00233)
DEVICE = Device(beam=BEAM, mass=1e4, spring=5.5, contact=40.0, gravity=9.81e-6)


def test_section():
    assert BEAM.area == 44.0
    assert BEAM.inertia == pytest.approx(44 / 3, rel=1e-15)
    assert BEAM.mass_per_length == pytest.approx(0.10252, rel=1e-15)
    assert BEAM.bending_stiffness == pytest.approx(2.2e6, rel=1e-15)
    assert BEAM.axial_stiffness == pytest.approx(5500.0, rel=1e-15)


def test_second_equilibrium():
    assert BEAM.bistability == 5.0
    assert BEAM.second_equilibrium == pytest.approx(-9.43471, abs=1e-5)


def test_second_equilibrium_is_half_the_rise_at_the_limit():
    beam = replace(BEAM, rise=8 / math.sqrt(3) * (1 + 1e-12))
    assert beam.second_equilibrium == pytest.approx(-beam.rise / 2, rel=1e-5)


def test_beam_needs_a_second_equilibrium():
    with pytest.raises(
        ValueError, match=r"^device\.beam: rise/thickness = 4 um/2 um = 2 and .* more than 2\.309$"
    ):
        replace(BEAM, rise=4.0).require_second_shape()


def refused_by(verb):
    with pytest.raises(ValueError, match=r"^device\.beam: rise/thickness = 4 um/2 um = 2 and "):
        verb(replace(DEVICE, beam=replace(BEAM, rise=4.0)))


def test_a_cosine_without_a_second_shape_is_refused_where_it_is_shaken_alone():
    refused_by(lambda device: snapmap.threshold(device, [1500.0], [25.0]))
    refused_by(lambda device: snapmap.sweep(device, [900.0], [1500.0], [25.0]))
    refused_by(lambda device: snapmap.simulate(device, 900.0, 1500.0, 25.0))
    found = snapmap.statics(replace(DEVICE, beam=replace(BEAM, rise=4.0)))
    assert found.largest_force > found.least_force > 0  # it snaps, and returns by itself


BEAM_SIZES = ["span", "rise", "thickness", "depth", "youngs_modulus", "density"]


@pytest.mark.parametrize("name", BEAM_SIZES)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_beam_sizes_are_positive_and_finite(name, value):
    if (name, value) == ("rise", 0.0):  # a straight beam, which compression buckles
        return
    with pytest.raises(ValueError, match=rf"^device\.beam\.{name}: {value} is not .*$"):
        replace(BEAM, **{name: value})


@pytest.mark.parametrize("value", [-1e-9, math.nan, math.inf])
def test_beam_damping_is_not_negative(value):
    with pytest.raises(ValueError, match=rf"^device\.beam\.damping: {value} is not .*$"):
        replace(BEAM, damping=value)


@pytest.mark.parametrize("name", ["mass", "spring", "gravity"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_device_values_are_positive_and_finite(name, value):
    with pytest.raises(ValueError, match=rf"^device\.{name}: {value} is not .*$"):
        replace(DEVICE, **{name: value})


@pytest.mark.parametrize("value", [0.0, -40.0, -math.inf, math.nan])
def test_contact_is_positive(value):
    with pytest.raises(ValueError, match=rf"^device\.contact: {value} is not .*$"):
        replace(DEVICE, contact=value)


def test_contact_may_be_hard():
    assert replace(DEVICE, contact=math.inf).contact == math.inf


def test_every_value_has_its_line_in_the_table():
    fields = {*Beam.__dataclass_fields__, *Device.__dataclass_fields__} - {"beam", "free", "shape"}
    assert fields == {*VALUES, "gravity", "force", *STRENGTH.values(), *THERMAL.values()}
