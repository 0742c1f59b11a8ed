"""Every command that the documents name runs: here, in small, or in another test."""

import os
import re
import runpy
import subprocess
import sys
from types import SimpleNamespace

import draw
import jobs
import pytest

from snapmap.io.netcdf import write
from snapmap.study import Study
from studies.stability import settled
from studies.stability.cases import CASES
from studies.stability.measure import measure

LINE = re.compile(r"^    ((?:PYTHONPATH=\S+ )?(?:\./|/path/to/)run .*?)(?:  +#.*)?$", re.M)
SPAN = re.compile(r"`((?:PYTHONPATH=\S+ )?\./run [^`]+)`")
STUDY = re.compile(r"\bstudies\.(\w+)")
BENCHMARK = re.compile(r"\bbenchmarks/(\w+)\.py")

ITSELF = "this run of the tests"
A_STUDY = "test_pipeline.py::test_every_figure_is_there"
ON_SLURM = "test_slurm.py::test_the_cube_is_that_of_a_local_run_bit_for_bit"
A_LOCK = "test_run.py::test_lock_holds_only_exact_versions_and_hashes"
ELSEWHERE = {
    "snakemake --cores 2": A_STUDY,
    "snakemake --snakefile /path/to/Snakefile --configfile mine.yaml --cores 2": A_STUDY,
    "snakemake --cores 2 --configfile sensor.yaml": A_STUDY,
    "snakemake --directory build/tutorial --configfile config/sensor.yaml --cores 2": A_STUDY,
    "snakemake --version": "test_run.py::test_install_from_nothing",
    "snakemake --report report.zip": "test_pipeline.py::test_a_finished_run_makes_a_report",
    "snakemake --report report.zip --configfile sensor.yaml": (
        "test_pipeline.py::test_a_finished_run_makes_a_report"
    ),
    "snakemake accuracy --cores 2": "test_pipeline.py::test_accuracy_is_a_target_of_its_own",
    "snakemake results/figures/accuracy_quick.pdf --cores 2": (
        "test_pipeline.py::test_accuracy_is_a_target_of_its_own"
    ),
    "snakemake stability --cores 2": "test_commands.py::test_stability_in_small",
    "snakemake --profile profiles/slurm": ON_SLURM,
    "snakemake --profile profiles/slurm --groups simulate_slab=slabs "
    "--group-components slabs=4": ON_SLURM,
    "uv pip install --require-hashes --requirements requirements-docs.lock": A_LOCK,
    "uv pip install --require-hashes --requirements requirements-slurm.lock": A_LOCK,
    "sphinx-build -EW -c docs/site . build/site": (
        "test_docs.py::test_the_site_is_made_without_a_warning_and_asks_no_other_host"
    ),
    "snakefmt Snakefile workflow/rules": "test_pipeline.py::test_the_workflow_is_formatted",
    "python": "test_docs.py::test_the_recipes_in_python_run",
    "python docs/make_config_reference.py": (
        "test_project.py::test_the_config_reference_is_what_the_models_say"
    ),
    "python docs/make_reference.py": (
        "test_docs.py::test_the_reference_is_what_the_docstrings_say"
    ),
    "python benchmarks/impacts.py > docs/impacts.md": (
        "test_commands.py::test_a_benchmark_runs_in_small"
    ),
    "python benchmarks/compare.py": "test_commands.py::test_the_comparison_in_small",
    "python -m snapmap.command check config.yaml": (
        "test_command.py::test_check_says_what_a_config_describes_doubts_and_costs"
    ),
    "python -m snapmap.io.provenance": "test_commands.py::test_versions_in_one_paste",
    "mypy": "test_project.py::test_the_types_of_beam_and_solver_fit",
    "ruff check": ITSELF,
    "ruff format": ITSELF,
}
"""What runs each command that is no study, in small."""
SHORT = ("motion", "peers", "sensitivity", "settling")
LONG = ("coverage", "proofs", "pulses", "steps", "thresholds", "tilt", "tolerances", "validation")
LONG += ("calibration", "planning", "rigour", "vibration")
BENCHMARKS = ("scaling",)
LONG_BENCHMARKS = ("impacts", "many_devices", "start", "width")


def marked(names):
    return [pytest.param(name, marks=pytest.mark.long) for name in names]


@pytest.fixture(scope="module")
def documents(root):
    """The text of all documents that name commands."""
    pages = [*sorted(root.glob("*.md")), *sorted((root / "docs").glob("*.md"))]
    return "\n".join(page.read_text(encoding="utf-8") for page in pages)


def commands_in(text):
    """What `run` is given, by all commands, on one line each."""
    found = (
        " ".join(command.split()) for pattern in (LINE, SPAN) for command in pattern.findall(text)
    )
    return {command.split("run ", 1)[1] for command in found}


def test_every_command_is_run_by_a_test(root, documents):
    commands = commands_in(documents)
    own = {f"python benchmarks/{name}.py" for name in (*BENCHMARKS, *LONG_BENCHMARKS)}
    others = {one for one in commands if not one.startswith("pytest") and not STUDY.search(one)}
    assert others - own == set(ELSEWHERE)
    for place in set(ELSEWHERE.values()) - {ITSELF}:
        file, name = place.split("::")
        (path,) = (root / "tests").rglob(file)
        assert f"def {name}(" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("folder", "named_as", "run"),
    [
        ("workflow/scripts/studies", STUDY, {*SHORT, *LONG}),
        ("benchmarks", BENCHMARK, {"compare", *BENCHMARKS, *LONG_BENCHMARKS}),
    ],
)
def test_every_study_and_benchmark_is_run_by_a_test(root, documents, folder, named_as, run):
    assert set(named_as.findall(documents)) == run
    modules = (root / folder).glob("*.py")
    runnable = {path.stem for path in modules if "__main__" in path.read_text(encoding="utf-8")}
    assert run == runnable


@pytest.mark.parametrize("study", [*SHORT, *marked(LONG)])
def test_a_study_runs_in_small(monkeypatch, capsys, tmp_path, root, study):
    """As by `python -m`; what it writes lands in the current folder."""
    if study == "rigour":
        pytest.importorskip("flint")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(root / "workflow" / "scripts"))
    monkeypatch.setattr(sys, "argv", [study, "--small"])
    runpy.run_module(f"studies.{study}", run_name="__main__")
    rows = [line for line in capsys.readouterr().out.splitlines() if line.startswith("| ")]
    assert len(rows) > 2


@pytest.mark.parametrize("benchmark", [*BENCHMARKS, *marked(LONG_BENCHMARKS)])
def test_a_benchmark_runs_in_small(root, tmp_path, benchmark):
    command = [sys.executable, root / "benchmarks" / f"{benchmark}.py", "--small"]
    path = {"PYTHONPATH": str(root / "workflow" / "scripts")}
    options = {"cwd": tmp_path, "env": os.environ | path, "check": True, "capture_output": True}
    out = subprocess.run(command, **options, text=True).stdout
    assert len([line for line in out.splitlines() if line.startswith("| ")]) > 2


def test_versions_in_one_paste(root):
    command = [sys.executable, "-m", "snapmap.io.provenance"]
    said = subprocess.check_output(command, cwd=root / "workflow" / "scripts", text=True)
    assert re.match(r"snapmap \d\S+ sources \w+, Python .*\nnumpy \d", said)


@pytest.mark.long
def test_the_comparison_in_small(root, tmp_path):
    """The command of docs/performance.md; without heyoka, which the usual packages do not have."""
    command = [sys.executable, root / "benchmarks" / "compare.py", "--small"]
    path = {"PYTHONPATH": str(root / "workflow" / "scripts")}
    report = tmp_path / "report.md"
    options = {"cwd": tmp_path, "env": os.environ | path, "check": True, "capture_output": True}
    subprocess.run([*command, "--out", report], **options)
    text = report.read_text(encoding="utf-8")
    assert "## Speed" in text and "## Error of the threshold" in text
    labels = re.findall(r"^\| (\S.*?) \| 16 \| .*? (\d+)/16 \|", text, re.M)
    assert len(labels) == 3 and min(int(same) for _, same in labels) >= 15


def test_stability_in_small(monkeypatch, tmp_path, handout):
    """The functions of its rules, one after the other."""
    at = SimpleNamespace(stability=tmp_path / "stability.nc", settled=tmp_path / "settled.nc")
    grid = settled.GRID | {"N": [900.0, 1100.0], "f0": [500.0, 1500.0]}
    monkeypatch.setattr(settled, "GRID", grid)
    dampings = [0.0, 4e-4, 4e-3]
    jobs.measure_settled(Study(device=handout), dampings, at.settled)
    models = {"5 cosines": {"name": "cosines", "modes": 5}}
    write(measure(handout, CASES[:1], models, steps=(0.8, 1.05)), at.stability)
    draw.draw_settled(at.settled, dampings[:2], 25.0, str(tmp_path / "settled"))
    draw.draw_stability(at.stability, str(tmp_path / "stability"))
    jobs.write_stability_table(at.stability, at.settled, tmp_path / "table.md")
    assert "handout's case" in (tmp_path / "table.md").read_text(encoding="utf-8")
    assert {path.suffix for path in tmp_path.glob("s*")} == {".nc", ".pdf", ".png"}
