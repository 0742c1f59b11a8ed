"""The door: what comes in is exact, what stays out is named in one line per fault."""

import copy
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st

from snapmap.config.devices import load_device, read_device
from snapmap.config.doubts import descriptions, doubts
from snapmap.config.products import products
from snapmap.config.study import load_config
from snapmap.config.units import read
from snapmap.config.yaml_file import ConfigError, read_document
from snapmap.device import Beam, Device
from snapmap.io.provenance import device_sections
from snapmap.quantities import KINDS
from snapmap.solver.settings import Settings

ROOT = Path(__file__).parents[2]
DEFAULT = read_document(ROOT / "config/handout.yaml")
MISSING = object()


def changed(**values):
    """The default document with values set, or MISSING, at paths such as device__beam__span."""
    document = copy.deepcopy(DEFAULT)
    for path, value in values.items():
        *parents, last = path.split("__")
        section = document
        for key in parents:
            section = section[key]
        section[last] = value
        if value is MISSING:
            del section[last]
    return document


def faults(document):
    with pytest.raises(ConfigError) as caught:
        load_config(document)
    lines = str(caught.value).splitlines()
    assert lines == list(caught.value.args)
    assert all(len(line) < 300 for line in lines)
    return lines


def only_fault(document):
    (line,) = faults(document)
    return line


def test_default_study_is_exact():
    study = load_config(DEFAULT)
    assert study.device == Device(
        beam=Beam(
            span=600.0,
            rise=10.0,
            thickness=2.0,
            depth=22.0,
            youngs_modulus=150000.0,
            density=0.00233,
        ),
        mass=10000.0,
        spring=5.5,
        contact=40.0,
        gravity=9.81e-6,
    )
    assert study.model == DEFAULT["model"]
    assert np.array_equal(study.axes["N"], np.arange(600.0, 2401.0, 20.0))
    assert np.array_equal(study.axes["C"], [0.025, 25.0, 200.0])
    assert (study.axes["f0"].size, study.axes["f0"][0], study.axes["f0"][-1]) == (
        41,
        100.0,
        30000.0,
    )
    assert np.allclose(study.axes["f0"][1:] / study.axes["f0"][:-1], 300 ** (1 / 40), rtol=1e-13)
    assert study.settings._replace(threads=1) == Settings(1500.0, "settled", True, 1e-3)
    (cell,) = study.histories
    assert cell.shock == {"N": 1000.0, "f0": 1500.0, "C": 0.025} and cell.changes == {}
    assert cell.name == "N1000_f1500_C0.025" and study.traces
    assert study.own_points == ()


@pytest.mark.parametrize(
    ("text", "kind", "value"),
    [
        ("600um", "length", 600.0),
        ("600 \N{MICRO SIGN}m", "length", 600.0),
        ("600 \N{GREEK SMALL LETTER MU}m", "length", 600.0),
        (" 0.6 mm\n", "length", 600.0),
        (".6e0 mm", "length", 600.0),
        ("2.33 g/cm**3", "density", 0.00233),
        ("2330 kg/m³", "density", 0.00233),
        ("2330 kg m^-3", "density", 0.00233),
        ("150000 N/mm^2", "modulus", 150000.0),
        ("4e-4 /us", "rate", 4e-4),
        ("4e-4/us", "rate", 4e-4),
        ("4e-4 1/us", "rate", 4e-4),
        ("4e-4 1 / us", "rate", 4e-4),
        ("0 /us", "rate", 0.0),
        ("0.1 ug", "mass", 100.0),
        ("5.5e-3 N/mm", "stiffness", 5.5),
        ("hard", "contact", math.inf),
        ("1.5 kHz", "frequency", 1500.0),
        ("0.2 mN*s/m", "damper", 200.0),
        ("0.025 mg/s", "damper", 0.025),
        ("1.5 ms", "duration", 1500.0),
        ("1e3", "number", 1000.0),
        (1000, "number", 1000.0),
    ],
)
def test_conversion_adds_no_noise(text, kind, value):
    assert read(text, kind) == value


@pytest.mark.parametrize("kind", [kind for kind, of in KINDS.items() if of.unit not in ("", "%")])
@pytest.mark.parametrize(
    ("value", "complaint"),
    [
        (600, "600 has no unit"),
        ("600", "'600' has no unit"),
        (None, "an empty value is not a number with a unit"),
        (True, "true is not a number with a unit"),
        ({"a": 1}, "a mapping is not a number with a unit"),
        ("long", "'long' is not a number with a unit"),
        ("inf um", "'inf um' is not a number with a unit"),
        ("1,5 um", "'1,5 um' is not a number with a unit"),
        ("(1+1) um", "'(1+1) um' is not a number with a unit"),
        ("2**9**9**9 um", "'2**9**9**9 um' is not a number with a unit"),
        ("1e1000 um", "'1e1000 um' is not a number with a unit"),
        ("600 foo", "'600 foo' has an unknown unit, 'foo'"),
        ("600 um*dB", "'600 um*dB' has an unknown unit, 'um*dB'"),
        ("20 degF", "'20 degF' does not convert to "),
        ("3 %", "'3 %' does not convert to "),
    ],
)
def test_not_a_quantity(kind, value, complaint):
    with pytest.raises(ValueError) as caught:
        read(value, kind)
    assert complaint in str(caught.value)
    assert str(caught.value).endswith(f"; write {KINDS[kind].name} such as {KINDS[kind].example}")


@pytest.mark.parametrize(
    ("text", "kind", "complaint"),
    [
        ("600 kg", "length", "'600 kg' does not convert to um"),
        ("1e999 um", "length", "'1e999 um' is not finite"),
        ("0 um", "length", "'0 um' is not above 0"),
        ("-1 us", "duration", "'-1 us' is not from 0"),
        ("Hard", "contact", "'Hard' is not a number with a unit"),
        ("hard", "stiffness", "'hard' is not a number with a unit"),
        ("10 krad/s", "frequency", "counts angles or events, which is not Hz"),
        ("10 rpm", "frequency", "counts angles or events, which is not Hz"),
        ("10 rad/us", "rate", "counts angles or events, which is not 1/us"),
        ("600 g", "number", "'600 g' is not a plain number; write a multiple of gravity"),
        (math.inf, "number", "inf is not finite"),
    ],
)
def test_not_this_quantity(text, kind, complaint):
    with pytest.raises(ValueError) as caught:
        read(text, kind)
    assert complaint in str(caught.value)


@pytest.mark.parametrize(
    ("axis", "values"),
    [
        ([3, 0.2, "1e3", 0], [0.0, 0.2, 3.0, 1000.0]),
        ((2, 1), [1.0, 2.0]),
        ({"from": 7, "to": 7, "points": 1}, [7.0]),
        ({"from": 3, "to": 1, "points": 3}, [1.0, 2.0, 3.0]),
        ({"from": "1e1", "to": 1000, "points": 3, "spacing": "log"}, [10.0, 100.0, 1000.0]),
        ({"from": 0.1, "to": 0.7, "points": 2, "spacing": "linear"}, [0.1, 0.7]),
    ],
)
def test_axes_ascend(axis, values):
    assert np.array_equal(load_config(changed(sweep__N=axis)).axes["N"], values)


def test_a_finer_range_keeps_the_values_of_a_coarser():
    for ends in ({"from": 600, "to": 2400}, {"from": 0.1, "to": 33, "spacing": "log"}):
        coarse, fine = (
            load_config(changed(sweep__N={**ends, "points": points})).axes["N"]
            for points in (91, 181)
        )
        assert set(coarse) < set(fine)


def test_histories():
    cell = {"N": "1e3", "f0": "2 kHz", "C": "0 kg/s"}
    assert load_config(changed(histories=[cell])).histories[0].shock == {
        "N": 1000.0,
        "f0": 2000.0,
        "C": 0.0,
    }
    assert load_config(changed(histories=[])).histories == ()


def with_durations(given):
    document = copy.deepcopy(DEFAULT)
    del document["sweep"]["f0"]
    document["sweep"]["duration"] = given
    return document


def test_durations_stand_for_frequencies():
    assert load_config(with_durations(["0.5 ms", "2 ms", "100 us"])).axes["f0"].tolist() == [
        500,
        2000,
        10000,
    ]
    log = {"from": "0.1 ms", "to": "10 ms", "points": 21, "spacing": "log"}
    same = {"from": "100 Hz", "to": "10 kHz", "points": 21, "spacing": "log"}
    np.testing.assert_allclose(
        load_config(with_durations(log)).axes["f0"],
        load_config(changed(sweep__f0=same)).axes["f0"],
        rtol=1e-13,
    )
    cell = {"N": 1000, "duration": "0.5 ms", "C": "25 uN*us/um"}
    assert load_config(changed(histories=[cell])).histories[0].shock == {
        "N": 1000.0,
        "f0": 2000.0,
        "C": 25.0,
    }


def test_hard_contact_and_damping():
    device = load_config(changed(device__contact="hard", device__beam__damping="4e-4 /us")).device
    assert (device.contact, device.beam.damping) == (math.inf, 4e-4)


def test_own_points_are_checked_with_the_config(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "points.csv"
    path.write_text("name,N,f0\nslip,1000,1.5\nhere,1000,1500\n,9000,1500\n")
    lines = [line for line in doubts(load_config(changed(marks="points.csv"))) if "csv" in line]
    assert [line.split(",")[0] for line in lines] == [
        "points.csv: slip lies on no map: f0 = 1.5",
        "points.csv: point 3 lies on no map: N = 9000",
    ]
    path.write_text("N,f0\n1000,soon\n")
    assert only_fault(changed(marks="points.csv")).startswith(
        "marks: points.csv: line 2, column f0"
    )


OF_MASS = dict.fromkeys(("device__spring", "device__contact", "sweep__C", "histories"), MISSING)
PUSHED = {"device__gravity": MISSING, "device__force": "2 uN"}
CELL = {"N": 1, "f0": "1 kHz", "C": "1 kg/s"}
DROP = {"height": "1 m", "duration": "0.5 ms"}


@pytest.mark.parametrize("pushed", [{}, PUSHED])
def test_a_beam_alone(pushed):
    """What a product says of it is again its config."""
    study = load_config(changed(device__mass="none", **OF_MASS, **pushed))
    assert study.device.is_alone and study.axes["C"] == [0.0]
    assert study.device.force == (2.0 if pushed else 0.0)
    section = device_sections(study.device)["device"]
    assert section["mass"] == "none" and not {"spring", "contact", "gap", "stops"} & {*section}
    assert read_device(section) == study.device
    assert "no mass" in descriptions(study)[0]
    assert sum("uN of force on the midpoint" in line for line in doubts(study)) == bool(pushed)


ALONE = {"device__mass": "none", **OF_MASS}


@pytest.mark.parametrize(
    ("values", "key"),
    [
        ({"device__beam__span": "600"}, "device.beam.span: '600' has no unit"),
        ({"device__beam__span": MISSING}, "device.beam.span: missing; write a length"),
        ({"device__beam__rise": "4 um"}, "device.beam: rise/thickness = 4 um/2 um"),
        ({"device__beam__rise": "0 um"}, "device.beam: rise/thickness = 0 um"),
        ({"device__beam": None}, "device.beam: an empty value is not a mapping"),
        ({"device__weight": "1 kg"}, "device.weight: unknown key; known here are beam, mass"),
        ({"device__contact": "soft"}, "device.contact: 'soft'"),
        ({"model__name": "nodal"}, "model.name: 'nodal' is not one of reference"),
        ({"model__name": MISSING}, "model.name: missing; write one of"),
        ({"model__elements": 5.0}, "model.elements: 5.0"),
        ({"model__elements": True}, "model.elements: "),
        ({"model__modes": "5"}, "model.modes: '5'"),
        ({"model__cosines": -1}, "model.cosines: -1"),
        ({"model__step": 1.5}, "model.step: 1.5"),
        ({"model__step": math.nan}, "model.step: nan"),
        ({"sweep__horizon": 1500}, "sweep.horizon: 1500 has no unit"),
        ({"sweep__N": 1000}, "sweep.N: 1000 is not a list or a range"),
        ({"sweep__N": []}, "sweep.N: an empty list is not a list"),
        ({"sweep__N": [1, math.nan]}, "sweep.N[1]: nan"),
        ({"sweep__N": [1, 2, 1.0]}, "sweep.N: 1 comes twice"),
        ({"sweep__N": {"from": 1, "to": 1 + 1e-15, "points": 30}}, "sweep.N: 1 comes twice"),
        ({"sweep__f0": ["1 kHz", "1000 Hz"]}, "sweep.f0: 1000 Hz comes twice"),
        ({"sweep__f0__from": "0 Hz"}, "sweep.f0.from: '0 Hz' is not above 0"),
        ({"sweep__f0__spacing": "lin"}, "sweep.f0.spacing: 'lin' is not one of linear, log"),
        ({"sweep__N__step": 20}, "sweep.N.step: unknown key; known here are from, to, points"),
        ({"sweep__N__points": MISSING}, "sweep.N.points: missing"),
        ({"sweep__N__points": 10**7}, "sweep.N.points: 10000000"),
        ({"sweep__N__points": 1}, "sweep.N.points: 1 needs equal ends"),
        ({"sweep__N__to": 600}, "sweep.N.points: 91 needs from and to that differ"),
        ({"sweep__N__spacing": "log", "sweep__N__from": -1}, "sweep.N.spacing: log needs"),
        ({"sweep__f0": MISSING}, "sweep.f0: missing; write frequencies"),
        ({"sweep__duration": ["1 ms"]}, "sweep.duration: is one over f0"),
        ({"histories": {}}, "histories: a mapping is not a list of cells"),
        ({"histories": [3]}, "histories[0]: 3 is not a mapping"),
        ({"histories": [{"N": 1, "C": "1 kg/s"}]}, "histories[0].f0: missing"),
        ({"histories": [{**CELL, "device": "a"}]}, "histories[0]: device is for studies"),
        ({"marks": "none.csv"}, "marks: none.csv: is not there"),
        ({"marks": "../points.csv"}, "marks: ../points.csv lies outside the study's folder"),
        ({"marks": "/etc/passwd"}, "marks: /etc/passwd lies outside the study's folder"),
        ({"marks": ""}, "marks: '' is not the path"),
        ({**ALONE, "device__gap": "1 um"}, "device.gap: is of the mass"),
        ({**ALONE, "sweep__C": ["1 kg/s"]}, "sweep.C: is of the mass"),
        ({**ALONE, "sweep__spring": ["1 N/m"]}, "sweep: spring: is of"),
        (PUSHED, "device.force: 2 uN is of a beam alone; write mass: none"),
        ({"device__force": "2 uN"}, "device.gravity: stands beside force"),
        ({**ALONE, **PUSHED, "pulse": {"drop": DROP}}, "device.force: the shock 'drop' shakes"),
        ({"device__spring": MISSING}, "device.spring: missing; write a stiffness"),
        ({"device__beam__damping": "1 /us", "device__beam__quality_factor": 9}, "device.beam.q"),
        ({"device__quality_factor": 9}, "device.quality_factor: stands beside sweep.C"),
        ({"sweep__C": MISSING}, "sweep.C: missing; write dampers"),
        ({"device__beam__shape": {"cosines": []}}, "device.beam.shape.cosines: an empty list"),
        ({"pulse": {"shape": "half sine", "form": 1}}, "pulse.form: unknown key"),
        ({"devices": {"a b": DEFAULT["device"]}, "device": MISSING}, "devices['a b']: 'a b' is"),
    ],
)
def test_a_fault_is_one_line_that_names_its_key(values, key):
    assert only_fault(changed(**values)).startswith(key)


def test_all_faults_are_reported_at_once_wherever_they_are():
    document = changed(
        device__beam__span="600",
        device__spring=MISSING,
        model__step=2,
        sweep__C=["1 kg/s", "2 kg", 3],
        sweep__N=[1, 1],
        sweep__horizon=MISSING,
        requirements=[{"name": "drop", "N": -3, "f0": "1 kHz", "snaps": False}],
        marks="none.csv",
    )
    document |= {1: 2, "a\nb": 4}
    keys = {line.split(": ")[0] for line in faults(document)}
    assert keys == {
        *("device.beam.span", "device.spring", "model.step", "sweep.C[1]", "sweep.C[2]", "sweep.N"),
        *("sweep.horizon", "requirements[0].N", "marks", "[1]", "['a\\nb']"),
    }


@pytest.mark.parametrize("document", [None, 3, "device", [], [DEFAULT]])
def test_document_is_a_mapping(document):
    assert only_fault(document).startswith("config: ")


def test_load_device_looks_at_the_device_only(tmp_path):
    path = tmp_path / "config.yaml"
    path.write_text(yaml.safe_dump({"device": DEFAULT["device"], "model": 1, "more": 2}))
    assert load_device(path) == load_config(DEFAULT).device


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("sweep: {}", "device: missing; write a mapping: "),
        ("device: 3", "device: 3 is not a mapping: "),
        ("[1, 2]", "{path}: a list is not a mapping of device, model, sweep"),
        ("", "{path}: an empty value is not a mapping of device, model, sweep"),
        ("a: 1\nb: [", "{path}: line 2 is not valid YAML: "),
        ("a: 1\na: 2", "{path}: line 2 is not valid YAML: 'a' comes twice"),
        ("__use_yte__: true", "{path}: __use_yte__ is not allowed; write values"),
        ("a: \x00", "{path}: not valid YAML: "),
        ("a: 2026-13-45", "{path}: not valid YAML: "),
        ("[" * 2000, "{path}: not valid YAML: "),
        ("a: !!python/object:os.system x", "{path}: line 1 is not valid YAML: "),
    ],
)
def test_load_device_refuses(tmp_path, text, fault):
    path = tmp_path / "config.yaml"
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_device(path)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(fault.format(path=path))


def test_missing_file(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.yaml: is not there"):
        load_device(tmp_path / "none.yaml")


NUMBERS = st.one_of(
    st.from_regex(r"[+-]?[0-9]{1,3}(\.[0-9]{0,2})?(e-?[0-9]{1,4})?", fullmatch=True),
    st.sampled_from(["", "nan", "-inf", "2**9**9", "0x10", "1_0", "."]),
)
UNITS = st.one_of(
    st.from_regex(r"(/ ?)?[a-z\u00b5%]{1,4}([*/ ]{1,2}[A-Za-z]{1,3}(\^|\*\*)?-?[0-9]?){0,3}"),
    st.sampled_from(["um", "Hz", "kg", "N/m", "us", "uN*us/um", "rad/s", "degC", "/", "m^"]),
)
QUANTITIES = st.builds(lambda *parts: "".join(parts), NUMBERS, st.sampled_from(["", " "]), UNITS)


@settings(max_examples=200, derandomize=True, deadline=None, database=None)
@given(
    QUANTITIES | st.text(alphabet="0123456789.eE+-*/^ umNkgHzrad\N{MICRO SIGN}%()²", max_size=30)
)
@example("0 Qs^9*Rs^9/us^9/ns^8")
def test_any_text_is_a_finite_quantity_or_a_fault(text):
    for kind in ("length", "damper", "number"):
        try:
            value = read(text, kind)
        except ValueError as error:
            assert "\n" not in str(error)
        else:
            assert math.isfinite(value)


def test_a_tolerance_is_a_share_in_percent():
    assert read("0.1 %", "share") == 0.001 and read("5%", "share") == 0.05
    for wrong in ("0.1", 0.1, "3 dB", "0 %", "-1 %", "100 %", "0.1 um"):
        with pytest.raises(ValueError, match=r"write a share such as '0\.1 %'$"):
            read(wrong, "share")
    document = changed(model={"name": "auto", "tolerance": "0.1 %"})
    assert load_config(document).model == {"name": "auto", "tolerance": 0.001}


def test_what_a_study_makes_is_listed():
    """Figures by the rule that draws them; all, without any twice."""
    made = products(load_config(DEFAULT))
    assert [view.name for view in made.snaps] == [one.replace("map", "snap") for one in _maps(made)]
    times = [view.name for view in made.times]
    assert made.map_stems == [*times, *_maps(made), "maps"]
    assert made.stems[: len(made.snap_stems)] == made.snap_stems
    assert made.batch_stems == ["probability", "sensitivity"] and list(made.statics) == [""]
    assert not {*made.batch_stems, "requirements"} & {*made.stems}
    assert len({*made.stems}) == len(made.stems)
    snapping = copy.deepcopy(DEFAULT)
    snapping["sweep"]["until"] = "snap"
    assert not products(load_config(snapping)).ends


def _maps(made):
    return [view.name for view in made.ends]
