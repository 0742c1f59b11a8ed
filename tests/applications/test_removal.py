"""Whoever deletes the folder of an application and its line deletes the capability, and no more."""

import re
import shutil
import subprocess
import sys
from inspect import getmodule, unwrap

import pytest
import yaml
from small_studies import TINY
from small_workflow import snakemake

import snapmap
from snapmap.applications import attached

FIRST = {name: getmodule(type(part)).__doc__.splitlines()[0] for name, part in attached().items()}
NAMED = {name: first.partition("Imports:")[2] for name, first in FIRST.items()}
IMPORTS = {name: {*re.findall(r"\w+", words)} for name, words in NAMED.items()}
"""What the first line of each application says that it imports; test_project.py checks it."""
INNER = [name for name in IMPORTS if name in set().union(*IMPORTS.values())]
LEAVES = [name for name in IMPORTS if name not in INNER]


def with_dependents(names):
    """These applications and all that import them."""
    more = {name for name, imported in IMPORTS.items() if imported & {*names}}
    return {*names} if more <= {*names} else with_dependents(more.union(names))


def names_of(folders):
    """The public names whose home is in one of these folders."""
    homes = {name: unwrap(getattr(snapmap, name)).__module__ for name in snapmap.__all__}
    parts = [f"snapmap.applications.{folder}." for folder in folders]
    return {name for name, home in homes.items() if home.startswith((*parts,))}


@pytest.fixture
def clone(root, tmp_path):
    folder, ignored = tmp_path / "clone", shutil.ignore_patterns("__pycache__")
    for name in ("workflow", "profiles"):
        shutil.copytree(root / name, folder / name, ignore=ignored)
    shutil.copy(root / "Snakefile", folder)
    return folder


def study_without(clone, names, path):
    """Delete applications with all that import them; write a small study that the rest can make."""
    applications = clone / "workflow" / "scripts" / "snapmap" / "applications"
    listing, document = applications / "__init__.py", yaml.safe_load(TINY)
    text = listing.read_text(encoding="utf-8")
    for gone in with_dependents(names):
        shutil.rmtree(applications / gone)
        assert f'    "{gone}",\n' in text
        text = text.replace(f'    "{gone}",\n', "")
        document.pop(gone, None)
    listing.write_text(text, encoding="utf-8")
    path.write_text(yaml.safe_dump(document), encoding="utf-8")


@pytest.mark.parametrize("names", [LEAVES, *([name] for name in INNER)], ids=" ".join)
def test_the_rest_is_planned_without_applications(clone, tmp_path, names, monkeypatch):
    """Without all that nothing imports, at once, and without each of the others."""
    monkeypatch.delenv("PYTHONPATH", raising=False)
    study_without(clone, names, tmp_path / "study.yaml")
    command = [sys.executable, "-c", "import snapmap; print(*dir(snapmap))"]
    told = subprocess.check_output(command, cwd=clone / "workflow" / "scripts", text=True)
    assert {*dir(snapmap)} - {*told.split()} == names_of(with_dependents(names))
    _, output = snakemake(clone, tmp_path / "run", tmp_path / "study.yaml", "--dry-run")
    assert "find_threshold" in output and "draw_study" in output
