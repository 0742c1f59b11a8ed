"""Bad input at scale: a config gives a study, or clear single lines; its text is never run."""

import copy
import datetime
import math
import random
import re
import warnings
from functools import reduce
from operator import getitem

import pytest
import yaml
from small_studies import EVERY_PRODUCT, SHOTS, cases_of, changed
from small_workflow import snakemake

from snapmap.applications.whole import load_config
from snapmap.files.text import describe
from snapmap.values.faults import Faults
from snapmap.workflow.plan import make_plan

CASES = cases_of(__file__)
DEFAULT = CASES["config"]
OPTIONAL, HOSTILE = {*CASES["optional"]}, CASES["hostile"]
NO_VALUE = [
    *(None, {}, [], [3, None], {"a": 1}, math.nan, math.inf, b"\0", "word ", "x" * 300),
    *(datetime.date(2026, 1, 1), *HOSTILE),
]
NO_QUANTITY = [*NO_VALUE, *CASES["no quantity"]]
NO_NUMBER = [*NO_VALUE, "1 g", "1,5", "0x10", True, "nan", 1e300, "1e999", -2e15]
NO_COUNT = [*NO_VALUE, 0, -3, 10**7, True]
NO_WORD, NO_SHARE = [*NO_VALUE, True, 0.5, -3, "1e3"], [*NO_VALUE, 0.0, -1.0, 1.0, "1", "2 %"]
BAD = {
    **{"elements": NO_COUNT, "points": [*NO_COUNT, 2.5], "N": NO_NUMBER, "name": NO_WORD},
    **{"spacing": NO_WORD, "until": NO_WORD, "repeat": [*NO_VALUE, 1, "yes"]},
    **{"energy_tolerance": NO_SHARE, "threshold_tolerance": NO_SHARE},
}
"""What a key or what stands below it cannot be; of all others NO_QUANTITY."""


def leaves(part, at=()):
    """Paths of every value that is no mapping and no list."""
    if not isinstance(part, dict | list):
        yield at
        return
    for key in part if isinstance(part, dict) else range(len(part)):
        yield from leaves(part[key], (*at, key))


def name_of(path):
    name = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)
    return name.removeprefix(".")


LATE = re.compile(r"histories\[\d+\]\.(C|f0): missing; ")
"""Told only where all else is right, as the study may give it."""
LEAVES = list(leaves(DEFAULT))
SECTIONS = sorted({path[:-1] for path in LEAVES if path[:-1]}, key=str)
NAMED = [path for path in LEAVES if isinstance(path[-1], str)]


def set_badly(rng, section, path):
    bad = next((BAD[key] for key in reversed(path) if key in BAD), NO_QUANTITY)
    section[path[-1]] = value = rng.choice(bad)
    return [(name_of(path), describe(value))]


def delete(rng, section, path):
    del section[path[-1]]
    return [(name_of(path), "missing; write ")] if path[-1] not in OPTIONAL else []


def rename(rng, section, path):
    new = rng.choice([f"{path[-1].upper()}s", f" {path[-1]}", 1, None, "é" * 300])
    section[new] = section[path[-1]]
    return [*delete(rng, section, path), (name_of(path[:-1]), "unknown key; ")]


def flatten(rng, section, path):
    section[path[-1]] = value = rng.choice(["text", 3, True, None, math.nan])
    return [(name_of(path), f"{describe(value)} is not a")]


DAMAGES = [*[(path, set_badly) for path in LEAVES] * 4, *[(path, flatten) for path in SECTIONS]]
DAMAGES += [(path, damage) for path in NAMED for damage in (delete, rename)]


def lines_of(document):
    """The faults of a document, each a clear single line; empty if it gives slabs."""
    try:
        with warnings.catch_warnings(action="error"):  # of what a fault leaves out
            study = load_config(document)
        make_plan(study)
    except Faults as error:
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
            reduce(getitem, path[:-1], document)[path[-1]] = text
        assert len(lines_of(document)) == len(LEAVES)
    assert not [*tmp_path.iterdir()]


@pytest.mark.parametrize("examples", [100, pytest.param(5000, marks=pytest.mark.long)])
def test_every_fault_is_one_line_naming_key_and_value(examples):
    """Of one to three at once, none of which hides another; no line is on anything else."""
    rng = random.Random(examples)
    for _ in range(examples):
        document, damaged, places = copy.deepcopy(DEFAULT), [], []
        for path, damage in rng.sample(DAMAGES, rng.randint(1, 3)):
            if not any(path[: len(at)] == at[: len(path)] for at in damaged):
                damaged.append(path)
                places += damage(rng, reduce(getitem, path[:-1], document), path)
        lines = [line for line in lines_of(document) if not LATE.match(line)]
        places = [place for place in places if not LATE.match(": ".join(place))]
        for name, complaint in places:
            assert any(line.startswith(name) and complaint in line for line in lines), lines
        assert len({*places}) <= len(lines) <= len(places), lines


def test_what_is_no_value_is_one_line_wherever_it_stands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shots.csv").write_text(SHOTS)
    whole, rng = yaml.safe_load(EVERY_PRODUCT), random.Random(1)
    for path in leaves(whole):
        document = copy.deepcopy(whole)
        reduce(getitem, path[:-1], document)[path[-1]] = rng.choice(NO_VALUE[:8])
        (line,) = lines_of(document)
        assert line.startswith(name_of(path if isinstance(path[-1], str) else path[:-1]))


@pytest.mark.parametrize(("key", "values"), CASES["absurd"])
def test_absurd_values_are_refused(key, values):
    (line,) = lines_of(changed(DEFAULT, **values))
    assert line.startswith(f"{key}: ")


FAULTS = {"600 um": "600", "5": "500", "1500 us": "$(touch PWNED)", "1e-8 kg": "'{workflow}'"}


def test_the_workflow_prints_a_line_for_each_fault(root, tmp_path):
    text = yaml.safe_dump(DEFAULT, sort_keys=False)
    for old, new in FAULTS.items():
        text = text.replace(f": {old}\n", f": {new}\n", 1)
    (tmp_path / "bad.yaml").write_text(text)
    code, output = snakemake(root, tmp_path, tmp_path / "bad.yaml", check=False)
    lines = output.splitlines()
    assert code != 0 and not any("Traceback" in line for line in lines), lines
    for name in ("device.beam.span", "model.elements", "run.horizon", "device.mass"):
        assert sum(name in line for line in lines) == 1, lines
    assert {path.name for path in tmp_path.iterdir()} <= {"bad.yaml", ".snakemake"}
