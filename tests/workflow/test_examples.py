"""Each example config, of the folder and of the documents, runs in small, to the end."""

import re
import shutil
from pathlib import Path

import pytest
import yaml
from products import assert_whole
from small_studies import SHOTS
from small_workflow import snakemake

from snapmap.applications.whole import load_config
from snapmap.config.yaml_file import read_document

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
