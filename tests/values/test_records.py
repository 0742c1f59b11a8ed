"""Records: what they take, what they lack, and how they are written."""

import copy
import itertools
import json
import pickle
from dataclasses import fields, replace

import pytest

import snapmap

SIZES = {"span": "600 um", "rise": 10.0, "thickness": 2.0, "depth": 22.0}
BEAM = SIZES | {"youngs_modulus": "150 GPa", "density": "2330 kg/m^3"}
MOVES = {"mass": "1e-8 kg", "spring": 5.5, "contact": "hard", "gravity": "9.81 m/s^2"}
RECORDS = [
    *(snapmap.Beam(**BEAM), snapmap.Device(beam=BEAM, **MOVES)),
    snapmap.Device(beam=BEAM, mass="none", gravity=9.81e-6),
    *(snapmap.Elements(elements=2), snapmap.Cosines(modes=3), snapmap.Auto()),
]


@pytest.mark.parametrize("whole", RECORDS, ids=lambda whole: type(whole).__name__)
def test_a_record_is_made_again_of_its_text_and_of_its_values(whole):
    names = {name: getattr(snapmap, name) for name in snapmap.__all__} | {"inf": float("inf")}
    assert eval(repr(whole), names) == whole == replace(whole)
    assert whole.__class__(*(getattr(whole, field.name) for field in fields(whole))) == whole


def test_a_fault_of_a_mapping_within_has_its_path():
    for key, wrong in itertools.product(BEAM, (-1.0, "1 kg^9", None, [], {})):
        with pytest.raises(ValueError) as caught:
            snapmap.Device(beam=BEAM | {key: wrong}, **MOVES)
        line = str(caught.value)
        assert line.startswith(f"beam.{key}: ") and "\n" not in line


def test_all_faults_of_a_record_are_told_at_once():
    lines = rf"\Abeam\.span: .*\nbeam\.depth: .*\nspring: .*\n{'contact: .*'}\Z"
    with pytest.raises(ValueError, match=lines):
        wrong = MOVES | {"spring": -1, "contact": []}
        snapmap.Device(beam=BEAM | {"span": -1.0, "depth": "1 kg"}, **wrong)
    with pytest.raises(TypeError, match=r"\Alength: is not an argument.*\nspan: missing; .*\Z"):
        snapmap.Beam(length=1.0, **{key: BEAM[key] for key in BEAM if key != "span"})


def test_a_study_is_equal_by_value_and_a_copy_of_it_too(handout):
    drop = {"drop": {"height": "0.5 m", "duration": "0.5 ms", "rebound": 0.3}}
    for pulse in ("half sine", ["half sine", "sawtooth"], drop, sampled()):
        study, again = (snapmap.Study({"a": handout}, pulse=pulse, horizon=0) for _ in range(2))
        for other in (again, pickle.loads(pickle.dumps(study)), copy.deepcopy(study)):
            assert other == study and repr(other) == repr(study)
            assert other.document() == study.document()
        assert replace(study, pulse="sawtooth") != study != replace(study, horizon=1)
    assert sampled() == sampled() != sampled(peak=2.0) and hash(sampled()) == hash(sampled())


def sampled(peak=1.0):
    return snapmap.sampled([0.0, 100.0, 300.0, 400.0], [0.0, peak, 0.5, 0.0])


def test_a_device_is_loaded_from_a_mapping_as_from_a_file(root, handout, tmp_path):
    section = {
        "beam": BEAM | {"rise": "10 um", "thickness": "2 um", "depth": "22 um"},
        **{"mass": "1e-8 kg", "spring": "5.5 N/m", "contact": "40 N/m", "gravity": "9.81 m/s^2"},
    }
    device = snapmap.load_device(section)
    path = tmp_path / "config.yaml"
    path.write_text(json.dumps({"device": section}), encoding="utf-8")
    assert snapmap.load_device(path) == snapmap.load_device(str(path)) == device
    assert replace(device, mass=2.0) != device
    with pytest.raises(ValueError, match=r"\Adevice\.beam\.rise: .*\ndevice\.spring: .*\Z"):
        wrong = {**section, "spring": 5.5, "beam": section["beam"] | {"rise": "1 kg"}}
        snapmap.load_device(wrong)
