"""The pages for use say what the code does, and make a site."""

import doctest
import inspect
import re
import runpy
import subprocess
import sys
from ast import literal_eval
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from small_studies import SHOTS

import snapmap
from snapmap.applications import attached
from snapmap.applications.requirements import shocks_of
from snapmap.applications.requirements.corners import read_verdicts
from snapmap.config.study import load_config
from snapmap.device.device import VALUES
from snapmap.numerics.statistics import percents
from snapmap.public import options_of
from snapmap.pulse.pulse import DIRECTIONS, SHAPES
from snapmap.solver.settings import Settings
from snapmap.study.netcdf import write

PAGES = "recipes", "own-physics", "tutorial", "figures"
SHARED_OPTIONS = {
    *("horizon", "energy_tolerance", "threads", "start", "until", "repeat"),
    *("pulse", "direction", "skip"),
}
IN_PYTHON = *PAGES, *(f"applications/{name}" for name in attached())
"""Pages whose numbers are those of the Python in them."""


def blocks(page, language):
    return re.findall(rf"^```{language}\n(.*?)^```", page.read_text(encoding="utf-8"), re.M | re.S)


def test_the_reference_is_what_the_docstrings_say(root):
    page = (root / "docs" / "reference.md").read_text(encoding="utf-8")
    assert runpy.run_path(root / "docs" / "make_reference.py")["reference"]() == page


def test_the_options_of_each_docstring_are_those_it_takes():
    named = {name: getattr(snapmap, name) for name in snapmap.__all__}
    for name, function in named.items():
        options = {key for key in options_of(inspect.unwrap(function)) if key not in VALUES}
        line = re.search(r" options: (.*?)\n    (?! )", function.__doc__ + "    ", re.S)
        words = set(re.findall(r"\w+", line[1] if line else "")) & SHARED_OPTIONS
        assert words == options, name


def test_the_defaults_on_the_page_are_those_of_the_code(root):
    page = (root / "docs" / "reference.md").read_text(encoding="utf-8")
    listed = dict(re.findall(r"^- `(\w+) = (.+?)`:", page, re.M))
    defaults = {key: literal_eval(value) for key, value in listed.items()}
    assert Settings._field_defaults.items() <= defaults.items()
    assert defaults["model"] == inspect.signature(snapmap.threshold).parameters["model"].default
    assert (defaults["pulse"], defaults["direction"]) == (
        next(iter(SHAPES)),
        next(iter(DIRECTIONS)),
    )


def test_the_tutorial_writes_the_config_that_there_is(root):
    written = "\n".join(blocks(root / "docs" / "tutorial.md", "yaml"))
    assert written == (root / "config" / "sensor.yaml").read_text(encoding="utf-8")
    load_config(yaml.safe_load(written))


def test_the_demands_of_the_recipe_are_read(root):
    asked = yaml.safe_load(blocks(root / "docs" / "recipes.md", "yaml")[0])
    whole = yaml.safe_load((root / "config" / "sensor.yaml").read_text(encoding="utf-8"))
    device = whole["device"] | asked["device"]
    study = load_config(whole | {"device": device, "requirements": asked["requirements"]})
    assert study.device.stop_away == 8.0
    assert [one["snaps"] for one in shocks_of(study)] == [True, False, False, False]
    assert [
        one.values["duration"] for one in study.requests["requirements"] if "psd" in one.values
    ] == [180.0]


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
@pytest.mark.parametrize("page", ["README.md", *(f"docs/{name}.md" for name in IN_PYTHON)])
def test_the_recipes_in_python_run(root, handout, tmp_path, monkeypatch, page):
    """And give what the page says; a number that has moved is printed beside the one there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config").symlink_to(root / "config")
    (tmp_path / "examples").symlink_to(root / "examples")
    (tmp_path / "sensor.yaml").symlink_to(root / "config" / "sensor.yaml")
    (tmp_path / "results").mkdir()
    cells = {"N": [900.0, 1100.0], "f0": [500.0, 1500.0], "C": [25.0, 200.0]}
    write(snapmap.sweep(handout, **cells), tmp_path / "results" / "cube.nc")
    found = snapmap.threshold(handout, cells["f0"], cells["C"])
    write(found, tmp_path / "results" / "threshold.nc")
    (tmp_path / "shots.csv").write_text(SHOTS)
    record = {"x": np.linspace(0.0, 1e-3, 5), "data": np.array([0.0, 7.0, 9.0, 7.0, 0.0]) + 0j}
    file = SimpleNamespace(read_sets=lambda number: record)
    monkeypatch.setitem(sys.modules, "pyuff", SimpleNamespace(UFF=lambda path: file))
    known = {"snapmap": snapmap, "device": handout, "shots": "shots.csv"}
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    for block in blocks(root / page, "python"):
        if block.startswith(">>>"):
            told = doctest.DocTestParser().get_doctest(block, known, page, page, 0)
            runner.run(told, clear_globs=False)
            known = told.globs
        else:
            exec(block, known)
    assert not runner.failures
    if page == "docs/recipes.md":
        assert snapmap.read_pulse("shock.csv").duration == pytest.approx(1000.0)


@pytest.mark.long
def test_the_tutorial_says_what_its_study_gives(root, tmp_path):
    """But for the data sheet, the figures and the page, which take most of the time."""
    page = (root / "docs" / "tutorial.md").read_text(encoding="utf-8")
    named = ["thresholds.csv", "cube.nc", "requirements.csv", "tolerance.nc"]
    run = ["snakemake", *(f"results/{name}" for name in named), "--cores", "2"]
    run += ["--snakefile", root / "Snakefile", "--directory", tmp_path]
    run += ["--configfile", root / "config" / "sensor.yaml"]
    subprocess.run(run, check=True, capture_output=True)
    logs = tmp_path / "results" / "logs"
    for rule in ("find_threshold", "simulate_all", "check_requirements"):
        assert (logs / f"{rule}.log").read_text(encoding="utf-8").splitlines()[-1] in page
    words = " ".join(page.split())
    with xr.open_dataset(tmp_path / "results" / "threshold.nc") as found:
        one = found.isel(C=0).sel(f0=1e3 / 1.003, method="nearest")
        assert f"{one.N_first.item():.1f} ± {one.N_error.item():.1f} g." in words
        same = int((found.N_latched == found.N_first).sum())
        assert f"`N_first` itself in {same} of {found.N_first.size} rows" in words
    margins = [row["margin"] for row in read_verdicts(tmp_path / "results" / "requirements.csv")]
    crash, _, drop, _ = margins
    assert f"a threshold at {crash:.2f} times its amplitude, the drop at {drop:.2f}" in words
    with xr.open_dataset(tmp_path / "results" / "tolerance.nc") as made:
        one = made.isel(C=0)
        trips, whole, low = one.share_meeting[0], one["yield"], one.yield_bound[0]
        assert f"the crash trips {percents(trips)} (C = 5), and {percents(whole)} meet" in words
        assert f"at least {percents(low)} at 95 % confidence" in words


def test_the_site_is_made_without_a_warning_and_asks_no_other_host(root, tmp_path):
    pytest.importorskip(
        "furo", reason="the packages of locks/requirements-docs.lock are not installed"
    )
    build = [sys.executable, "-m", "sphinx", "-qEW", "--keep-going", "-c", root / "docs" / "site"]
    made = subprocess.run(
        [*build, "-d", tmp_path / "read", root, tmp_path / "site"], capture_output=True, text=True
    )
    assert made.returncode == 0, made.stderr
    pages = {path.stem: path.read_text() for path in (tmp_path / "site").rglob("*.html")}
    assert {"README", "tutorial", "theory", "reference", "figures", "page"} <= set(pages)
    assert pages["theory"].count("<math") > 100
    asked = re.compile(r"<(?:script|link|img)[^>]*(?:src|href)=\"(?:https?:)?//")
    assert not [stem for stem, page in pages.items() if asked.search(page)]
