"""The pages for use and the notebook say what the code does; the pages make a site."""

import doctest
import re
import runpy
import shutil
import subprocess
import sys
from base64 import b64decode
from pathlib import Path
from types import SimpleNamespace

import matplotlib as mpl
import matplotlib.pyplot as plt
import nbformat
import numpy as np
import pytest
import xarray as xr
from small_studies import SHOTS, cases_of
from small_workflow import snakemake

import snapmap
from snapmap.applications import attached
from snapmap.applications.requirements.verdict import read_verdicts
from snapmap.beam.modal import natural_frequency
from snapmap.numerics.statistics import percents
from snapmap.study.variables import write

PAGES = "recipes", "own-physics", "tutorial", "figures", "theory", "thresholds", "pulses"
IN_PYTHON = *PAGES, *(f"applications/{name}" for name in attached())
"""Pages whose numbers are those of the Python in them."""


def blocks(text, language):
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.M | re.S)


def test_the_tutorial_writes_the_config_that_there_is(root):
    tutorial = (root / "docs" / "tutorial.md").read_text(encoding="utf-8")
    sensor = (root / "config" / "sensor.yaml").read_text(encoding="utf-8")
    assert "\n".join(blocks(tutorial, "yaml")) == sensor


def test_the_equilibria_on_the_page_of_theory_are_those_of_its_formulas(root, handout):
    """Midpoint, energy and N over N_1, by (16) to (18); the frequency is that of the package."""
    page, beam, Q = (root / "docs" / "theory.md").read_text(encoding="utf-8"), handout.beam, 5.0
    unit = np.pi**4 * beam.youngs_modulus * beam.depth * beam.thickness**3 / 12 * beam.rise**2
    unit /= beam.span**3
    assert f"$E_1={unit:.3f}$ pJ" in page
    half = 0.5 * np.sqrt(1 - 16 / (3 * Q**2))
    r = 0.5 * np.sqrt(8 / 9 - 16 / (3 * Q**2))
    assert f"$r=\\pm{r:.5f}$" in page
    for s, r2, digits in ((-1 / 3, r**2, None), (-0.5 - half, 0.0, 4), (-0.5 + half, 0.0, 3)):
        load = 3 * Q**2 / 4 * (1 - s**2 - 4 * r2)
        energy = unit * ((1 - s) ** 2 + 16 * r2 + 2 / (3 * Q**2) * load**2)
        shown = "4" if digits is None else f"{load:.{digits}f}"
        assert f"| ${beam.rise * s:.5f}$ | {energy:.3f} | {shown} |" in page
    assert f"vibrates at {1e3 * natural_frequency(beam) / (2 * np.pi):.1f} kHz" in page


def test_the_example_of_the_first_screen_runs(root, tmp_path, monkeypatch):
    (code,) = blocks("\n".join((root / "README.md").read_text().splitlines()[:45]), "python")
    (tmp_path / "config").symlink_to(root / "config")
    monkeypatch.chdir(tmp_path)
    exec(code, names := {})
    said = re.search(r"# (.*?) and (.*?), \+- (.*?) and (.*)", code).groups()
    edge = names["edge"]
    values = [*edge.N_first.values.ravel(), *edge.N_error.values.ravel()]
    assert tuple(f"{value:.1f}" for value in values) == said
    assert (tmp_path / "map.pdf").exists()


def outputs_of(notebook):
    """What the code cells of a notebook show: their numbers, texts and kinds of output."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    return [(cell.execution_count, [*map(hide_picture, cell.outputs)]) for cell in cells]


def hide_picture(output):
    data = dict(output.get("data", {}))
    is_png = b64decode(data.pop("image/png", "")).startswith(b"\x89PNG")
    return output.get("text"), data, is_png


def test_the_notebook_stores_what_it_gives_today(root, tmp_path, monkeypatch):
    """Texts and numbers; pictures in kind. Figures name their axes; drag and thresholds hold."""
    plt.switch_backend("agg")
    plt.close("all")
    monkeypatch.chdir(tmp_path)
    path = root / "examples" / "first_steps.ipynb"
    stored, today, names = nbformat.read(path, 4), nbformat.read(path, 4), {}
    axes = runpy.run_path(root / "docs" / "make_notebook.py")["run"](today, names)
    shown = outputs_of(stored)
    assert shown == outputs_of(today)
    assert [number for number, _ in shown] == [*range(1, len(shown) + 1)]
    assert sum(is_png for _, cell in shown for *_, is_png in cell) == len(axes) == 3
    assert all(ax.get_xlabel() and ax.get_ylabel() for ax in axes)
    assert path.stat().st_size < 300_000 and "stderr" not in path.read_text(encoding="utf-8")
    run, edges, own = names["run"], names["found"].squeeze(), names["own"]
    assert snapmap.words(run.outcome) == "snapped" and run.t_snap == pytest.approx(434.89, abs=0.02)
    assert (edges.N_error < 0.01 * edges.N_first).all()
    free, dragged = own.t_snap.notnull().mean("N").values
    assert (dragged <= free).all() and dragged.sum() < free.sum()  # drag asks for more N
    assert own.reproduced.mean() > 0.98
    assert own.t_snap.sel(C=0.0).where(edges.N_first * 0.9 > own.N).isnull().all()


def with_universal_file(monkeypatch, lasts, time, acceleration, types):
    """Have `pyuff` read a file of such sets, of which those of type 58 are records."""
    units = {"abscissa_axis_units_lab": f"{time} ", "ordinate_axis_units_lab": acceleration}
    record = {"x": np.linspace(0.0, lasts, 5), "data": np.array([0.0, 7.0, 9.0, 7.0, 0.0]) + 0j}
    sets = [units | record if kind == 58 else {"type": kind} for kind in types]
    file = SimpleNamespace(read_sets=sets.__getitem__, get_set_types=lambda: np.array(types))
    monkeypatch.setitem(sys.modules, "pyuff", SimpleNamespace(UFF=lambda path: file))


@pytest.mark.parametrize(("lasts", "time", "acceleration", "types", "peak"), cases_of(__file__))
def test_a_universal_file_becomes_a_record_in_the_units_that_it_names(
    root, tmp_path, monkeypatch, lasts, time, acceleration, types, peak
):
    monkeypatch.chdir(tmp_path)
    with_universal_file(monkeypatch, lasts, time, acceleration, types)
    text = (root / "docs" / "recipes.md").read_text(encoding="utf-8")
    (recipe,) = (block for block in blocks(text, "python") if "pyuff" in block)
    exec(recipe, {})
    if peak is None:
        with pytest.raises(ValueError, match="unit 'NONE' is unknown; write "):
            snapmap.read_pulse("shock.csv")
        return
    pulse = snapmap.read_pulse("shock.csv")
    assert (pulse.duration, pulse.peak) == (pytest.approx(1000.0), pytest.approx(peak))


@pytest.mark.long
@pytest.mark.parametrize("page", ["README.md", *(f"docs/{name}.md" for name in IN_PYTHON)])
def test_the_recipes_in_python_run(root, handout, tmp_path, monkeypatch, page):
    """And give what the page says; a number that has moved is printed beside the one there."""
    monkeypatch.chdir(tmp_path)
    for name in ("config", "examples", "config/sensor.yaml"):
        (tmp_path / Path(name).name).symlink_to(root / name)
    (tmp_path / "results").mkdir()
    rows = {"f0": [500.0, 1500.0], "C": [25.0, 200.0]}
    write(snapmap.sweep(handout, [900.0, 1100.0], **rows), tmp_path / "results" / "cube.nc")
    write(snapmap.threshold(handout, **rows), tmp_path / "results" / "threshold.nc")
    (tmp_path / "shots.csv").write_text(SHOTS)
    with_universal_file(monkeypatch, 1e-3, "s", "g", [58])
    known = {"snapmap": snapmap, "device": handout, "shots": "shots.csv"}
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    text = (root / page).read_text(encoding="utf-8")
    if not shutil.which("latex"):
        text = text.replace('"text.usetex": True', '"text.usetex": False')
    for block in blocks(text, "python"):
        if block.startswith(">>>"):
            example = doctest.DocTestParser().get_doctest(block, known, page, page, 0)
            runner.run(example, clear_globs=False)
            known = example.globs
        else:
            with mpl.rc_context():
                exec(block, known)
    assert not runner.failures


@pytest.mark.long
def test_the_tutorial_says_what_its_study_gives(root, tmp_path):
    """But for the data sheet, the figures and the page, which take most of the time."""
    page = (root / "docs" / "tutorial.md").read_text(encoding="utf-8")
    words, results = " ".join(page.split()), tmp_path / "results"
    named = ["thresholds.csv", "cube.nc", "requirements.csv", "tolerance.nc"]
    config = root / "config" / "sensor.yaml"
    snakemake(root, tmp_path, config, *(f"results/{name}" for name in named))
    for rule in ("find_threshold", "collect", "check_requirements"):
        log = (results / "logs" / f"{rule}.log").read_text(encoding="utf-8")
        assert log.splitlines()[-1] in page
    with xr.open_dataset(results / "threshold.nc") as edges:
        row = edges.isel(C=0).sel(f0=1e3 / 1.003, method="nearest")
        assert f"{row.N_first.item():.1f} ± {row.N_error.item():.1f} g." in words
        same = int((edges.N_latched == edges.N_first).sum())
        assert f"`N_first` itself in {same} of {edges.N_first.size} thresholds" in words
    crash, _, drop, _ = (each.margin for each in read_verdicts(results / "requirements.csv"))
    assert f"a threshold at {crash:.2f} times its amplitude, the drop at {drop:.2f}" in words
    with xr.open_dataset(results / "tolerance.nc") as made:
        row = made.isel(C=0)
        trips, whole, low = map(percents, (row.share_meeting[0], row["yield"], row.yield_bound[0]))
        assert f"the crash trips {trips} (C = 5), and {whole} meet" in words
        assert f"at least {low} at 95 % confidence" in words


def test_the_site_is_made_without_a_warning_and_asks_no_other_host(root, tmp_path):
    pytest.importorskip("furo", reason="packages of locks/requirements-docs.lock are missing")
    build = [sys.executable, "-m", "sphinx", "-qEW", "--keep-going", "-c", root / "docs" / "site"]
    build += ["-d", tmp_path / "read", root, tmp_path / "site"]
    made = subprocess.run(build, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    pages = {path.stem: path.read_text() for path in (tmp_path / "site").rglob("*.html")}
    assert {"README", "tutorial", "theory", "reference", "figures", "page"} <= set(pages)
    assert pages["theory"].count("<math") > 100
    asked = re.compile(r"<(?:script|link|img)[^>]*(?:src|href)=\"(?:https?:)?//")
    assert not [stem for stem, page in pages.items() if asked.search(page)]
