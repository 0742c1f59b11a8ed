"""The pages for use say what the code does, and make a site."""

import os
import re
import runpy
import subprocess
import sys

import numpy as np
import pytest
import yaml

import snapmap
from snapmap.config.study import load_config
from snapmap.io.netcdf import write


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def test_the_reference_is_what_the_docstrings_say(root):
    page = (root / "docs" / "reference.md").read_text(encoding="utf-8")
    assert runpy.run_path(root / "docs" / "make_reference.py")["reference"]() == page


def test_the_tutorial_writes_the_config_that_there_is(root):
    written = "\n".join(blocks(root / "docs" / "tutorial.md", "yaml"))
    assert written == (root / "config" / "sensor.yaml").read_text(encoding="utf-8")
    load_config(yaml.safe_load(written))


def test_the_gallery_has_every_figure(root):
    table = re.findall(r"^\| (`.*?) \|", (root / "docs" / "figures.md").read_text(), re.M)
    figures = {name for cell in table for name in re.findall(r"`(\w+\*?)`", cell)}
    shown = set(re.findall(r"`(\w+\*?)`", (root / "docs" / "gallery.md").read_text()))
    assert {"maps", "yield", "accuracy"} <= figures - {"thresholds_*", "accuracy_quick"} <= shown


def test_the_demands_of_the_recipe_are_read(root):
    asked = yaml.safe_load(blocks(root / "docs" / "recipes.md", "yaml")[0])
    whole = yaml.safe_load((root / "config" / "sensor.yaml").read_text(encoding="utf-8"))
    device = whole["device"] | asked["device"]
    study = load_config(whole | {"device": device, "requirements": asked["requirements"]})
    assert study.device.stop_away == 8.0
    assert [one.snaps for one in study.requirements] == [True, False, False, False]
    assert study.vibrations[0].duration == 180.0


def test_the_example_of_the_first_screen_runs(root, tmp_path, monkeypatch):
    lines = (root / "README.md").read_text().splitlines()[:45]
    (code,) = re.findall(r"^```python\n(.*?)^```", "\n".join(lines), re.M | re.S)
    (tmp_path / "config").symlink_to(root / "config")
    monkeypatch.chdir(tmp_path)
    exec(code, found := {})
    said = re.search(r"# (.*?) and (.*?), \+- (.*?) and (.*)", code).groups()
    edge = found["edge"]
    values = np.concatenate([edge.N_first.values.ravel(), edge.N_error.values.ravel()])
    assert tuple(f"{value:.1f}" for value in values) == said
    assert (tmp_path / "map.pdf").exists()


@pytest.mark.long
def test_the_recipes_in_python_run(root, handout, tmp_path):
    (tmp_path / "config").symlink_to(root / "config")
    (tmp_path / "results").mkdir()
    cells = {"N": [900.0, 1100.0], "f0": [500.0, 1500.0], "C": [25.0, 200.0]}
    write(snapmap.sweep(handout, **cells), tmp_path / "results" / "cube.nc")
    pages = root / "README.md", root / "docs" / "recipes.md"
    code = "\n".join(block for page in pages for block in blocks(page, "python"))
    path = {"PYTHONPATH": str(root / "workflow" / "scripts"), "MPLBACKEND": "agg"}
    subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=os.environ | path, check=True)
    assert (tmp_path / "map.pdf").exists() and (tmp_path / "mine.pdf").exists()


def test_the_site_is_made_without_a_warning_and_asks_no_other_host(root, tmp_path):
    pytest.importorskip("furo", reason="the packages of requirements-docs.lock are not installed")
    build = [sys.executable, "-m", "sphinx", "-qEW", "--keep-going", "-c", root / "docs" / "site"]
    made = subprocess.run(
        [*build, "-d", tmp_path / "read", root, tmp_path / "site"], capture_output=True, text=True
    )
    assert made.returncode == 0, made.stderr
    pages = {path.stem: path.read_text() for path in (tmp_path / "site").rglob("*.html")}
    assert {"README", "tutorial", "theory", "reference", "gallery"} <= set(pages)
    assert pages["theory"].count("<math") > 100
    asked = re.compile(r"<(?:script|link|img)[^>]*(?:src|href)=\"(?:https?:)?//")
    assert not [stem for stem, page in pages.items() if asked.search(page)]
