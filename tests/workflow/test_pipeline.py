"""The workflow itself: run, rerun, refuse; in folders and with devices of its own."""

import fnmatch
import json
import os
import re
import shutil
import subprocess
import time
import zipfile

import psutil
import pytest
import xarray as xr
import yaml
from small_studies import EVERY_PRODUCT, SHOTS, TINY, cases_of
from small_workflow import snakemake, wait_for

import snapmap
from snapmap.applications import attached, gather, window
from snapmap.applications.whole import load_config
from snapmap.solver.options import Cosines
from snapmap.solver.outcome import FAILED, LATCHED, NEVER, RETURNED, SNAPPED
from snapmap.study.provenance import hash_numbers
from snapmap.workflow.made import HEAD, LIST, hash_of, list_made
from snapmap.workflow.plan import choose_views

JOBS = "workflow/scripts/jobs.py"
DRAWING = {"draw_study", "draw_histories"}
RULES = {"simulate_all", "find_threshold", "find_stress", "simulate_histories"} | DRAWING
OLD = ["results/datasheet.md", "results/figures/window.pdf", "results/window.nc"]
"""As if an older config had asked for a window and a data sheet."""
USERS = ["results/figures/window_1.pdf", "results/tolerance.nc", "results/histories/a.csv"]


def planned_rules(output):
    """The rules that a dry run would execute, with the number of their jobs."""
    table = output.split("Job stats:")[1].split("total")[0] if "Job stats:" in output else ""
    return {rule: int(count) for rule, count in re.findall(r"^(\w+) +(\d+)$", table, re.M)}


def times_of_files(folder):
    """When each file was written, but for what Snakemake and runs leave behind."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    kept = [path for path in files if not {".snakemake", "results"} & {*path.parts}]
    return {path: path.stat().st_mtime_ns for path in kept}


@pytest.fixture(scope="module")
def clone(root, tmp_path_factory):
    """A copy of the project's files alone, in a folder whose name has a space."""
    clone = tmp_path_factory.mktemp("a clone") / "snap map"
    ignored = shutil.ignore_patterns(".*", "results", "build", "__pycache__", "tests")
    return shutil.copytree(root, clone, ignore=ignored)


def study_of(text):
    return load_config(yaml.safe_load(text))


def files_of(stems):
    return {f"{stem}.{kind}" for stem in stems for kind in ("pdf", "png")}


def figures_of(folder):
    return {path.name for path in (folder / "results" / "figures").iterdir()}


def make(folder, names):
    for path in (folder / name for name in names):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("an old line")


@pytest.fixture(scope="module")
def finished(clone, tmp_path_factory):
    """A study's folder and config, and what its run printed."""
    folder = tmp_path_factory.mktemp("a study")
    (config := folder / "mine.yaml").write_text(TINY)
    make(folder, [*OLD, *USERS, "results/logs/find_window.log"])
    (folder / "results" / LIST).write_text("\n".join([HEAD, *OLD, ""]))
    before = times_of_files(clone)
    output = snakemake(clone, folder, config)[1]
    assert times_of_files(clone) == before, "the run wrote into the clone"
    return folder, config, output


def test_cube_and_thresholds_are_what_python_gives(finished):
    results, device = finished[0] / "results", snapmap.load_device(finished[1])
    study = snapmap.Study(device, model=Cosines(modes=3), horizon=200.0)
    with xr.open_dataset(results / "threshold.nc") as edges:
        axes = {"f0": edges.f0, "C": edges.C, "highest": 3000.0}
        xr.testing.assert_equal(edges, snapmap.threshold(study, **axes))
    with xr.open_dataset(results / "cube.nc") as cube:
        direct = snapmap.sweep(study, N=cube.N, f0=cube.f0, C=cube.C)
        xr.testing.assert_equal(cube, direct)
        assert cube.outcome.dims == ("C", "f0", "N") and cube.outcome.shape == (2, 2, 8)
        assert cube.outcome.dtype == "int8" and cube.t_snap.dtype == "float64"
        snapped = cube.outcome.isin([SNAPPED, LATCHED, RETURNED])
        assert snapped.any() and not snapped.all() and not (cube.outcome == FAILED).any()
        assert (cube.t_snap.notnull() == snapped).all()
        proven = cube.outcome.isin([NEVER, LATCHED, RETURNED])
        assert (cube.t_settled.notnull() == proven).all()
        assert cube.energy_error.max() <= 1e-3
        document = study_of(TINY).document()
        assert json.loads(cube.config) == json.loads(direct.config) == document
        assert snapmap.__version__ in cube.code_version and "numba" in cube.packages


def test_a_run_ends_with_a_line_of_each_product_that_it_made(finished):
    output = finished[2]
    assert "results/cube.nc: 32 cells" in output and "results/threshold.nc: 4 of 4" in output
    assert "results/explore.html: open it" in output
    assert not any(words in output for words in ("Nothing to be done", "an old line"))
    assert len(list((finished[0] / "results" / "logs").iterdir())) > len(RULES)


def test_lint_misses_nothing_but_environments_of_rules(clone, tmp_path):
    """There is one, as the Snakefile itself needs it: config/README.md. From the catalog's file."""
    config = clone / "config" / "sensor.yaml"  # of many products
    _, output = snakemake(clone / "workflow", tmp_path, config, "--lint", check=False)
    lints = re.findall(r"^    \* (.+):$", output, re.M)
    assert len(lints) > len(RULES), output
    assert set(lints) == {"Specify a conda environment or container for each rule."}


def test_the_workflow_is_formatted(clone):
    names = "Snakefile", "studies.smk", "workflow/Snakefile", "workflow/rules"
    files = [clone / name for name in names]
    assert subprocess.run(["snakefmt", "--check", *files], timeout=120).returncode == 0


def test_maps_are_panels_of_one_figure_each_and_single_on_request():
    def panels(**requested):
        figures = choose_views(load_config(yaml.safe_load(TINY) | requested)).maps
        return {each["name"]: [view["at"] for view in each["panels"]] for each in figures}

    names = "snap_maps", "time_maps", "maps"
    assert [*panels().items()] == [(name, [{"C": 0}, {"C": 1}]) for name in names]
    captioned = choose_views(study_of(TINY)).stems
    assert (captioned["snap_maps"], captioned["maps"]) == (["snap_maps"], ["time_maps", "maps"])
    wanted = {"C0.5": "0.5 uN*us/um", "C30": "30 uN*us/um"}
    single = panels(maps=[{"x": "f0", "y": "N", "at": {"C": C}} for C in wanted.values()])
    words = "snap", "time", "map"
    names = [(f"{word}_f0_N_{C}", [{"C": i}]) for i, C in enumerate(wanted) for word in words]
    assert [*single.items()] == names


def test_every_figure_is_there(finished):
    stems = ["maps", "snap_maps", "time_maps", "thresholds", "damage_boundary", "statics"]
    stems += [f"history_{history.name}" for history in study_of(TINY).requests["histories"]]
    assert figures_of(finished[0]) == files_of(stems) | {"window_1.pdf"}


def test_what_is_made_is_listed_and_of_an_older_config_only_that_leaves(clone, finished):
    """Also where there is nothing else to do."""
    folder, _, output = finished
    text = TINY.replace("2 kHz", "2000 Hz").replace("horizon: 200 us", "horizon: 0.2 ms")
    (other := folder / "other.yaml").write_text(text)
    listing = folder / "results" / LIST
    for again in (False, True):
        if again:
            make(folder, OLD)
            with open(listing, "a") as file:
                file.write("".join(f"{name}\n" for name in OLD))
            for part in ("--dry-run", "results/cube.nc"):  # neither of which is a whole run
                assert "Nothing to be done" in snakemake(clone, folder, other, part)[1]
                assert all((folder / name).exists() for name in OLD)
            _, output = snakemake(clone, folder, other)
            assert "Nothing to be done" in output, "in another spelling"
        assert f"{', '.join(OLD)}: removed, as the config no longer asks for them" in output
        head, *listed = listing.read_text().splitlines()
        made = {path.relative_to(folder).as_posix() for path in (folder / "results").rglob("*.*")}
        apart = ("results/logs/", f"results/{LIST}", *USERS)
        listed = [line.partition("\t")[0] for line in listed]
        assert head == HEAD and {*listed} == {name for name in made if not name.startswith(apart)}
        assert made > {*USERS, "results/logs/find_window.log"}


def test_a_device_in_other_words_is_drawn_anew_and_not_simulated(clone, finished):
    """The page shows the words of its config."""
    folder = finished[0]
    (other := folder / "words.yaml").write_text(TINY.replace("span: 500 um", "span: 5e-4 m"))
    output = snakemake(clone, folder, other, "--dry-run")[1]
    assert planned_rules(output).keys() - {"all"} == {"draw_study"}


PUSHED = TINY.replace("gravity: 9.81 m/s^2", "force: 1 uN").replace("mass: 6e-9 kg", "mass: none")
PUSHED = re.sub("(?m)^  (spring|contact|strength|C):.*\n", "", PUSHED.partition("histories")[0])


@pytest.mark.parametrize("more", ["", "maps: []", "{maps: [], thresholds: []}"])
def test_a_study_without_some_figures_is_planned(clone, tmp_path, more):
    """A force gives no damage boundary."""
    text = yaml.safe_dump(yaml.safe_load(PUSHED) | (yaml.safe_load(more) or {}))
    (config := tmp_path / "mine.yaml").write_text(text)
    _, output = snakemake(clone, tmp_path, config, "--dry-run")
    assert {"find_threshold", "draw_study"} < planned_rules(output).keys()
    assert "damage_boundary" not in output and "results/explore.html" in output


def test_shots_that_no_device_of_the_ranges_gives_are_refused_before_the_first_job(clone, tmp_path):
    """Here in m/s^2."""
    (tmp_path / "shots.csv").write_text(re.sub(r"(?m)^(\d+)", r"\g<1>0", SHOTS))
    unknowns = {"thickness": ["1.7 um", "2.1 um"]}
    asked = {"calibration": {"shots": "shots.csv", "unknowns": unknowns, "C": "30 uN*us/um"}}
    (config := tmp_path / "mine.yaml").write_text(yaml.safe_dump(yaml.safe_load(TINY) | asked))
    code, output = snakemake(clone, tmp_path, config, check=False)
    assert code != 0 and not (tmp_path / "results").exists()
    last = output.splitlines()[-1]
    assert last.startswith("calibration: shots: N is ") and last.endswith("multiples of g?")


def test_no_core_is_refused_at_the_door(clone, tmp_path, finished):
    for cores in (0, -1):
        options = f"--cores={cores}", "--dry-run"
        code, output = snakemake(clone, tmp_path, finished[1], *options, cores="", check=False)
        assert code != 0 and f"--cores {cores}: no job would ever start" in output
        assert "Traceback" not in output and not (tmp_path / "results").exists()


EDITS = (
    ("snapmap/applications/page/explore.js", DRAWING),
    ("snapmap/thresholds/search.py", RULES),
    ("snapmap/workflow/command.py", set()),
    pytest.param("draw.py", DRAWING, marks=pytest.mark.long),
    pytest.param("jobs.py", RULES, marks=pytest.mark.long),
)


@pytest.mark.parametrize(("path", "rules"), EDITS)
def test_an_edit_reruns_what_makes_numbers_or_what_draws_and_a_touch_nothing(
    clone, finished, path, rules
):
    scripts = clone / "workflow" / "scripts"
    for source in scripts.rglob("*.py"):
        source.touch()
    before = (scripts / path).read_text(encoding="utf-8")
    (scripts / path).write_text(before + "EDITED = 1\n", encoding="utf-8")
    code, output = snakemake(clone, *finished[:2], "--dry-run", check=False)
    (scripts / path).write_text(before, encoding="utf-8")
    assert code == 0 and planned_rules(output).keys() - {"all"} == rules, output


@pytest.fixture
def copied(finished, tmp_path):
    """A folder with a copy of finished results, alone and with new times, and the config."""
    shutil.copytree(finished[0] / "results", tmp_path / "results", copy_function=shutil.copy)
    return tmp_path, finished[1]


@pytest.mark.parametrize("change", cases_of(__file__))
def test_copied_results_of_another_study_are_made_again_with_a_line(clone, copied, change):
    (config := copied[0] / "changed.yaml").write_text(TINY.replace(*change))
    _, output = snakemake(clone, copied[0], config, "--dry-run")
    assert planned_rules(output).keys() - {"all"} == RULES
    assert output.count("others: to be made again, as not of this study and code (made for") == 1


def test_copied_results_of_the_same_study_are_kept_whatever_their_times(clone, copied):
    folder, config = copied
    for number, path in enumerate(sorted((folder / "results").rglob("*.*"))):
        os.utime(path, (2e9 - number, 2e9 - number))  # in 2033, and in a foreign order
    assert "Nothing to be done" in snakemake(clone, folder, config, "--dry-run")[1]
    assert (folder / "results" / "cube.nc").stat().st_mtime <= time.time()


def test_what_no_run_has_listed_or_what_has_changed_since_is_made_again(clone, copied):
    folder, config = copied
    table = folder / "results" / "thresholds.csv"
    lines = table.read_text().splitlines()
    table.write_text("\n".join([*lines[:-1], ""]))
    _, output = snakemake(clone, folder, config, "--dry-run")
    assert planned_rules(output).keys() - {"all"} == {"find_threshold", "draw_study"}
    assert "results/thresholds.csv: to be made again, " in output and "(changed since)" in output
    (folder / "results" / LIST).unlink()
    _, output = snakemake(clone, folder, config, "--dry-run")
    assert planned_rules(output).keys() - {"all"} == RULES
    assert f"(unknown to results/{LIST})" in output


@pytest.mark.long
def test_a_quiet_run_lists_what_it_makes(root, tmp_path):
    """With --quiet, Snakemake announces no job as it ends; the next jobs read what is new."""
    (config := tmp_path / "mine.yaml").write_text(TINY)
    for text in (TINY, TINY.replace("1.9 um", "1.7 um")):
        config.write_text(text)
        snakemake(root, tmp_path, config, "--quiet", cores="1")
        assert "Nothing to be done" in snakemake(root, tmp_path, config, "--dry-run")[1]


@pytest.mark.long
@pytest.mark.parametrize("ends", ["edited", "killed"])
def test_an_interrupted_growth_loses_nothing_and_joins_no_other_code(clone, copied, ends):
    folder, _ = copied
    kept = [folder / "results" / name for name in ("threshold.nc", "thresholds.csv", "statics.nc")]
    old = [path.read_bytes() for path in kept]
    grown = TINY.replace("30 uN*us/um]", "30 uN*us/um, 60 uN*us/um]")
    (config := folder / "grown.yaml").write_text(grown)
    command = ["snakemake", "--snakefile", clone / "Snakefile", "--directory", folder]
    command += ["--configfile", config, "--cores", "1"]
    pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    log = folder / "results" / "logs" / "find_threshold.log"
    log.unlink()
    path = clone / "workflow" / "scripts" / "snapmap" / "sweeps" / "slabs.py"
    before = path.read_text(encoding="utf-8")
    with subprocess.Popen(command, **pipe) as run:
        wait_for(log.exists)
        if ends == "killed":
            for job in [run, *psutil.Process(run.pid).children(recursive=True)]:
                job.kill()  # a job that outlives its run may still end well
        else:
            path.write_text(before + "EDITED = 1\n", encoding="utf-8")
        output = run.communicate(timeout=300)[0]
        path.write_text(before, encoding="utf-8")
    assert run.returncode and "Traceback" not in output
    assert [path.read_bytes() for path in kept] == old
    if ends == "edited":
        words = "the code that makes numbers: was edited after the run was planned; run again"
        assert words in output and "Restored" not in output
        assert "find_threshold" in planned_rules(snakemake(clone, folder, config, "--dry-run")[1])


@pytest.mark.long
def test_a_finished_run_makes_a_report(clone, finished):
    path = finished[0] / "report.zip"
    snakemake(clone, *finished[:2], "--report", path, cores="")
    with zipfile.ZipFile(path) as report:
        (page,) = [name for name in report.namelist() if name.endswith("report.html")]
        text = report.read(page).decode()
    assert "Force that holds the midpoint" in text, "the caption of an application"


CORE = {"simulate_all", "simulate_slab", "collect", "find_threshold", "draw_study", "all"}
"""Rules that are not in the table of architecture.md, or make more than applications do."""


def test_the_rules_of_applications_are_those_of_their_table(clone, tmp_path):
    """A dry run of a study that asks for all tells what each job makes, and reads of others."""
    axes = "C: [30 uN*us/um, 60 uN*us/um]\n  mass: [6e-9 kg, 7e-9 kg]"
    (config := tmp_path / "all.yaml").write_text(EVERY_PRODUCT.replace("C: [30 uN*us/um]", axes, 1))
    (tmp_path / "shots.csv").write_text(SHOTS)
    _, said = snakemake(clone, tmp_path, config, "--dry-run")
    jobs = dict(re.findall(r"Job \d+: (.*)\n *Reason: Missing output files: (.*)\n", said))
    page = (clone / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\w+) \| (\w+) \| (.+) \| (\S+) \|$", page, re.M)
    planned = {*planned_rules(said)}
    assert planned - CORE == {job for _, job, *_ in rows} - CORE
    for folder, job, *_ in rows:
        part = attached()[folder]
        words = {"find_threshold": "Find the thresholds", part.rule: part.message}
        columns = zip(*(row[2:] for row in rows if row[1] == job), strict=True)
        reads, makes = (", ".join(column).replace("-", "") for column in columns)
        made, _, read = jobs[words.get(job, f"Draw the {job[5:]}")].partition("; ")
        for files, patterns in ((read, reads), (made, makes)):
            names = re.findall(r"results/([^,\n]+)", files)
            globs = re.findall(r"[^, ]+", patterns)
            assert all(fnmatch.filter(names, glob) for glob in globs), (job, patterns)
            assert job in CORE or {*names} == {n for g in globs for n in fnmatch.filter(names, g)}


def test_a_dry_run_of_a_grown_grid_counts_the_new_cells(root, clone, copied, monkeypatch):
    """All of a small one, which is one job; of a large one those of slabs that are not there."""
    folder, _ = copied
    config = folder / "grown.yaml"

    def counted(text, *targets):
        config.write_text(text)
        said = snakemake(clone, folder, config, *targets, "--dry-run")[1]
        (line,) = re.findall(r"^(\d+) cells: (\d+) are there already, (\d+) are new$", said, re.M)
        return [*map(int, line)], said

    grown = TINY.replace("30 uN*us/um]", "30 uN*us/um, 60 uN*us/um]")
    cells, said = counted(grown)
    assert cells == counted(grown, "results/threshold.nc")[0] == [48, 0, 48]
    assert planned_rules(said)["simulate_all"] == 1
    large = TINY.replace("points: 8", "points: 80000")
    (cells, there, new), said = counted(large)
    assert there == 0 and new == cells == 32 * 10_000
    planned = planned_rules(said)
    assert planned["simulate_slab"] >= 2 and planned["collect"] == 1
    assert "simulate_all" not in planned
    name = re.search(r"results/slabs/(\w+)\.nc", said)[1]
    path = folder / "results" / "slabs" / f"{name}.nc"
    path.parent.mkdir(exist_ok=True)
    path.write_text("a slab")
    assert counted(large)[0] == [cells, 0, cells], "it is on no list"
    (numbers,) = hash_numbers(clone / JOBS).values()
    monkeypatch.chdir(folder)
    list_made([f"results/slabs/{name}.nc"], hash_of(numbers, name))
    cells, there, new = counted(large)[0]
    assert 0 < there < cells == there + new


@pytest.mark.long
def test_every_product_is_made_of_two_shapes_along_both_directions(clone, tmp_path, monkeypatch):
    (config := tmp_path / "mine.yaml").write_text(EVERY_PRODUCT)
    (tmp_path / "shots.csv").write_text(SHOTS)
    snakemake(clone, tmp_path, config)
    monkeypatch.chdir(tmp_path)
    study = study_of(EVERY_PRODUCT)
    stems = {stem for several in choose_views(study).stems.values() for stem in several}
    drawn = gather(lambda part: part.figures(study)).values()
    stems |= {stem for figures in drawn for stem in figures}
    assert figures_of(tmp_path) == files_of(stems - {"explore", "window"})
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
    units = window.application.figures(study_of(text))["window"]["units"]
    assert [*units] == ["spring", "C"]
    text = text.replace("points: 8", "points: 3").replace("samples: 200", "samples: 16")
    text = text.replace("name: auto", "name: cosines, modes: 3")
    (config := tmp_path / "arm.yaml").write_text(text)
    snakemake(clone, tmp_path, config, "results/figures/window.pdf")
    with xr.open_dataset(tmp_path / "results" / "window.nc") as points:
        best = points.reserve.min("requirement").argmax(...)
        assert points.reserve.isel(best).min() > 1.1 and points["yield"].isel(best) > 0.9
