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
OF_MASS = "spring", "contact", "gravity"
"""What a beam alone that is pushed does not have."""
APART = "docs/limits.md", "docs/tutorial.md"
"""Pages with sections in which something is left out, or with those of a file of `config`."""
ROOT = Path(__file__).parents[2]


def small(document):
    """The config with few values on each axis, few devices, and a cheap model."""
    sweep = {key: fewer(value, 3 if key == "N" else 2) for key, value in document["sweep"].items()}
    named = document["model"]
    model = named | {"elements": 3} if named["name"] == "reference" else CHEAP
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
    document = read_document(ROOT / "config" / "config.yaml")
    whole = document | sections
    for name in ("device", "sweep", "run"):
        whole[name] = document[name] | sections.get(name, {})
    if "duration" in whole["sweep"] or "file" in whole.get("pulse", {}):
        del whole["sweep"]["f0"]
    if whole["device"]["mass"] == "none":
        for key in OF_MASS:
            del whole["device"][key]
        del whole["sweep"]["C"]
    return whole


def examples():
    """Configs by where they stand: files of `config`, and sections on pages."""
    found = {path.name: read_document(path) for path in sorted((ROOT / "config").glob("*.yaml"))}
    for page in sorted((ROOT / "docs").rglob("*.md")):
        name, text = page.relative_to(ROOT).as_posix(), page.read_text(encoding="utf-8")
        parts = [] if name in APART else re.findall(r"^```yaml\n(.*?)^```", text, re.M | re.S)
        for place, part in enumerate(parts):
            found[f"{name}, {place}"] = merged(yaml.safe_load(part))
    return found


EXAMPLES = examples()


@pytest.mark.long
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs_whole(root, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shots.csv").write_text(SHOTS)
    shutil.copy(root / "config" / "half_sine.csv", tmp_path / "shock.csv")
    shutil.copy(root / "examples" / "laws" / "cubic_damping.py", tmp_path / "mylaws.py")
    (config := tmp_path / "mine.yaml").write_text(yaml.safe_dump(small(EXAMPLES[name])))
    snakemake(root, tmp_path, config)
    assert_whole(tmp_path, load_config(read_document(config)))
