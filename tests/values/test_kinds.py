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
