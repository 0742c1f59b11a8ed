"""Kinds of values: text, plain numbers and objects with units give the same bits, or a line."""

import numpy as np
import pint
import pytest
import xarray as xr

import snapmap
from snapmap.values import quantities
from snapmap.values.kinds import Quantity, Several, kind_of

U = pint.UnitRegistry()
KINDS = {
    name: kind
    for name, alias in vars(quantities).items()
    if isinstance(kind := kind_of(alias), Quantity) and kind.unit
}


class Row(np.ndarray):
    """An array with a unit, as astropy has it."""

    unit = "kHz"


def variable(value, units):
    return xr.DataArray(value, attrs={"units": units})


SAME = [
    ("Frequencies", "1.5 kHz", [1.5 * U.kHz, variable(1.5, "kHz"), np.array(1.5).view(Row)]),
    ("Frequencies", "1500 1/s", [variable(1500.0, "s-1"), 1500 / U.s]),
    ("Damper", "25 uN*us/um", [variable(25.0, "uN us um-1"), variable(25e-6, "N s m-1")]),
    ("Density", "2330 kg/m^3", [variable(2330.0, "kg m-3"), 2.33 * U("g/cm^3")]),
    ("Acceleration", "9.81 m/s^2", [variable(9.81, "m s-2"), 9.81 * U("m/s^2")]),
    ("Temperature", "300 K", [U.Quantity(300, "K"), variable(300.0, "kelvin")]),
    ("Temperature", "85 degC", [U.Quantity(85, "degC"), variable(85.0, "degree_Celsius")]),
    ("Temperature", "85 degC", [variable(85.0, "celsius"), variable(85.0, "degrees_C")]),
]


@pytest.mark.parametrize(("name", "text", "others"), SAME)
def test_objects_with_units_give_the_bits_of_text(name, text, others):
    take = kind_of(getattr(quantities, name)).take
    for other in others:
        assert take(other) == take(text)


EXACT = {
    "Length": {"600um": 600.0, "600 µm": 600.0, " 0.6 mm\n": 600.0, ".6e0 mm": 600.0},
    "Stiffness": {"20 mN/m": 0.02, "3 N/m": 3.0, "2 kN/m": 2000.0, "0.5 uN/um": 0.5},
    "Density": {"2.33 g/cm**3": 0.00233, "2330 kg/m³": 0.00233, "2330 kg m^-3": 0.00233},
    "Modulus": {"150000 N/mm^2": 150000.0},
    "Mass": {"1e-8 kg": 1e4, "3 mg": 3e6, "7 µg": 7e3, "0.1 ug": 100.0, "none": 0.0},
    "Temperature": {"300 K": 26.85, "-40 degC": -40.0, "0.15 K": -273.0},
    "Stress": {"-11 MPa": -11.0, "0.15 GPa": 150.0, "-2e3 Pa": -0.002, "3 N/m^2": 3e-6},
    "Frequency": {"1.5 kHz": 1500.0, "30 1/s": 30.0, "2 MHz": 2e6},
    "PulseTime": {"0.5 ms": 500.0, "2 s": 2e6, "1e3 us": 1e3},
    "Acceleration": {"9.81 m/s^2": 9.81e-6, "1 um/us^2": 1.0},
    "Rate": {"4e-4/us": 4e-4, "4e-4 1 / us": 4e-4, "0 /us": 0.0, "50 /s": 5e-5},
    "Expansion": {"-63e-6 /K": -63e-6},
    "Share": {"12.5 %": 0.125, "5%": 0.05},
    "Damper": {"25 uN*us/um": 25.0, "0.001 kg/s": 1000.0, "0.2 mN*s/m": 200.0},
    "Contact": {"hard": np.inf, "40 N/m": 40.0},
}


@pytest.mark.parametrize("name", EXACT)
def test_text_has_the_very_float_of_its_number_in_internal_units(name):
    kind = kind_of(getattr(quantities, name))
    for text, number in EXACT[name].items():
        assert kind.read(text) == kind.take(text) == number


def test_a_list_of_a_config_ascends_and_a_value_counts_once_in_any_unit():
    kind = Several(Quantity("a length", "um"))
    assert kind.read(["2 um", "1 nm", "1 um"]).tolist() == [0.001, 1.0, 2.0]
    assert kind.read({"from": "3 um", "to": "1 um", "points": 3}).tolist() == [1.0, 2.0, 3.0]
    assert kind.take([2.0, 1.0]).tolist() == [2.0, 1.0]
    with pytest.raises(ValueError, match=r"^1 um comes twice; write every value once$"):
        kind.read(["1 um", "2 um", "1000 nm"])
    for twice in ([1.0, 2.0, 1.0], ["1 um", 1.0], np.ma.array([1.0, 2.0], mask=[False, True])):
        with pytest.raises(ValueError, match="is not a number or several, each once, above 0 in"):
            kind.take(twice)


@pytest.mark.parametrize("name", KINDS)
def test_a_value_of_another_unit_is_refused_in_a_line(name):
    for wrong in (3 * U.candela, variable(3.0, "cd"), variable(3.0, "m s s"), "3 cd", "3 ", ""):
        of_text = [KINDS[name].read] if isinstance(wrong, str) else []
        for convert in (KINDS[name].take, *of_text):
            with pytest.raises(ValueError) as caught:
                convert(wrong)
            assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", KINDS)
def test_an_example_is_read_and_taken_alike_and_a_bare_number_is_no_text(name):
    kind = KINDS[name]
    if kind.example:
        assert kind.read(kind.example) == kind.take(kind.example)
    with pytest.raises(ValueError, match="has no unit"):
        kind.read(2.0)
    for word, number in kind.words:
        assert kind.take(word) == kind.read(word) == number
    low, high = kind.bounds.low, kind.bounds.high
    for end, fits in ((low, kind.bounds.low_fits), (high, kind.bounds.high_fits)):
        assert kind.bounds.holds(end) == fits
    assert not kind.bounds.holds(np.nan)


def test_rows_mix_text_and_numbers_and_single_values_are_no_rows():
    row = Several(Quantity("a length", "um")).take(["1 mm", 2.0, 3 * U.nm])
    assert row.tolist() == [1000.0, 2.0, 0.003]
    with pytest.raises(ValueError, match="is not a number"):
        Quantity("a length", "um", is_single=True).take([1.0, 2.0])


def test_text_with_a_unit_is_taken_wherever_a_value_is(handout):
    study = snapmap.Study(handout, model=snapmap.Cosines(modes=3), horizon="0 us")
    plain = snapmap.threshold(study, 1500, 25, axes={"thickness": [2.0]})
    text = snapmap.threshold(study, "1.5 kHz", "25 uN*us/um", axes={"thickness": "2000 nm"})
    assert text.identical(plain)
    drop = {"drop": {"height": "0.5 m", "duration": 0.5 * U.ms}}
    assert snapmap.Study(handout, pulse=drop).pulse.duration > 3e5
    times = snapmap.sampled(["0 ms", "0.1 ms", "0.4 ms"], [0, 1, 0])
    assert times.duration == snapmap.sampled([0, 0.1, 0.4] * U.ms, [0, 1, 0]).duration == 400.0
    shots = {"N": [800, 900, 950, 1000, 1050, 1200], "tripped": [0, 0, 0, 1, 1, 1]}
    ranges = {"thickness": ("1.7 um", "2300 nm")}, {"thickness": [1.7, 2.3] * U.um}
    times = ["1 ms"] * 6, [1 * U.ms] * 6
    fits = [
        snapmap.calibrate(study, shots | {"duration": time}, unknown, C=25)
        for time, unknown in zip(times, ranges, strict=True)
    ]
    assert fits[0].estimate.item() == fits[1].estimate.item()
