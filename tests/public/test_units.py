"""Numbers with units count in their own, those of another dimension are refused; SI is doubted."""

import warnings

import numpy as np
import pint
import pytest
import xarray as xr

import snapmap

U = pint.UnitRegistry()
SIZES = {"span": 600.0, "rise": 10.0, "thickness": 2.0, "depth": 22.0}
STUFF = {"youngs_modulus": 150e3, "density": 2.33e-3}
MOVES = {"mass": 1e4, "spring": 5.5, "contact": 40.0, "gravity": 9.81e-6}
UNITS = {"youngs_modulus": "MPa", "density": "ng/um^3", "mass": "ng", "gravity": "um/us^2"}
UNITS |= dict.fromkeys(SIZES, "um") | dict.fromkeys(("spring", "contact"), "uN/um")


class Quantity(np.ndarray):
    """An array with a unit, as astropy has it."""

    unit = "kHz"


def astropy_like(value):
    return np.array(value).view(Quantity)


def data_array(value, units):
    return xr.DataArray(value, attrs={"units": units})


@pytest.fixture(scope="module")
def study(handout):
    return snapmap.Study(handout, model=snapmap.Cosines(modes=3), horizon=0.0)


KILOHERTZ = (
    *(1 * U.kHz, 1000 * U.Hz, [1 * U.kHz], astropy_like(1.0), "1 kHz", data_array([1.0], "kHz")),
    *([1, 2] * U.kHz, astropy_like([1.0, 2.0]), xr.DataArray([1.0, 2.0] * U.kHz)),
)


@pytest.mark.parametrize("value", KILOHERTZ, ids=str)
def test_a_frequency_counts_in_its_unit(study, value):
    with warnings.catch_warnings(action="error"):
        cube = snapmap.sweep(study, [900.0], value, [25.0])
        plain = [1000.0, 2000.0][: cube.f0.size]
        assert cube.identical(snapmap.sweep(study, [900.0], plain, [25.0]))


def test_a_value_of_a_study_in_a_unit_of_another_dimension_is_a_line(handout):
    drop = {"drop": {"height": 1 * U.s, "duration": 500}}
    wrong = (("pulse", drop, "pulse.drop.height"), ("horizon", 1 * U.m, "horizon"))
    for key, value, path in wrong:
        with pytest.raises(ValueError, match=rf"\A{path}: .* does not convert to u[ms].*\Z"):
            snapmap.Study(handout, **{key: value})
    with pytest.raises(ValueError, match=r"\Atime: .* does not convert to us.*\Z"):
        snapmap.sampled([0, 1, 2] * U.m, [0.0, 1.0, 0.0])


def device_of(values):
    beam = snapmap.Beam(**{key: values[key] for key in {**SIZES, **STUFF}})
    return snapmap.Device(beam, **{key: values[key] for key in MOVES})


@pytest.mark.parametrize("name", UNITS)
def test_a_device_takes_a_value_in_its_unit_alone(name):
    values = SIZES | STUFF | MOVES
    plain, unit = device_of(values), UNITS[name].replace("^", "**")
    for value in (U.Quantity(values[name], unit), data_array(values[name], unit)):
        assert device_of(values | {name: value}) == plain
        assert device_of(values | {name: [value]}) == device_of(values | {name: [values[name]]})
    for wrong in (values[name] * U.candela, astropy_like(values[name]), data_array(1.0, "K")):
        with pytest.raises(ValueError, match=rf"\A{name}: .* does not convert to .*; write .*\Z"):
            device_of(values | {name: wrong})


def test_coordinates_of_its_own_cubes_are_taken(study):
    axes = {"thickness": [2.0]}
    cube = snapmap.sweep(study, [900.0, 1000.0], [1500.0], [25.0], axes=axes)
    assert (cube.f0.units, cube.C.units, cube.thickness.units) == ("Hz", "uN us um-1", "um")
    axes = {"thickness": cube.thickness}
    edges = snapmap.threshold(study, cube.f0, cube.C, axes=axes)
    assert edges.N_first.units == "1"
    again = snapmap.sweep(study, cube.N, cube.f0, cube.C, axes=axes)
    xr.testing.assert_identical(again.t_snap, cube.t_snap)
    run = snapmap.simulate(study, edges.N_first.item() * 1.1, 1500.0, 25.0)
    assert snapmap.sampled(run.time, -run.acceleration + run.acceleration[0]).duration > 600
    plain = data_array(np.array([1500.0]), "Hz")
    del plain.attrs["units"]
    assert snapmap.threshold(study, plain, 25.0).N_first.notnull().all()
