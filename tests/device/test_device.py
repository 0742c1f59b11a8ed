"""The device's closed forms and limits, and its recipe, which is read back."""

import math
from dataclasses import replace

import pytest

import snapmap
from snapmap.config.devices import read_device
from snapmap.device.device import ALONE, VALUES, Beam, Device
from snapmap.device.quantities import QUANTITIES, keys_of
from snapmap.study.provenance import device_sections

BEAM = Beam(span=600.0, rise=10.0, thickness=2.0, depth=22.0, youngs_modulus=1.5e5, density=0.00233)
DEVICE = Device(beam=BEAM, mass=1e4, spring=5.5, contact=40.0, gravity=9.81e-6)


@pytest.mark.parametrize(
    "ask",
    [
        lambda device: snapmap.threshold(device, [1500.0], [25.0]),
        lambda device: snapmap.sweep(device, [900.0], [1500.0], [25.0]),
        lambda device: snapmap.simulate(device, 900.0, 1500.0, 25.0),
    ],
)
def test_a_beam_without_a_second_shape_has_statics_alone(ask):
    device = replace(DEVICE, beam=replace(BEAM, rise=4.0))
    with pytest.raises(
        ValueError, match=r"^device\.beam: no .* rise/thickness = 4 um/2 um = 2 and "
    ):
        ask(device)
    found = snapmap.statics(device)
    assert found.largest_force > found.least_force > 0  # it snaps, and returns by itself


SIZES = ["span", "thickness", "depth", "youngs_modulus", "density", "mass", "spring", "gravity"]


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_sizes_are_positive_and_finite(value):
    for name in SIZES:
        part, key = (BEAM, "device.beam") if hasattr(BEAM, name) else (DEVICE, "device")
        with pytest.raises(ValueError, match=rf"^{key}\.{name}: {value} is not .*$"):
            replace(part, **{name: value})
    if value != math.inf:
        with pytest.raises(ValueError, match=rf"^device\.contact: {value} is not .*$"):
            replace(DEVICE, contact=value)


MADE = [
    {"residual_stress": -11.0, "free": 1.0, "imperfection": 0.01, "damping": 4e-4},
    {"cosine_2": 0.08, "cosine_3": 0.2, "clamp_axial": 2e4},
    {"cosine_2": 0.2, "residual_stress": -80.0},
]
AROUND = [
    {"stop_toward": 14.0, "restitution": 0.7, "gap": 0.5, "contact": math.inf},
    {"strength": 3000.0, "strength_modulus": 10.0, "strength_threshold": 1446.0},
    {"modulus_slope": -63e-6, "damper_exponent": 0.7, "expansion_mismatch": 2e-6},
    {**ALONE, "force": 2.0, "gravity": 1.0},
]


@pytest.mark.parametrize("of_beam", MADE)
@pytest.mark.parametrize("of_device", AROUND)
def test_the_recipe_of_a_device_is_read_back(of_device, of_beam):
    device = replace(DEVICE, **of_device, beam=replace(BEAM, **of_beam))
    assert read_device(device_sections(device)["device"]) == device


def test_every_value_has_its_line_in_the_table():
    fields = {*Beam.__dataclass_fields__, *Device.__dataclass_fields__} - {"beam", "free", "shape"}
    assert fields == {
        *VALUES,
        "gravity",
        "force",
        "contact_at",
        *keys_of("strength").values(),
        *keys_of("thermal").values(),
    }


def test_a_value_that_a_config_leaves_out_is_the_default_of_its_field():
    fields = Beam.__dataclass_fields__ | Device.__dataclass_fields__
    lines = {name: line for name, line in QUANTITIES.items() if line.default[1:2].isdigit()}
    assert len(lines) > 10
    for name, line in lines.items():
        assert float(line.default.strip("`").split()[0]) == fields[name].default, name
