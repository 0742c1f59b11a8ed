"""Each example config, of the folder and of the documents, runs in small, to the end."""

import random
import re
import shutil
from pathlib import Path

import pytest
import yaml
from products import assert_whole
from small_studies import EVERY_PRODUCT, SHOTS, changed
from small_workflow import snakemake

from snapmap.applications.whole import load_config
from snapmap.config.yaml_file import read_document
from snapmap.values.faults import Faults

CHEAP = {"name": "cosines", "modes": 3}
ROOT = Path(__file__).parents[2]


def small(document):
    """The config with few values on each axis, few devices, and a cheap model."""
    sweep = {key: fewer(value, 3 if key == "N" else 2) for key, value in document["sweep"].items()}
    named = document["model"]
    cheap = CHEAP | {key: named[key] for key in {"laws"} & {*named}}
    model = named | {"elements": 3} if named["name"] == "reference" else cheap
    changed = {"sweep": sweep, "model": model}
    if "tolerances" in document:
        changed["tolerances"] = document["tolerances"] | {"samples": 8}
    return document | changed


def fewer(values, most):
    if isinstance(values, dict):
        return values | {"points": min(values["points"], most)}
    return values[:most] if isinstance(values, list) else values


def merged(sections):
    """The default config with sections of a page, and without what these exclude."""
    whole = laid_over(read_document(ROOT / "config" / "config.yaml"), sections)
    if "duration" in whole["sweep"] or {"file", "train", "drop"} & {*whole.get("pulse", {})}:
        del whole["sweep"]["f0"]
    if whole["device"]["mass"] == "none":
        for key in ("spring", "contact", "gravity"):  # which a pushed beam does not have
            del whole["device"][key]
        del whole["sweep"]["C"]
    return whole


def laid_over(document, sections):
    """The document with the values of a page, where `...` is what the page leaves out."""
    whole = document | {key: value for key, value in sections.items() if key != "..."}
    for key in {"device", "beam", "sweep", "run"} & {*document} & {*sections}:
        whole[key] = laid_over(document[key], sections[key])
    return whole


def examples():
    """Configs by where they stand: files of `config`, and sections on pages."""
    found = {path.name: read_document(path) for path in sorted((ROOT / "config").glob("*.yaml"))}
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        name, text = page.relative_to(ROOT).as_posix(), page.read_text(encoding="utf-8")
        parts = re.findall(r"^```yaml\n(.*?)^```", text, re.M | re.S)
        for place, part in enumerate(parts if page.stem != "tutorial" else ""):  # a file's parts
            found[f"{name}, {place}"] = merged(yaml.safe_load(part))
    return found


EXAMPLES = examples()


@pytest.fixture
def folder(root, tmp_path, monkeypatch):
    """One with the files that examples name."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shots.csv").write_text(SHOTS)
    (tmp_path / "points.csv").write_text("N,f0 (Hz),name\n812.5,1234.5,a first one\n")
    shutil.copy(root / "config" / "half_sine.csv", tmp_path / "shock.csv")
    shutil.copy(root / "examples" / "laws" / "cubic_damping.py", tmp_path / "mylaws.py")
    return tmp_path


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_is_read(folder, name):
    load_config(EXAMPLES[name])


@pytest.mark.long
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs_whole(root, folder, name):
    (config := folder / "mine.yaml").write_text(yaml.safe_dump(small(EXAMPLES[name])))
    snakemake(root, folder, config)
    assert_whole(folder, load_config(read_document(config)))


RARE = changed(
    yaml.safe_load(EVERY_PRODUCT),
    **{"device__strength_modulus": 10, "device__damper_exponent": 0.7, "skip": True},
    **{"device__modulus_slope": "-63e-6 /K", "marks": "points.csv", "title": "Rare, and whole"},
)
RARE["devices"] = {"first": RARE.pop("device")}
RARE["devices"]["the_other-1"] = changed(RARE["devices"]["first"], beam__thickness="1.85 um")
"""What no example has."""


def crossed(seed):
    """An example, small, with up to three sections of others in place of or beside its own."""
    draws = random.Random(seed)
    wholes = [*map(small, [*EXAMPLES.values(), yaml.safe_load(EVERY_PRODUCT), *[RARE] * 4])]
    own, *others = draws.sample(wholes, 1 + draws.choice([1, 2, 3]))
    for other in others:
        key = draws.choice(sorted({*other} - {"sweep"}))
        left = {"device": "devices", "devices": "device"}.get(key)
        own = {name: own[name] for name in own if name != left} | {key: other[key]}
    is_slow = own["model"]["name"] == "reference"
    return own | {"model": CHEAP} if is_slow else own


def read_or_refused(document):
    """The study of a document, or None where lines refuse it."""
    try:
        return load_config(document)
    except Faults as error:
        assert all(": " in line for line in error.args)


def test_sections_of_several_examples_are_read_together_or_refused_in_lines(folder):
    read = [read_or_refused(crossed(seed)) is not None for seed in range(80)]
    assert sum(read) > 40


@pytest.mark.long
@pytest.mark.parametrize("seed", range(12))
def test_sections_of_several_examples_run_whole_or_are_refused_in_lines(root, folder, seed):
    (config := folder / "mine.yaml").write_text(yaml.safe_dump(crossed(seed)))
    code, output = snakemake(root, folder, config, check=False)
    assert "Traceback" not in output, output
    if code == 0:
        assert_whole(folder, load_config(crossed(seed)))
    else:
        assert not (folder / "results").exists(), output
