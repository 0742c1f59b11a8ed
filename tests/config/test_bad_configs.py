"""Bad input at scale: a config gives a study, or clear single lines; its text is never run."""

import copy
import datetime
import math
import re

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from small_workflow import snakemake

from snapmap.applications import gather
from snapmap.config.study import load_config
from snapmap.config.units import show
from snapmap.config.yaml_file import ConfigError
from snapmap.device.quantities import KINDS, bounds_of
from snapmap.sweeps.plan import make_plan

DEFAULT = yaml.safe_load("""
device:
  beam: {span: 600 um, rise: 10 um, thickness: 2 um, depth: 22 um, youngs_modulus: 150 GPa,
         density: 2330 kg/m^3, damping: 4e-4 /us}
  mass: 1e-8 kg
  spring: 5.5 N/m
  contact: 40 N/m
  gravity: 9.81 m/s^2
model: {name: elements, elements: 5}
sweep:
  N: {from: 600, to: 2400, points: 7}
  f0: {from: 100 Hz, to: 30 kHz, points: 5, spacing: log}
  C: [0.025 uN*us/um, 25 uN*us/um]
  horizon: 1500 us
  until: settled
  repeat: true
  energy_tolerance: 0.001
  threshold_tolerance: 0.0001
histories:
  - {N: 1000, f0: 1500 Hz, C: 25 uN*us/um}
""")
OPTIONAL = {"damping", "elements", "spacing", "until", "repeat"}
OPTIONAL |= {"energy_tolerance", "threshold_tolerance", "histories"}
KIND = {
    **dict.fromkeys(("span", "thickness", "depth"), "length"),
    "rise": "distance",  # of 0 a device cannot be, which is said of it as a device
    **{"youngs_modulus": "modulus", "density": "density", "damping": "rate", "mass": "mass"},
    **{"spring": "stiffness", "contact": "contact", "gravity": "acceleration"},
    **{"horizon": "duration", "f0": "frequency", "C": "damper", "N": "number"},
}
HOSTILE = [
    *("$(touch PWNED)", "`touch PWNED`", "; touch PWNED #", "600 um; touch PWNED", "../../PWNED"),
    *("__import__('os').system('touch PWNED')", "?open('PWNED', 'w')", "{open('PWNED', 'w')}"),
    *("{{ cycler.__init__.__globals__.os.system('touch PWNED') }}", "{workflow}", "%(name)s"),
    *(
        "\x1b[31m\r\n\t\x07",
        "\N{RIGHT-TO-LEFT OVERRIDE}mu 006",
        "a\N{LINE SEPARATOR}b\N{NEXT LINE}c",
    ),
]


def leaves(part, at=()):
    """Paths of every value that is no mapping and no list."""
    if not isinstance(part, dict | list):
        yield at
        return
    for key in part if isinstance(part, dict) else range(len(part)):
        yield from leaves(part[key], (*at, key))


def get(document, path):
    for key in path:
        document = document[key]
    return document


def name_of(path):
    name = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)
    return name.removeprefix(".")


def kind_of(path):
    """The kind of quantity at a path; None for words, whole numbers and true or false."""
    if path[-1] in ("points", "spacing"):
        return None
    return next((KIND[key] for key in reversed(path) if key in KIND), None)


LEAVES = list(leaves(DEFAULT))
SECTIONS = sorted({path[:-1] for path in LEAVES if path[:-1]}, key=str)
MAPPINGS = [path for path in SECTIONS if isinstance(get(DEFAULT, path), dict)]
RATES = {KINDS["rate"].unit, KINDS["frequency"].unit}
UNITS = [kind.unit for kind in KINDS.values() if kind.unit]

numbers = st.from_regex(r"[+-]?[1-9][0-9]{0,2}(\.[0-9]{1,2})?(e-?[0-9]{1,2})?", fullmatch=True)
no_value = st.one_of(
    st.sampled_from([None, {}, [], math.nan, math.inf, b"\0", datetime.date(2026, 1, 1), *HOSTILE]),
    st.text(alphabet=st.characters(exclude_characters="0123456789"), max_size=8).filter(
        lambda text: text not in {"hard", "settled", "snap", "linear", "log"}
    ),
    st.text(min_size=80, max_size=300),
    st.lists(st.integers() | st.none(), min_size=1, max_size=3),
    st.dictionaries(st.text(max_size=3), st.integers(), min_size=1, max_size=2),
)


def no_quantity(kind):
    """Values that the given kind of quantity cannot have."""
    unit, sign = KINDS[kind].unit, st.sampled_from(["-3 ", "nan ", "inf ", "1e25 ", "1e-40 "])
    takes_zero = bounds_of(KINDS[kind].interval).holds(0)
    wrong_size = sign if takes_zero else st.sampled_from(["0 "]) | sign
    others = [other for other in UNITS if {unit, other} != RATES and other != unit]
    return st.one_of(
        no_value,
        st.booleans(),
        numbers,
        st.integers() | st.floats(),
        st.builds(" ".join, st.tuples(numbers, st.sampled_from(others))),
        wrong_size.map(lambda size: size + unit),
        st.sampled_from(["1 furlong^9", "1 rad/s", "3 dB", "20 degC", "9**9**9 m", "1_0 um"]),
    )


NO_NUMBER = no_value | st.sampled_from(["1 g", "1,5", "0x10", True, "nan", 1e300, "1e999", -2e15])
NO_WORD = no_value | st.booleans() | st.floats() | st.integers(max_value=0) | numbers
BAD_LEAF = {
    "elements": st.one_of(no_value, st.integers(max_value=0), st.integers(101), st.booleans()),
    "points": st.one_of(no_value, st.integers(max_value=0), st.integers(10**6 + 1), st.floats()),
    "energy_tolerance": no_value | st.floats(max_value=0) | st.floats(min_value=1) | numbers,
    "threshold_tolerance": no_value | st.floats(max_value=0) | st.floats(min_value=0.02) | numbers,
    "repeat": no_value | numbers | st.integers() | st.sampled_from(["true", "yes", "no"]),
}


@st.composite
def wrong(draw):
    """A document with one to three faults in it, and where they are to be reported."""
    document, places = copy.deepcopy(DEFAULT), []
    for _ in range(draw(st.integers(1, 3))):
        path, damage = draw(st.sampled_from(DAMAGES))
        if any(path[: len(at)] == at[: len(path)] for at, _ in places):
            continue  # one fault must not hide another
        places += [(path, named) for named in damage(draw, document, path)]
    return document, [named for _, named in places]


def set_badly(draw, document, path):
    kind = kind_of(path)
    values = {None: NO_WORD, "number": NO_NUMBER}
    values = values[kind] if kind in values else no_quantity(kind)
    value = draw(BAD_LEAF.get(path[-1], values))
    get(document, path[:-1])[path[-1]] = value
    return [(name_of(path), show(value))]


def delete(draw, document, path):
    del get(document, path[:-1])[path[-1]]
    return [(name_of(path), "missing; write ")]


def rename(draw, document, path):
    section = get(document, path[:-1])
    new = draw(st.sampled_from([path[-1].upper() + "s", f" {path[-1]}", 1, None, "é" * 300]))
    section[new] = section.pop(path[-1])
    missing = [] if path[-1] in OPTIONAL else [(name_of(path), "missing; write ")]
    return [*missing, (name_of(path[:-1]), "unknown key; known here are ")]


def add_key(draw, document, path):
    key = draw(st.text(max_size=50).map(lambda text: f"{text}+") | st.integers() | st.none())
    get(document, path)[key] = draw(no_value)
    return [(name_of(path), "unknown key; known here are ")]


def flatten(draw, document, path):
    value = draw(st.sampled_from(["text", 3, True, None, math.nan, datetime.date(2026, 1, 1)]))
    get(document, path[:-1])[path[-1]] = value
    return [(name_of(path), f"{show(value)} is not a")]


NAMED = [path for path in LEAVES if isinstance(path[-1], str)]
DAMAGES = [
    *[(path, set_badly) for path in LEAVES] * 4,
    *[(path, delete) for path in NAMED if path[-1] not in OPTIONAL],
    *[(path, rename) for path in NAMED],
    *[(path, add_key) for path in MAPPINGS],
    *[(path, flatten) for path in SECTIONS],
]


def lines_of(document):
    """The faults of a document, each a clear single line; empty if it gives slabs."""
    try:
        study = load_config(document)
        make_plan(study.grid, study.model, study.settings, gather("alone", study))
    except ConfigError as error:
        lines = list(error.args)
    except ValueError as error:
        lines = str(error).split("\n")
    else:
        return []
    assert lines
    for line in lines:
        assert line.isprintable() and 10 < len(line) <= 350, line
        assert re.match(r"\S.*: \S.*\S$", line), line
    return lines


def test_no_text_of_a_config_is_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for text in HOSTILE:
        document = copy.deepcopy(DEFAULT)
        for path in LEAVES:
            get(document, path[:-1])[path[-1]] = text
        assert len(lines_of(document)) == len(LEAVES)
    assert not [*tmp_path.iterdir()]


def all_wrong(examples):
    """Whether every fault of so many configs is one line with its key and what it concerns."""

    @settings(max_examples=examples, derandomize=True, deadline=None, database=None)
    @given(wrong())
    def check(damaged):
        document, places = damaged
        lines = lines_of(document)
        for name, complaint in places:
            assert any(line.startswith(name) and complaint in line for line in lines), lines

    check()


@pytest.mark.parametrize("examples", [30, pytest.param(5000, marks=pytest.mark.long)])
def test_every_fault_is_one_line_naming_key_and_value(examples):
    all_wrong(examples)


MANY = {"from": 1, "to": 9, "points": 10**6}, {"from": "1 Hz", "to": "9 Hz", "points": 10**5}


ABSURD = (
    ("device.beam.span", "1e300 m", "device.beam.span"),
    ("sweep.f0", ["1e-300 Hz"], "sweep.f0[0]"),
    ("sweep.f0", ["1e-15 Hz"], "sweep.f0"),
    ("sweep", DEFAULT["sweep"] | dict(zip(("N", "f0"), MANY, strict=True)), "sweep"),
    ("sweep.horizon", "1e30 us", "sweep.horizon"),
    ("sweep.horizon", "1e14 us", "sweep.horizon"),
    ("histories", [{"N": 1, "f0": "1e-14 Hz", "C": "1 kg/s"}], "histories"),
    ("model.elements", 10**9, "model.elements"),
    ("sweep.C", ["0.1 kg/s", "0.10000000000000002 kg/s"], "sweep.C"),
    ("sweep.C", {"from": "1 kg/s", "to": "2 kg/s", "points": 1001}, "sweep.C"),
    ("device.beam.thickness", "1e-15 um", "device.beam.thickness"),
)


@pytest.mark.parametrize(("path", "value", "key"), ABSURD)
def test_absurd_values_are_refused(path, value, key):
    document, path = copy.deepcopy(DEFAULT), path.split(".")
    get(document, path[:-1])[path[-1]] = value
    (line,) = lines_of(document)
    assert line.startswith(f"{key}: ")


TEXT = yaml.safe_dump(DEFAULT, sort_keys=False)
FAULTS = {"600 um": "600", "5": "500", "1500 us": "$(touch PWNED)", "1e-8 kg": "'{workflow}'"}


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        (TEXT, FAULTS),
        pytest.param(TEXT.replace("mass:", "spring:", 1), ["line 11"], marks=pytest.mark.long),
        pytest.param(f"{TEXT}__use_yte__: true", ["__use_yte__ is"], marks=pytest.mark.long),
    ],
)
def test_the_workflow_prints_a_line_for_each_fault(root, tmp_path, text, faults):
    for old in FAULTS if faults is FAULTS else ():
        text = text.replace(f": {old}\n", f": {FAULTS[old]}\n", 1)
    (tmp_path / "bad.yaml").write_text(text)
    code, output = snakemake(root, tmp_path, tmp_path / "bad.yaml", check=False)
    lines = output.splitlines()
    assert code != 0 and not any("Traceback" in line for line in lines), lines
    names = ("device.beam.span", "model.elements", "sweep.horizon", "device.mass")
    for name in names if faults is FAULTS else faults:
        assert sum(name in line for line in lines) == 1, lines
    assert {path.name for path in tmp_path.iterdir()} <= {"bad.yaml", ".snakemake"}
