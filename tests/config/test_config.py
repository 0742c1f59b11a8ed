"""The door: what comes in is exact, what stays out is named in one line per fault."""

import math
import re
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import small_studies
import yaml
from small_studies import MISSING, cases_of, faults

from snapmap.applications import boundary, requirements, window
from snapmap.applications.whole import doubts, load_config
from snapmap.config.devices import load_device, read_device, read_shape
from snapmap.config.doubts import descriptions
from snapmap.config.yaml_file import read_document
from snapmap.device.device import Beam, Device
from snapmap.device.shape import TILT
from snapmap.solver.options import Auto, Reference
from snapmap.solver.settings import Run
from snapmap.study.provenance import device_sections
from snapmap.values.faults import Faults

ROOT = Path(__file__).parents[2]
CASES = cases_of(__file__)
DEFAULT = read_document(ROOT / "config/handout.yaml")
changed = partial(small_studies.changed, DEFAULT)


def only_fault(document):
    (line,) = faults(document)
    return line


@pytest.mark.parametrize(("axis", "values"), [*CASES["axes"], ((2, 1), [1.0, 2.0])])
def test_axes_ascend(axis, values):
    assert np.array_equal(load_config(changed(sweep__N=axis)).axes["N"], values)


def test_no_window_is_over_temperature_and_axes_keep_the_units_they_are_written_in():
    shock = {"name": "drop", "shape": "half sine", "N": 1000, "duration": "1 ms", "snaps": False}
    axes = {"mass": {"from": "0.01 mg", "to": "0.02 mg", "points": 3}, "C": ["1 mN*s/m", "2 kg/s"]}
    swept = {f"sweep__{key}": axes[key] for key in axes} | {"histories": MISSING}
    swept |= {"sweep__temperature": ["-40 degC", "125 degC"], "requirements": [shock]}
    figures = window.application.figures(load_config(changed(**swept)))
    assert [*figures["window"]["units"]] == ["mass", "C"]
    units = {"mass": ("mg", 1e6), "C": ("mN*s/m", 1e3), "contact": ("uN/um", 1.0)}
    assert load_config(changed(**swept, sweep__contact=["hard", "40 N/m"])).units == units


ALONE, PUSHED = CASES["alone"], CASES["pushed"]


@pytest.mark.parametrize("pushed", [{}, PUSHED])
def test_a_beam_alone_has_no_mass_and_what_a_product_says_of_it_is_again_its_config(pushed):
    study = load_config(changed(**ALONE, **pushed))
    assert study.device.is_alone and study.axes["C"] == [0.0]
    assert study.device.force == (2.0 if pushed else 0.0)
    section = device_sections(study.device)["device"]
    assert section["mass"] == "none" and not {"spring", "contact", "gap", "stops"} & {*section}
    assert read_device(section) == study.device
    assert descriptions(study) == CASES["described"][1:]
    assert ["uN on the midpoint" in line for line in doubts(study)] == [True] * bool(pushed)
    assert ("damage_boundary" in boundary.application.figures(study)) != bool(pushed)


def test_load_device_looks_at_the_device_only(tmp_path):
    sections = {"device": DEFAULT["device"], "model": 1, "more": 2}
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(sections))
    assert load_device(tmp_path / "config.yaml") == load_config(DEFAULT).device


def test_the_study_of_the_handout_is_exact():
    study = load_config(DEFAULT)
    beam = Beam(600.0, 10.0, 2.0, 22.0, youngs_modulus=150000.0, density=0.00233)
    assert study.device == Device(beam, mass=10000.0, spring=5.5, contact=40.0, gravity=9.81e-6)
    assert study.model == Reference(elements=5)
    for tolerance in (0.002, "0.002", "2e-3"):
        tolerant = {"name": "auto", "tolerance": tolerance}
        assert load_config(changed(model=tolerant)).model == Auto(tolerance=0.002)
    assert np.array_equal(study.axes["N"], np.arange(600.0, 2401.0, 20.0))
    assert np.array_equal(study.axes["C"], [0.025, 25.0, 200.0])
    f0 = study.axes["f0"]
    assert (f0.size, f0[0], f0[-1]) == (41, 100.0, 30000.0)
    assert np.allclose(f0[1:] / f0[:-1], 300 ** (1 / 40), rtol=1e-13)
    run = Run(horizon=1500.0, until="settled", energy_tolerance=1e-3)
    assert study.run.but(threads=1) == run and study.run.repeats
    assert descriptions(study) == CASES["described"][:1]
    (cell,) = study.requests["histories"]
    assert cell.shock == {"N": 1000.0, "f0": 1500.0, "C": 0.025} and cell.changes == {}
    assert cell.name == "N1000_f1500_C0.025" and study.own_points == ()


def test_the_configs_are_read_alone_by_a_python_without_docstrings(python):
    said, faults = python(CASES["reads"], options=["-OO"])
    assert said == "set() 600.0\n" and "\ndevice: 3 is not a mapping\n" in faults, faults


def test_durations_stand_for_frequencies():
    def frequencies(**axis):
        swept = {"sweep__f0": MISSING, **{f"sweep__{key}": axis[key] for key in axis}}
        return load_config(changed(**swept)).axes["f0"]

    assert frequencies(duration=["0.5 ms", "2 ms", "100 us"]).tolist() == [500, 2000, 10000]
    log = {"points": 21, "spacing": "log"}
    durations = frequencies(duration={"from": "0.1 ms", "to": "10 ms", **log})
    same = frequencies(f0={"from": "100 Hz", "to": "10 kHz", **log})
    np.testing.assert_allclose(durations, same, rtol=1e-13)
    for pulse in ({"f0": "2 kHz"}, {"duration": "0.5 ms"}):
        study = load_config(changed(histories=[{"N": "1e3", "C": "0 kg/s", **pulse}]))
        assert study.requests["histories"][0].shock == {"N": 1000.0, "f0": 2000.0, "C": 0.0}


def test_a_history_has_the_duration_and_damper_that_the_study_alone_has():
    train = {"train": [{"duration": "0.1 ms"}, {"wait": "0.3 ms"}]}
    alone = {"sweep__C": ["3 kg/s"], "histories": [{"N": 7}]}
    itself = alone | {"pulse": train, "sweep__f0": MISSING}
    (cell,) = load_config(changed(**itself)).requests["histories"]
    assert cell.shock == {"N": 7.0, "f0": 2500.0, "C": 3e6}
    several = changed(**(itself | {"sweep__C": ["1 kg/s", "2 kg/s"]}))
    for document, key in ((changed(**alone), "f0"), (several, "C")):
        (line,) = faults(document)
        assert line.startswith(f"histories[0].{key}: missing; write ")


DROP, BLOW, FREE = (CASES[key] for key in ("drop", "blow", "free"))

NAMED = {"devices": {"a b": DEFAULT["device"]}, "device": MISSING}
FAULTY = (
    *(("config", document) for document in (None, 3, "device", [], [DEFAULT])),
    ("devices['a b']", changed(**NAMED)),
    *((key, changed(**values)) for key, values in CASES["faulty"]),
    *((key, changed(**values, requirements=[one])) for key, values, one in CASES["requirements"]),
)


@pytest.mark.parametrize(("key", "document"), FAULTY)
def test_a_fault_between_keys_is_one_line_that_names_one(key, document):
    """Faults of single values: test_bad_configs.py."""
    assert f"{only_fault(document)}: ".startswith(f"{key}: ")


INHERITED, OF_DROP, SHAKEN = (CASES[key] for key in ("inherited", "of_drop", "shaken"))


@pytest.mark.parametrize("kind", SHAKEN)
@pytest.mark.parametrize("key", INHERITED)
def test_each_key_that_a_requirement_lacks_is_that_of_the_study(kind, key):
    """As if it were written: without it, and with it, the same pulse; in another study another."""

    def pulse_of(study, **own):
        asked = {"name": "a", "snaps": False} | SHAKEN[kind] | own
        config = load_config(changed(pulse=study, requirements=[asked]))
        ((shock,),) = [shock.shocks.each() for shock in requirements.shocks_of(config)]
        return shock.pulse, shock.direction

    pulse, direction = pulse_of(INHERITED)
    forms = {name: value for name, value in INHERITED.items() if name != "direction"}
    blows = SHAKEN["train"]["train"]
    trained = [forms | blow if "duration" in blow else blow for blow in blows]
    own = {"drop": {"drop": forms | OF_DROP}, "shock": forms, "train": {"train": trained}}[kind]
    assert pulse_of({}, **own, direction="-z") == (pulse, direction)
    less = {name: value for name, value in INHERITED.items() if name != key}
    less = {"direction": "-z"} if key == "shape" else less
    assert pulse_of(less) != (pulse, direction)


def test_a_shape_of_its_own_counts_also_if_it_is_the_usual_one():
    own = {"name": "a", "drop": OF_DROP | {"shape": "versed sine"}, "snaps": False}
    study = changed(pulse={"shape": "half sine"}, requirements=[own])
    (shock,) = requirements.shocks_of(load_config(study))
    assert shock.shocks.pulse.section["drop"]["shape"] == "versed sine"
    assert shock.shocks.pulse.words == "drop from 20 cm, versed sine of 1 ms"


def test_all_faults_are_reported_at_once_wherever_they_are():
    values = {"device__beam__span": "600", "model__step": 2, "sweep__N": [1, 1]}
    values |= {"device__spring": MISSING, "run__horizon": "-1 us", "marks": "none.csv"}
    drop = {"name": "drop", "N": -3, "f0": "1 kHz", "snaps": False}
    document = changed(**values, sweep__C=["1 kg/s", "2 kg", 3], requirements=[drop])
    keys = {line.split(": ")[0] for line in faults(document | {1: 2, "a\nb": 4})}
    of_lists = {"sweep.C[1]", "sweep.C[2]", "requirements[0].N", "[1]", "['a\\nb']"}
    assert keys == {key.replace("__", ".") for key in values} | of_lists


def test_like_faults_of_a_list_are_told_once_with_their_number():
    many = [f"{degrees} degC" for degrees in range(50)] + [*range(1950)]
    line = only_fault(changed(sweep__temperature=many))
    assert line.startswith("sweep.temperature[50]: 0 has no unit; write a temperature")
    assert line.endswith(" (and 1949 others of this list)")


def test_a_file_outside_the_folder_of_the_study_is_refused(tmp_path, monkeypatch):
    (tmp_path / "points.csv").write_text("N,f0\n1000,2000\n", encoding="utf-8")
    (tmp_path / "study").mkdir()
    monkeypatch.chdir(tmp_path / "study")
    for marks in ("../points.csv", "sub/../../points.csv", str(tmp_path / "points.csv")):
        assert "lies outside the study's folder" in only_fault(changed(marks=marks))


def write_shape(length=600.0, rise=10.0, points=50, tilt=0.0):
    """A cosine from clamp to clamp, and a part in the first antisymmetric shape."""
    s = np.linspace(-0.5, 0.5, points)
    mu = 2 * np.pi * math.sqrt(TILT)
    tilted = mu / (4 * np.pi) * (np.sin(mu * s) / np.sin(mu / 2) - 2 * s)
    w = rise * (1 + np.cos(2 * np.pi * s)) / 2 + tilt * tilted
    table = np.column_stack([length * (s + 0.5), w])
    np.savetxt("shape.csv", table, delimiter=",", header="x (um),w (um)", comments="")


MEASURED = {"device__beam__shape": {"file": "shape.csv"}}
NEARLY, FAR_OFF = CASES["nearly"], CASES["far_off"]


@pytest.mark.parametrize("key", NEARLY)
def test_a_measured_shape_has_20_points_and_span_and_rise_of_the_config(tmp_path, monkeypatch, key):
    """To a tenth, whether it lies as it was made or upside down."""
    monkeypatch.chdir(tmp_path)
    for value in NEARLY[key]:
        write_shape(**{key: value})
        beam = load_config(changed(**MEASURED)).device.beam
        write_shape(**{"rise": 10.0, key: value} | {"rise": -(value if key == "rise" else 10.0)})
        assert load_config(changed(**MEASURED)).device.beam == beam
    for value, line in FAR_OFF[key].items():
        write_shape(**{key: value})
        assert only_fault(changed(**MEASURED)).startswith(f"device.beam{line}")


def test_a_measured_tilt_is_the_imperfection_of_a_free_beam_unless_it_is_rounding(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    free = {"device__beam__free": True}
    for tilt in (-0.3, 1.1e-6):
        write_shape(tilt=tilt)
        made = load_config(changed(**MEASURED, **free)).device.beam.imperfection
        assert made == pytest.approx(abs(tilt), rel=1e-3)
        assert load_config(changed(**MEASURED)).device.beam.imperfection == 0.0
        assert load_config(changed(**MEASURED, **FREE)).device.beam.imperfection == 0.01
    write_shape(tilt=0.9e-6)
    assert "imperfection: 0 um never tilts" in only_fault(changed(**MEASURED, **free))


def test_a_measured_shape_is_smoothed(tmp_path):
    """Upside down, tilted under the microscope, with noise."""
    x = np.linspace(0, 600, 301)
    w = 4.6 * (1 - np.cos(2 * np.pi * x / 600)) + 0.5 * (1 - np.cos(4 * np.pi * x / 600))
    noise = np.random.default_rng(1).normal(0, 0.02, x.size)
    path, columns = tmp_path / "shape.csv", np.column_stack([x + 40, 1e3 * (0.01 * x - w - noise)])
    np.savetxt(path, columns, "%.3f", ",", header="x (um),w (nm)", comments="")
    read = read_shape(path)
    noises = noise.std(), abs(noise).max(), 301
    assert (read.rms, read.most, read.points) == pytest.approx(noises, rel=0.1)
    assert sum(read.cosines[::2]) == pytest.approx(9.2, abs=0.01)
    assert read.cosines[1] == pytest.approx(1, abs=0.01)
    path.write_text("x (um),w (um)\n" + "\n".join(f"{a},{a % 7}" for a in range(50)))
    with pytest.raises(ValueError, match=r"shape\.csv: differs by .* from 5 cosines"):
        read_shape(path)


def test_a_shape_stands_above_its_clamps():
    def shaped(*cosines):
        return changed(device__beam__shape={"cosines": cosines})

    for third, total in ((-1, 0), (-3, -2)):
        line = f"device.beam.shape.cosines: the odd ones add up to {total}, not above 0"
        assert only_fault(shaped(1, 0.1, third)) == line
    beam = load_config(shaped(33, 2, -1)).device.beam
    assert (beam.cosine_2, beam.cosine_3) == (0.0625, -0.03125)


@pytest.mark.parametrize("case", CASES["figures"], ids=lambda case: str(case["values"]))
def test_figures_are_over_axes_of_several_values_and_of_many_maps_twelve_are_drawn(case):
    study = load_config(changed(histories=MISSING, **case["values"]))
    assert [[*view[:4]] for view in (*study.maps, *study.curves)] == case["figures"]
    assert study.left_out == case.get("line", "")


HOSTILE, HARMLESS = CASES["hostile"], CASES["harmless"]


@pytest.mark.parametrize("key", CASES["paths"])
def test_a_path_has_no_sign_that_tables_or_the_terminal_would_obey(tmp_path, monkeypatch, key):
    monkeypatch.chdir(tmp_path)
    section, _, last = key.rpartition("__")
    is_new = last in ("file", "shots")
    for name in (*HOSTILE, *HARMLESS):
        values = {section: {last: name}} if is_new else {key: name}
        values = {"model": {"name": "elements", last: name}} if section == "model" else values
        lines = faults(changed(**values))
        refused = [line for line in lines if line.endswith("rename it")]
        if name in HOSTILE:
            (line,) = refused
            assert line.startswith(f"{key.replace('__', '.')}: ") and line.isprintable()
        else:
            assert not refused


@pytest.mark.parametrize("name", ["Gerät_ü", "Образец-2", "a"])
def test_a_device_has_a_name_in_any_letters(name):
    document = changed()
    document["devices"] = {name: document.pop("device")}
    study = load_config(document)
    assert [*study.devices()] == [*study.written] == [name]


@pytest.mark.parametrize(("key", "value", "usual"), CASES["far"])
def test_a_value_far_off_is_told_in_one_line(key, value, usual):
    (line,) = [line for line in doubts(load_config(changed(**{key: value}))) if "usual" in line]
    name = "N" if isinstance(value, list) else key.rpartition("__")[2]
    assert re.match(rf"{name} = \S+( \S+)? is outside the usual {usual}; is its unit .*\?$", line)


def test_records_of_requirements_and_shots_are_doubted_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = "".join(f"{t},{min(t * (8 - t), 9)}\n" for t in range(9))
    Path("top.csv").write_text(f"time (ms),a (g)\n{rows}")
    shots = "N,tripped,file\n500,no,top.csv\n990,yes,top.csv\n999,yes,top.csv\n"
    Path("shots.csv").write_text(shots)
    shock = {"name": "a", "file": "top.csv", "N": 1000, "snaps": True}
    both = {"requirements": [shock, shock | {"name": "b"}]}
    unknowns = {"thickness": ["1.9 um", "2.1 um"]}
    fit = {"calibration": {"shots": "shots.csv", "unknowns": unknowns, "C": "25 uN*us/um"}}
    for sections in (both, fit, both | fit):
        (line,) = [x for x in doubts(load_config(changed(**sections))) if "flat" in x]
        assert line == "top: is flat at its peak for 4 ms, as of a sensor beyond its range"


def test_of_what_is_usual_nothing_is_told(monkeypatch):
    """Nor of a value that is left out, or of a mass where there is none."""
    monkeypatch.chdir(ROOT / "config")  # of a record
    configs = [changed(device__contact="hard", device__gap="0 um", run__horizon="0 us")]
    configs += [changed(**ALONE)]
    assert not any("usual" in line for config in configs for line in doubts(load_config(config)))
    for path in (ROOT / "config").glob("*.yaml"):
        assert doubts(load_config(read_document(path))) == [], path.name


def test_a_mark_has_a_name_that_can_be_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("a\x1b[31mb", "<b>", "n" * 61, "a|b", "=1"):
        (tmp_path / "points.csv").write_text(f"name,N,f0\n,900,2000\n{name},1000,2000\n")
        line = only_fault(changed(marks="points.csv"))
        assert line.startswith("marks: points.csv: column name: ") and line.isprintable()


TEXTS = (
    *(b"sweep: {}", b"device: 3", b"[1, 2]", b"", b"a: 1\nb: [", b"a: 1\na: 2", b"a: \x00"),
    *(b"[" * 2000, b"__use_yte__: true", b"a: 2026-13-45", b"a: !!python/object:os.system x", None),
    *(b"a: \xe9\n", b"a: 1:30:00", b"a: 010", b"a: 1:30.5", rb'"__use\x5fyte__": true'),
    b"a: [%s]" % (b"1234567, " * 1_000_000),
)


@pytest.mark.parametrize("text", TEXTS, ids=range(len(TEXTS)))
def test_a_file_that_holds_no_device_is_one_line_that_names_it(tmp_path, text):
    path = tmp_path / "config.yaml"
    if text is not None:
        path.write_bytes(text)
    with pytest.raises(Faults) as caught:
        load_device(path)
    (line,) = str(caught.value).splitlines()
    assert line.startswith("device: " if text in TEXTS[:2] else f"{path}: ")
