"""Records: what they take, what they lack, and how they are written."""

import itertools
from dataclasses import fields, replace

import pytest

import snapmap

SIZES = {"span": "600 um", "rise": 10.0, "thickness": 2.0, "depth": 22.0}
BEAM = SIZES | {"youngs_modulus": "150 GPa", "density": "2330 kg/m^3"}
MOVES = {"mass": "1e-8 kg", "spring": 5.5, "contact": "hard", "gravity": "9.81 m/s^2"}
RECORDS = [
    *(snapmap.Beam(**BEAM), snapmap.Device(beam=BEAM, **MOVES)),
    snapmap.Device(beam=BEAM, mass="none", gravity=9.81e-6),
    *(snapmap.Run(horizon="0.5 ms", threads=2), snapmap.Cosines(modes=3), snapmap.Auto()),
]


@pytest.mark.parametrize("whole", RECORDS, ids=lambda whole: type(whole).__name__)
def test_a_record_is_made_again_of_its_text_and_of_its_values(whole):
    names = {name: getattr(snapmap, name) for name in snapmap.__all__} | {"inf": float("inf")}
    assert eval(repr(whole), names) == whole == replace(whole)
    assert whole.__class__(*(getattr(whole, field.name) for field in fields(whole))) == whole


def test_what_is_missing_twice_or_misspelt_is_a_line():
    for key in BEAM:
        with pytest.raises(TypeError, match=rf"\A{key}: missing; write .*\Z"):
            snapmap.Beam(**{other: BEAM[other] for other in BEAM if other != key})
        with pytest.raises(TypeError, match=rf"\A{key[:-1]}: is not a value; did you mean {key}\?"):
            snapmap.Beam(**BEAM, **{key[:-1]: 1.0})
    with pytest.raises(TypeError, match=r"\Aspan: comes twice; write it once\Z"):
        snapmap.Beam(600.0, **BEAM)


def test_a_fault_of_a_mapping_within_has_its_path():
    for key, wrong in itertools.product(BEAM, (-1.0, "1 kg^9", None, [], {})):
        with pytest.raises(ValueError) as caught:
            snapmap.Device(beam=BEAM | {key: wrong}, **MOVES)
        line = str(caught.value)
        assert line.startswith(f"beam.{key}: ") and "\n" not in line
