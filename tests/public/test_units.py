"""Numbers with units are refused where they are another unit's, and SI numbers are doubted."""

import math
import re
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
CHEAP = {"model": "cosines", "modes": 3, "horizon": 0.0}


class Quantity(np.ndarray):
    """An array with a unit, as astropy has it."""

    unit = "kHz"


def astropy_like(value):
    return np.array(value).view(Quantity)


def data_array(value, units):
    return xr.DataArray(value, attrs={"units": units})


WITH_UNITS = (
    *(1 * U.kHz, 1000 * U.Hz, [1, 2] * U.kHz, [1 * U.kHz], astropy_like(1.0)),
    *(astropy_like([1.0, 2.0]), data_array([1.0], "kHz"), data_array(1.0, "ms")),
    xr.DataArray([1.0, 2.0] * U.kHz),
)


@pytest.mark.parametrize("value", WITH_UNITS, ids=str)
def test_a_frequency_with_a_unit_is_refused_in_one_line_with_its_name(handout, value):
    with warnings.catch_warnings(action="error"):
        for call in (
            lambda: snapmap.threshold(handout, value, 25.0, **CHEAP),
            lambda: snapmap.sweep(handout, [900.0], value, C=[25.0], **CHEAP),
        ):
            with pytest.raises(ValueError, match=r"^f0: .* is not a number .* in Hz") as caught:
                call()
            assert "\n" not in str(caught.value)


def test_other_arguments_with_units_are_refused_too(handout):
    calls = {
        "C": lambda: snapmap.threshold(handout, 1500.0, 25 * U("uN*us/um"), **CHEAP),
        "N": lambda: snapmap.simulate(handout, data_array(900.0, "m/s^2"), 1500.0, 25.0, **CHEAP),
        "thickness": lambda: snapmap.threshold(
            handout, 1e3, 25.0, thickness=[2, 3] * U.um, **CHEAP
        ),
        "horizon": lambda: snapmap.threshold(handout, 1e3, 25.0, "cosines", horizon=1 * U.ms),
        "time": lambda: snapmap.sampled([0, 1, 2] * U.ms, [0.0, 1.0, 0.0]),
        "srs": lambda: snapmap.srs_test(handout, [[1 * U.kHz, 9.0], [2 * U.kHz, 9.0]], 25.0),
        "psd": lambda: snapmap.vibration(handout, [[20 * U.Hz, 1], [30 * U.Hz, 1]], 1.0, [25]),
        "duration": lambda: snapmap.vibration(handout, [[20, 1], [30, 1]], 1 * U.min, [25]),
        "scatters|tolerances.span": lambda: snapmap.tolerance(
            handout, {"span": 1 * U.um}, 1500.0, 25.0
        ),
        "pulse.drop.height": lambda: snapmap.threshold(
            handout, None, 25.0, pulse={"drop": {"height": 1 * U.m, "duration": 500}}, **CHEAP
        ),
        "shots": lambda: snapmap.calibrate(
            handout,
            {"N": [1, 2, 3], "tripped": [0, 1, 1], "f0": data_array([1.0, 1.0, 1.0], "kHz")},
            {"thickness": (1.8, 2.2)},
            C=25.0,
        ),
    }
    for name, call in calls.items():
        with pytest.raises(ValueError, match=f"^({name}): ") as caught:
            call()
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", [*SIZES, *STUFF])
def test_a_beam_of_quantities_is_refused(name):
    values = SIZES | STUFF
    for value in (values[name] * U.um, astropy_like(values[name]), data_array(values[name], "m")):
        with pytest.raises(
            ValueError, match=rf"^device\.beam\.{name}: .* is not a number"
        ) as error:
            snapmap.Beam(**values | {name: value})
        assert "\n" not in str(error.value)


@pytest.mark.parametrize("name", MOVES)
def test_a_device_of_quantities_is_refused(name):
    with pytest.raises(ValueError, match=rf"^device\.{name}: a Quantity in .* is not a number"):
        snapmap.Device(snapmap.Beam(**SIZES, **STUFF), **MOVES | {name: MOVES[name] * U.kg})


def test_coordinates_of_its_own_cubes_are_taken(handout):
    cube = snapmap.sweep(handout, [900.0, 1000.0], [1500.0], [25.0], thickness=[2.0], **CHEAP)
    assert (cube.f0.units, cube.C.units, cube.thickness.units) == ("Hz", "uN us um-1", "um")
    edges = snapmap.threshold(handout, cube.f0, cube.C, thickness=cube.thickness, **CHEAP)
    assert edges.N_first.units == "1"
    again = snapmap.sweep(handout, cube.N, cube.f0, cube.C, thickness=cube.thickness, **CHEAP)
    xr.testing.assert_identical(again.t_snap, cube.t_snap)
    run = snapmap.simulate(handout, edges.N_first.item() * 1.1, 1500.0, 25.0, **CHEAP)
    assert snapmap.sampled(run.time, -run.acceleration + run.acceleration[0]).duration > 600
    plain = data_array(np.array([1500.0]), "Hz")
    del plain.attrs["units"]
    assert snapmap.threshold(handout, plain, 25.0, **CHEAP).N_first.notnull().all()


def test_SI_numbers_are_doubted_when_they_are_made():
    sizes = {name: value * 1e-6 for name, value in SIZES.items()}
    with pytest.warns(UserWarning) as told:
        beam = snapmap.Beam(**sizes, youngs_modulus=150e9, density=2330.0)
    assert [line.filename for line in told] == [__file__]
    words = str(told[0].message)
    named = r"density = 2330 ng/um\^3, .*, span = 0.0006 um, .*, youngs_modulus = 1.5e\+11 MPa"
    assert re.match(rf"device\.beam: {named}: is this SI\? numbers are in um, ng, us", words)
    with pytest.warns(UserWarning, match=r"^device\.gravity = 9.81 um/us\^2: is this SI\?"):
        snapmap.Device(beam, **MOVES | {"gravity": 9.81})
    with warnings.catch_warnings(action="error"):
        for span in (20.0, 600.0, 20_000.0):
            shape = SIZES | {"span": span, "thickness": 0.05}
            snapmap.Device(snapmap.Beam(**shape, **STUFF), **MOVES | {"gravity": 1e-6})
        pushed = {"mass": 0.0, "gap": math.inf, "gravity": 1.0, "force": 2.0}
        snapmap.Device(snapmap.Beam(**SIZES, **STUFF), **MOVES | pushed)
