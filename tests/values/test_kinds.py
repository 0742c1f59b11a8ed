"""Kinds of values: text, plain numbers and objects with units give the same bits, or a line."""

import inspect
import math
import re
from decimal import Decimal

import numpy as np
import pint
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st
from small_studies import cases_of

import snapmap
from snapmap.files.text import describe
from snapmap.values import quantities
from snapmap.values.arguments import Argument, by_name, convert, one_time
from snapmap.values.faults import Faults, at_key, few, line_at, name_of
from snapmap.values.kinds import ByName, Items, Pair, Quantity, Several, Whole, Word, kind_of
from snapmap.values.units import USUAL, by_pint, of_file, require_unit, spelling, spelling_of, used

U = pint.UnitRegistry()
CASES = cases_of(__file__)
KINDS = {name: kind_of(alias) for name, alias in vars(quantities).items()}
KINDS = {name: kind for name, kind in KINDS.items() if isinstance(kind, Quantity)}
OF_UNITS = [name for name in KINDS if KINDS[name].unit]


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


KILOHERTZ = (
    *(1 * U.kHz, 1000 * U.Hz, [1 * U.kHz], np.array(1.0).view(Row), variable([1.0], "kHz")),
    *([1, 2] * U.kHz, np.array([1.0, 2.0]).view(Row), xr.DataArray([1.0, 2.0] * U.kHz)),
)


@pytest.mark.parametrize("value", KILOHERTZ, ids=str)
def test_numbers_and_rows_count_in_their_unit(value):
    taken = kind_of(quantities.Frequencies).take(value)
    assert taken.tolist() == [1000.0, 2000.0][: taken.size]


@pytest.mark.parametrize("name", CASES["exact"])
def test_text_has_the_very_float_of_its_number_in_internal_units(name):
    kind = kind_of(getattr(quantities, name))
    for text, number in CASES["exact"][name].items():
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


NUMBER, POWER = r"[+-]?[0-9]{1,3}(\.[0-9]?)?(e-?[0-9]{1,4})?", r"(\^|\*\*)?-?[0-9]?"
QUANTITIES = rf"{NUMBER} ?(/ ?)?[a-z\u00b5%]{{1,4}}([*/ ]{{1,2}}[A-Za-z]{{1,3}}{POWER}){{0,3}}"
SIGNS = "0123456789.eE+-*/^ umNkgHzrad\N{MICRO SIGN}%()²"


@settings(max_examples=60, derandomize=True, deadline=None, database=None)
@given(st.from_regex(QUANTITIES, fullmatch=True) | st.text(alphabet=SIGNS, max_size=30))
@example("0 Qs^9*Rs^9/us^9/ns^8")
@example("2**9**9")
@example("nan um")
def test_any_text_is_a_finite_quantity_or_a_fault(text):
    for kind in ("Length", "Damper", "Part"):
        try:
            value = KINDS[kind].read(text)
        except ValueError as error:
            assert "\n" not in str(error)
        else:
            assert math.isfinite(value)


UNITS = {kind.unit for kind in KINDS.values()} - {"", "%"}
RATES = {KINDS["Rate"].unit, KINDS["Frequency"].unit}


@pytest.mark.parametrize("target", USUAL)
def test_usual_units_are_those_of_pint(target):
    factors = {unit: by_pint(unit, target) for unit in USUAL[target]}
    assert factors == {unit: Decimal(factor) for unit, factor in USUAL[target].items()}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_no_quantity_is_one_line_with_its_value_and_an_example(kind):
    of, values = KINDS[kind], CASES["not"].get(kind, [])
    if of.unit not in ("", "%"):
        others = (unit for unit in UNITS if unit != of.unit and {unit, of.unit} != RATES)
        sizes = (size for size in ("-3", "0") if not of.bounds.holds(float(size)))
        beyond = (f"{size} {of.unit}" for size in ("nan", "inf", "1e25", "1e-40", *sizes))
        values = [*values, *CASES["never"], *beyond, *(f"25 {unit}" for unit in others)]
    for value in values:
        with pytest.raises(ValueError) as caught:
            of.read(value)
        assert str(caught.value).startswith(describe(value)) and "\n" not in str(caught.value)
        assert f"; write {of.noun}" in str(caught.value)


@pytest.mark.parametrize("name", CASES["wrong"])
def test_text_of_a_config_is_refused_with_what_is_right(name):
    kind = kind_of(getattr(quantities, name))
    such = f"'{kind.example}'" if kind.unit else kind.example
    right = f"{kind.noun} such as {such}{', or the word hard' * (name == 'Contact')}"
    for text, words in CASES["wrong"][name].items():
        with pytest.raises(ValueError, match=rf"^'{text}' {re.escape(words)}; write {right}$"):
            kind.read(text)


LENGTH, TRIED = Quantity("a length", "um", "600 um"), Word(("a", "bc", True))
NUMBERS = Several(Quantity("a number", "", "1", "[0, inf)"))
PARTS = {
    **{"numbers": NUMBERS, "count": Whole(1, 100), "whole": Whole(2), "word": TRIED},
    **{"pair": Pair(LENGTH), "length": ByName(LENGTH), "one": LENGTH, "list": Items(LENGTH)},
}
READ = {line: (PARTS[part], value) for part, value, line in CASES["parts"]}
TAKEN = {line: (PARTS[part], value) for part, value, line in CASES["taken"]} | {
    "a DataArray in cd does not convert to um; write a number": (LENGTH, variable(3, "cd")),
    "a DataArray in m+s has an unknown unit, 'm+s'; write a": (LENGTH, variable(3, "m+s")),
    "a DataArray in um has a unit; write a number": (NUMBERS.of, variable(3, "um")),
    '1 is not "a"': (TRIED, np.int8(1)),
}


@pytest.mark.parametrize(("way", "wrong"), [("read", READ), ("take", TAKEN)])
def test_lists_words_and_pairs_are_refused_in_the_words_of_a_config_or_of_python(way, wrong):
    for line, (kind, value) in wrong.items():
        with pytest.raises(ValueError, match=rf"^{re.escape(line)}"):
            getattr(kind, way)(value)


def test_right_values_of_parts_are_converted_each():
    assert Pair(LENGTH).read(["1 nm", "2 um"]) == Pair(LENGTH).take([0.001, 2.0]) == (0.001, 2.0)
    assert Items(LENGTH).read(["2 um", "1 nm"]) == [2.0, 0.001]
    assert ByName(LENGTH).take({"x": 3.0}) == {"x": 3.0}
    assert [Whole(1, 3).take(number) for number in (1, np.int8(3))] == [1, 3]
    assert [TRIED.take(word) for word in ("a", True, np.bool_(True))] == ["a", True, True]
    powers = NUMBERS.read({"from": 1, "to": 4, "points": 3, "spacing": "log"})
    assert powers == pytest.approx([1, 2, 4])


@pytest.mark.parametrize("unit", CASES["spelt"])
def test_a_unit_is_spelt_for_files_figures_and_the_page_and_read_back(unit):
    assert (*spelling(unit), of_file(spelling(unit).files)) == tuple(CASES["spelt"][unit])


def test_values_are_told_in_the_units_that_users_read():
    for reads, (text, short, typeset) in CASES["used"].items():
        assert [used(text, reads), used(text, reads, True)] == [short, typeset]
    assert spelling_of("2 m/s^2", "um/us^2") == ("m/s^2", 1e-6)
    assert spelling_of(3.0, "um") == ("um", 1.0)
    assert [*map(require_unit, ("1", "uN/um", "uN*us^3/um^3"))] == ["", "uN/um", "uN*us^3/um^3"]
    for wrong in ("9**9", "um*flurb"):
        with pytest.raises(ValueError, match=r"is not a unit; write one|has an unknown unit"):
            require_unit(wrong)


def test_a_fault_has_the_path_of_its_key_and_many_are_few():
    assert name_of(()) == "config" and name_of(("a", 0, "b c", "d")) == "a[0]['b c'].d"
    assert name_of(["x" * 40]) == "x" * 40 and name_of(["x" * 41]).startswith("['xxx")
    lines = CASES["lines"]
    assert {line: line_at(["a"], line) for line in lines} == lines
    assert line_at((), ".b: c") == "b: c"
    assert few(["x"] * 3) == ["x"] * 3 and few(["x", *"abc"]) == ["x (and 3 others of this list)"]
    with pytest.raises(ValueError, match=r"^\.a\[1\]: words$"), at_key("a", 1):
        raise ValueError("words")


def test_names_of_a_call_are_known_missing_or_asked_for():
    sizes = {key: Argument(LENGTH) for key in ("span", "rise")}
    given = {"spam": 1.0, "x": 1.0, "y": 1.0}
    lines = ["rise: is none", "spam: unknown key; did you mean span?"]
    lines += ["x: unknown key; known here are span, rise", "y: unknown key; write z"]
    with pytest.raises(Faults) as caught:
        convert(sizes, given, faults={"rise": "is none"}, elsewhere={"y": "; write z"})
    assert [*caught.value.args] == [*lines, "span: missing; write a number above 0 in um"]
    many = {f"key_{number}": Argument(LENGTH, True, True) for number in range(21)}
    assert convert(many, {"key_0": None, "key_1": 2.0}) == {"key_0": None, "key_1": 2.0}
    with pytest.raises(Faults, match=r"^abc: .* here are( key_\d+,){9} key_\d+ and 11 others$"):
        convert(many, {"abc": 1.0})
    excluded = {"duration": "excludes f0, which is 1/duration; write one of them"}
    assert one_time(["f0", "duration"]) == excluded and one_time([], True) == one_time(["f0"]) == {}
    assert one_time([]) == {"f0": "missing; write f0 or duration"}
    parameters = inspect.signature(lambda a, b, *, c: None).parameters
    values, faults = by_name("f", parameters, (1, 2, 3), {"a": 4, "c": 5})
    wrong = {"f": "takes 2 arguments without a name, not 3", "a": "comes twice; write it once"}
    assert values == {"a": 4, "b": 2, "c": 5} and faults == wrong


@pytest.mark.parametrize("name", OF_UNITS)
def test_a_value_of_another_unit_is_refused_in_a_line(name):
    for wrong in (3 * U.candela, variable(3.0, "cd"), variable(3.0, "m s s"), "3 cd", "3 ", ""):
        of_text = [KINDS[name].read] if isinstance(wrong, str) else []
        for way in (KINDS[name].take, *of_text):
            with pytest.raises(ValueError) as caught:
                way(wrong)
            assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", OF_UNITS)
def test_an_example_is_read_and_taken_alike_and_a_bare_number_is_no_text(name):
    kind = KINDS[name]
    if kind.example:
        assert kind.read(kind.example) == kind.take(kind.example)
    with pytest.raises(ValueError, match="has no unit"):
        kind.read(2.0)
    for word, number in kind.words:
        assert kind.take(word) == kind.read(word) == number
    numbers = kind.schema()
    pattern = (numbers.get("anyOf") or [numbers])[0]["pattern"]
    for number in filter(kind.bounds.holds, (0.25, 150.0)):
        written = kind.write(number)
        assert kind.read(written) == pytest.approx(number) and re.match(pattern, written)
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
    wrong = {"drop": {"height": 1 * U.s, "duration": 500}}
    cases = ("pulse", wrong, "pulse.drop.height"), ("horizon", 1 * U.m, "horizon")
    for key, value, path in cases:
        with pytest.raises(ValueError, match=rf"\A{path}: .* does not convert to u[ms].*\Z"):
            snapmap.Study(handout, **{key: value})
    with pytest.raises(ValueError, match=r"\Atime: .* does not convert to us.*\Z"):
        snapmap.sampled([0, 1, 2] * U.m, [0.0, 1.0, 0.0])
    shots = {"N": [800, 900, 950, 1000, 1050, 1200], "tripped": [0, 0, 0, 1, 1, 1]}
    ranges = {"thickness": ("1.7 um", "2300 nm")}, {"thickness": [1.7, 2.3] * U.um}
    times = ["1 ms"] * 6, [1 * U.ms] * 6
    asked = [(shots | {"duration": time}, some) for time, some in zip(times, ranges, strict=True)]
    fits = [snapmap.calibrate(study, *each, C=25) for each in asked]
    assert fits[0].estimate.item() == fits[1].estimate.item()
