"""Whoever deletes the folder of an application and its line deletes the capability, and no more."""

import re
import shutil

import pytest
import yaml
from small_studies import TINY
from small_workflow import snakemake

from snapmap.applications import attached, key_of


def dependents(name):
    """The application and those whose first line says that they import it."""
    gone = {name}
    while True:
        lines = {other: one.__doc__.partition("\n")[0] for other, one in attached().items()}
        named = {
            other: re.findall(r"\w+", line.partition("Imports:")[2])
            for other, line in lines.items()
        }
        more = {other for other in named if gone & {*named[other]}} - gone
        if not more:
            return gone
        gone |= more


@pytest.fixture
def clone(root, tmp_path):
    folder = tmp_path / "clone"
    shutil.copytree(
        root / "workflow", folder / "workflow", ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copytree(root / "profiles", folder / "profiles")
    shutil.copy(root / "Snakefile", folder)
    return folder


def study_without(clone, name, path):
    """Delete an application with its dependents; write a small study that the rest can make."""
    applications = clone / "workflow" / "scripts" / "snapmap" / "applications"
    listing, document = applications / "__init__.py", yaml.safe_load(TINY)
    text = listing.read_text(encoding="utf-8")
    for gone in dependents(name):
        shutil.rmtree(applications / gone)
        assert f'    "{gone}",\n' in text
        text = text.replace(f'    "{gone}",\n', "")
        document.pop(key_of(gone, attached()[gone]), None)
    listing.write_text(text, encoding="utf-8")
    path.write_text(yaml.safe_dump(document), encoding="utf-8")


@pytest.mark.parametrize("name", attached())
def test_the_rest_is_planned_without_an_application(clone, tmp_path, name, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    study_without(clone, name, tmp_path / "study.yaml")
    _, output = snakemake(clone, tmp_path / "run", tmp_path / "study.yaml", "--dry-run")
    assert "find_threshold" in output and "draw_study" in output


@pytest.mark.long
@pytest.mark.parametrize("name", attached())
def test_the_rest_runs_without_an_application(clone, tmp_path, name, monkeypatch):
    monkeypatch.delenv("PYTHONPATH", raising=False)
    study_without(clone, name, tmp_path / "study.yaml")
    snakemake(clone, tmp_path / "run", tmp_path / "study.yaml")
    assert (tmp_path / "run" / "results" / "figures" / "thresholds.png").exists()
