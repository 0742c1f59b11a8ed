"""The workflow itself: run, rerun, refuse; in folders and with devices of its own."""

import json
import re
import shutil
import subprocess
import zipfile
from contextlib import contextmanager

import pytest
import xarray as xr
import yaml
from small_studies import EVERY_PRODUCT, SHOTS, TINY
from small_workflow import snakemake

import snapmap
from snapmap.applications import gather, window
from snapmap.config.study import load_config
from snapmap.solver.outcome import FAILED, LATCHED, NEVER, RETURNED, SNAPPED
from snapmap.workflow.made import HEAD, LIST
from snapmap.workflow.products import choose_views

DRAWING = {"draw_study", "draw_histories"}
RULES = {"simulate_all", "find_threshold", "find_stress"}
RULES |= {"simulate_histories"} | DRAWING


def planned_rules(output):
    """The rules that a dry run would execute, with the number of their jobs."""
    table = output.split("Job stats:")[1].split("total")[0] if "Job stats:" in output else ""
    lines = (line.split() for line in table.splitlines())
    return {line[0]: int(line[1]) for line in lines if len(line) == 2 and line[1].isdigit()}


def tracked_state(root):
    skip = {".venv", ".git", ".pytest_cache", ".ruff_cache", ".snakemake", "results", "tests"}
    files = (path for path in root.rglob("*") if path.is_file())
    kept = (path for path in files if not skip & set(path.relative_to(root).parts))
    return sorted((path.as_posix(), path.stat().st_mtime_ns) for path in kept)


@pytest.fixture(scope="module")
def clone(root, tmp_path_factory):
    """A copy of the project's files alone, in a folder whose name has a space."""
    clone = tmp_path_factory.mktemp("a clone") / "snap map"
    ignore = shutil.ignore_patterns(
        ".venv", ".git", "results", "__pycache__", ".snakemake", ".*_cache", ".hypothesis"
    )
    shutil.copytree(root, clone, ignore=ignore)
    return clone


@pytest.fixture(scope="module")
def finished(clone, tmp_path_factory):
    """A finished run: its folder, its config and what it printed."""
    folder = tmp_path_factory.mktemp("a study")
    config = folder / "mine.yaml"
    config.write_text(TINY)
    before = tracked_state(clone)
    _, output = snakemake(clone, folder, config)
    assert tracked_state(clone) == before, "the run wrote into the clone"
    return folder, config, output


def test_the_cube_is_what_python_gives(finished):
    folder, config, output = finished
    with xr.open_dataset(folder / "results" / "cube.nc") as cube:
        axes = {"N": cube.N, "f0": cube.f0, "C": cube.C}
        device = snapmap.load_device(config)
        direct = snapmap.sweep(device, **axes, model="cosines", modes=3, horizon=200.0)
        xr.testing.assert_equal(cube, direct)
        assert cube.outcome.dims == ("C", "f0", "N") and cube.outcome.shape == (2, 2, 8)
        assert cube.outcome.dtype == "int8" and cube.t_snap.dtype == "float64"
        snapped = cube.outcome.isin([SNAPPED, LATCHED, RETURNED])
        assert snapped.any() and not snapped.all() and not (cube.outcome == FAILED).any()
        assert (cube.t_snap.notnull() == snapped).all()
        proven = cube.outcome.isin([NEVER, LATCHED, RETURNED])
        assert (cube.t_settled.notnull() == proven).all()
        assert cube.energy_error.max() <= 1e-3
        document = load_config(yaml.safe_load(TINY)).document()
        assert json.loads(cube.config) == json.loads(direct.config) == document
        assert snapmap.__version__ in cube.code_version and "numba" in cube.packages
    logs = {path.stem: path.read_text() for path in (folder / "results" / "logs").iterdir()}
    assert len(logs) >= len(RULES) and logs["simulate_all"].strip() in output


def test_the_thresholds_are_what_python_gives(finished):
    folder, config, _ = finished
    with xr.open_dataset(folder / "results" / "threshold.nc") as edges:
        axes = {"f0": edges.f0, "C": edges.C, "highest": 3000.0}
        device = snapmap.load_device(config)
        direct = snapmap.threshold(device, **axes, model="cosines", modes=3, horizon=200.0)
        xr.testing.assert_equal(edges, direct)


def test_lint_misses_nothing_but_environments_of_rules(clone):
    """There is one, as the Snakefile itself needs it: config/README.md. From the catalog's file."""
    command = ["snakemake", "--snakefile", clone / "workflow" / "Snakefile", "--lint"]
    command += ["--configfile", clone / "config" / "sensor.yaml"]  # of many products
    done = subprocess.run(command, cwd=clone, capture_output=True, text=True, timeout=120)
    lints = re.findall(r"^    \* (.+):$", done.stdout + done.stderr, re.M)
    assert len(lints) > len(RULES), done.stderr
    assert set(lints) == {"Specify a conda environment or container for each rule."}


def test_the_workflow_is_formatted(clone):
    files = clone / "Snakefile", clone / "workflow" / "Snakefile", clone / "workflow" / "rules"
    command = ["snakefmt", "--check", *files]
    assert subprocess.run(command, timeout=120).returncode == 0


def figures_of(config):
    """Names of the figures of a tiny study."""
    (history,) = load_config(yaml.safe_load(config)).requests["histories"]
    stems = ["maps", "snap_maps", "time_maps", "thresholds", "damage_boundary", "statics"]
    stems += [f"history_{history.name}"]
    return {f"{stem}.{kind}" for stem in stems for kind in ("pdf", "png")}


def test_maps_are_panels_of_one_figure_each_and_single_on_request():
    document = yaml.safe_load(TINY)
    figures = choose_views(load_config(document)).maps
    assert [figure.name for figure in figures] == ["snap_maps", "time_maps", "maps"]
    places = [[view["at"] for view in figure.panels] for figure in figures]
    assert places == [[{"C": 0}, {"C": 1}]] * 3
    document["maps"] = [{"x": "f0", "y": "N", "at": {"C": "30 uN*us/um"}}]
    figures = choose_views(load_config(document)).maps
    names = [f"{word}_f0_N_C30" for word in ("snap", "time", "map")]
    assert [figure.name for figure in figures] == names
    assert [[view["at"] for view in figure.panels] for figure in figures] == [[{"C": 1}]] * 3


def test_every_figure_is_there(finished):
    figures = {path.name for path in (finished[0] / "results" / "figures").iterdir()}
    assert figures == figures_of(TINY)


def test_all_that_is_made_is_listed(finished):
    """But for slabs, which serve a grid that grows."""
    folder = finished[0]
    head, *listed = (folder / "results" / LIST).read_text().splitlines()
    made = {path.relative_to(folder).as_posix() for path in (folder / "results").rglob("*.*")}
    apart = ("results/slabs/", "results/logs/", f"results/{LIST}")
    assert head == HEAD and listed == sorted(path for path in made if not path.startswith(apart))


def test_of_an_older_config_only_what_was_made_leaves(clone, finished, tmp_path):
    """Where there is nothing else to do, too; a run of one product leaves all, and says so little.

    As if an older config had asked for a window and a data sheet.
    """
    folder = tmp_path / "study"
    shutil.copytree(finished[0], folder)
    results, config = folder / "results", finished[1]
    before = {path for path in results.rglob("*") if path.is_file()}
    old = [f"results/{name}" for name in ("datasheet.md", "figures/window.pdf", "window.nc")]
    mine = [results / name for name in ("figures/window_1.pdf", "tolerance.nc", "histories/a.csv")]
    for path in (*(folder / name for name in old), *mine, results / "logs" / "find_window.log"):
        path.write_text("an old line")
    with open(results / LIST, "a") as file:
        file.write("".join(f"{name}\n" for name in old))
    _, output = snakemake(clone, folder, config, "results/cube.nc", "--forcerun", "simulate_all")
    assert all((folder / name).exists() for name in old)
    assert "results/cube.nc: 32 cells" in output and "Nothing to be done" not in output
    assert "results/threshold.nc" not in output and "explore" not in output
    assert "an old line" not in output
    snakemake(clone, folder, config, "--dry-run")
    assert all((folder / name).exists() for name in old)
    _, output = snakemake(clone, folder, config)
    assert f"{', '.join(old)}: removed, as the config no longer asks for them" in output
    after = {path for path in results.rglob("*") if path.is_file()}
    assert "Nothing to be done" in output
    assert after == before | {*mine, results / "logs" / "find_window.log"}


@pytest.mark.parametrize("cores", ["0", pytest.param("-1", marks=pytest.mark.long)])
def test_no_core_is_refused_at_the_door(clone, tmp_path, finished, cores):
    code, output = snakemake(clone, tmp_path, finished[1], cores=cores, check=False)
    assert code != 0 and f"--cores {cores}: no job would ever start" in output
    assert "Traceback" not in output and not (tmp_path / "results").exists()


@contextmanager
def edited(path, text):
    """Add text to a file for a while."""
    before = path.read_text(encoding="utf-8")
    path.write_text(before + text, encoding="utf-8")
    try:
        yield
    finally:
        path.write_text(before, encoding="utf-8")


@pytest.mark.parametrize(
    ("path", "rules"),
    [
        ("snapmap/applications/page/explore.js", DRAWING),
        ("snapmap/thresholds/survey.py", RULES),
        ("snapmap/workflow/command.py", set()),
        pytest.param("draw.py", DRAWING, marks=pytest.mark.long),
        pytest.param("jobs.py", RULES, marks=pytest.mark.long),
    ],
)
def test_an_edit_reruns_what_makes_numbers_or_what_draws(clone, finished, path, rules):
    """And a touch nothing."""
    folder, config, _ = finished
    for source in (clone / "workflow" / "scripts").rglob("*.py"):
        source.touch()
    with edited(clone / "workflow" / "scripts" / path, "EDITED = 1\n"):
        output = snakemake(clone, folder, config, "--dry-run")[1]
    assert planned_rules(output).keys() - {"all"} == rules


@pytest.mark.long
def test_a_finished_run_makes_a_report(clone, finished):
    folder, config, _ = finished
    snakemake(clone, folder, config, "--report", folder / "report.zip", cores="")
    with zipfile.ZipFile(folder / "report.zip") as report:
        (page,) = [name for name in report.namelist() if name.endswith("report.html")]
        text = report.read(page).decode()
    assert "Force that holds the midpoint" in text, "the caption of an application"


def test_studies_are_targets_of_their_own(clone, finished):
    folder, config, _ = finished
    _, output = snakemake(clone, folder, config, "accuracy", "stability", "--dry-run")
    assert planned_rules(output).keys() == {"accuracy", "stability"}


@pytest.mark.parametrize(
    "products", [[], pytest.param(["results/cube.nc"], marks=pytest.mark.long)]
)
def test_another_value_makes_the_cube_of_a_small_grid_anew(clone, finished, products):
    folder, _, _ = finished
    grown = folder / "grown.yaml"
    grown.write_text(TINY.replace("30 uN*us/um]", "30 uN*us/um, 60 uN*us/um]"))
    _, output = snakemake(clone, folder, grown, "--dry-run", *products)
    assert planned_rules(output)["simulate_all"] == 1


def test_a_grid_too_large_for_one_job_fans_out(clone, finished):
    folder, _, _ = finished
    large = folder / "large.yaml"
    large.write_text(TINY.replace("points: 8", "points: 80000"))
    _, output = snakemake(clone, folder, large, "--dry-run")
    planned = planned_rules(output)
    assert planned["simulate_slab"] >= 2 and planned["collect"] == 1
    assert "simulate_all" not in planned


def test_a_second_run_in_another_spelling_has_nothing_to_do(clone, finished):
    folder, _, _ = finished
    other = folder / "other.yaml"
    text = TINY.replace("span: 500 um", "span: 5e-4 m").replace("2 kHz", "2000 Hz")
    other.write_text(text.replace("horizon: 200 us", "horizon: 0.2 ms"))
    assert "Nothing to be done" in snakemake(clone, folder, other)[1]


@pytest.mark.long
def test_what_left_the_config_leaves_the_figures(clone, finished, tmp_path):
    """What is left is as found before: nothing is simulated or looked for again."""
    folder = tmp_path / "study"
    shutil.copytree(finished[0], folder)
    mine = folder / "results" / "figures" / "map_mine.pdf"
    mine.write_text("A figure of the user's.")
    smaller = folder / "mine.yaml"
    smaller.write_text(TINY.replace("C: [0.5 uN*us/um, 30 uN*us/um]", "C: [30 uN*us/um]"))
    snakemake(clone, folder, smaller)
    figures = {path.name for path in mine.parent.iterdir()}
    assert figures == figures_of(smaller.read_text()) | {mine.name}
    for name in ("threshold.nc", "stress.nc"):
        before, after = (
            xr.load_dataset(study / "results" / name) for study in (finished[0], folder)
        )
        xr.testing.assert_equal(before.sel(C=[30]), after)


@pytest.mark.long
def test_every_product_is_made_of_two_shapes_along_both_directions(clone, tmp_path, monkeypatch):
    config = tmp_path / "mine.yaml"
    config.write_text(EVERY_PRODUCT)
    (tmp_path / "shots.csv").write_text(SHOTS)
    snakemake(clone, tmp_path, config)
    monkeypatch.chdir(tmp_path)
    study = load_config(yaml.safe_load(EVERY_PRODUCT))
    stems = [stem for several in choose_views(study).stems.values() for stem in several]
    stems += [stem for figures in gather("figures", study).values() for stem in figures]
    expected = {f"{stem}.{kind}" for stem in stems for kind in ("pdf", "png")}
    expected -= {f"{stem}.{kind}" for stem in ("explore.html", "window") for kind in ("pdf", "png")}
    assert {path.name for path in (tmp_path / "results" / "figures").iterdir()} == expected
    for name in ("requirements.csv", "datasheet.md"):
        text = (tmp_path / "results" / name).read_text(encoding="utf-8")
        assert "crash" in text and "shaking" in text
    with xr.open_dataset(tmp_path / "results" / "tolerance.nc") as made:
        assert made.sizes["shape"] == made.sizes["direction"] == 2
        assert made["yield"].leaves_out == "shaking, spectrum, the closing of crash"
        assert made.share_breaking.notnull().all()


@pytest.mark.long
def test_the_window_of_the_recipe_is_drawn(clone, tmp_path):
    """With fewer points and a cheaper model; on its range all requirements can be met."""
    text = (clone / "config" / "arm.yaml").read_text(encoding="utf-8")
    axes = window.figures(load_config(yaml.safe_load(text)))["window"]["axes"]
    assert [*axes] == ["spring", "C"]
    text = text.replace("points: 8", "points: 3").replace("samples: 200", "samples: 16")
    text = text.replace("name: auto", "name: cosines, modes: 3")
    (config := tmp_path / "arm.yaml").write_text(text)
    snakemake(clone, tmp_path, config, "results/figures/window.pdf")
    with xr.open_dataset(tmp_path / "results" / "window.nc") as points:
        best = points.reserve.min("requirement").argmax(...)
        assert points.reserve.isel(best).min() > 1.1 and points["yield"].isel(best) > 0.9
