"""Every command that the documents name runs: here, in small, or in another test."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

from studies import tables
from studies.__main__ import NAMES

LINE = re.compile(r"^    ((?:\./|/path/to/)run .*?)(?:  +#.*)?$", re.M)
SPAN = re.compile(r"`(\./run [^`]+|snapmap [^`]+)`")

ELSEWHERE = {
    "test_every_figure_is_there": [
        "snakemake --cores 2",
        "snapmap run config/config.yaml --cores 2",
        "snapmap run mine.yaml",
        "snapmap run mine.yaml --cores 2",
    ],
    "test_an_example_runs_whole": [
        "snapmap run sensor.yaml --cores 2",
        "snapmap run config/handout.yaml --cores 2",
        "snapmap run config/sensor.yaml --directory build/tutorial --cores 2",
    ],
    "test_a_run_ends_with_a_line_of_each_product_that_it_made": [
        "snapmap run mine.yaml results/cube.nc"
    ],
    "test_the_window_of_the_recipe_is_drawn": [
        "snapmap run config/arm.yaml results/figures/window.pdf --cores 2"
    ],
    "test_a_finished_run_makes_a_report": ["snapmap run sensor.yaml --report report.zip"],
    "test_the_workflow_of_studies_plans_each_and_by_default_no_slow_one": [
        "snakemake --snakefile studies.smk --cores 2",
        "snakemake --snakefile studies.smk --cores 2 all_slow",
    ],
    "test_pages_show_what_their_files_say": ["python docs/make_tables.py"],
    "test_the_workflow_is_formatted": ["snakefmt Snakefile studies.smk workflow/rules"],
    "test_the_cube_is_that_of_a_local_run_bit_for_bit": [
        "snapmap run mine.yaml --profile profiles/slurm",
        "snapmap run mine.yaml --profile profiles/slurm --groups simulate_slab=slabs "
        "--group-components slabs=4",
    ],
    "test_each_lock_holds_only_exact_versions_and_hashes": [
        "uv pip install --require-hashes --requirements locks/requirements-docs.lock",
        "uv pip install --require-hashes --requirements locks/requirements-peers.lock",
        "uv pip install --require-hashes --requirements locks/requirements-slurm.lock",
    ],
    "test_the_site_is_made_without_a_warning_and_asks_no_other_host": [
        "sphinx-build -EW -c docs/site . build/site"
    ],
    "test_pictures_of_pages_are_small_and_have_the_numbers_of_today": [
        "python docs/make_pictures.py build/tutorial/results/figures"
    ],
    "test_the_recipes_in_python_run": ["python"],
    "test_the_page_has_each_name_with_all_that_help_says": ["python docs/make_reference.py"],
    "test_the_page_of_the_config_has_each_key_with_its_sentence": [
        "python docs/make_config_reference.py"
    ],
    "test_every_equation_of_the_theory_has_a_test_that_names_it": ["python docs/make_equations.py"],
    "test_the_types_fit": ["mypy"],
    "test_check_says_what_a_config_describes_doubts_and_costs": [
        *(f"snapmap check{name}" for name in ("", " FILE", " mine.yaml", " sensor.yaml"))
    ],
    "test_init_writes_the_config_that_there_is_and_nothing_over_another": ["snapmap init"],
    "test_the_command_says_its_version": ["snapmap --version"],
    "test_help_says_what_a_config_is_and_where_results_go": ["snapmap run --help"],
    "test_a_dry_run_of_a_grown_grid_counts_the_new_cells": ["snapmap run mine.yaml -n"],
    "test_the_notebook_stores_what_it_gives_today": ["python docs/make_notebook.py"],
    "test_the_versions_come_in_one_paste": ["python -m snapmap.study.provenance"],
    "test_every_command_is_run_by_a_test": ["ruff check", "ruff format"],
}
"""What runs each command that is no study, in small."""
PARTS = "workflow", "studies", "profiles", "config", "examples"
SUFFIXES = ".py", ".csv", ".js", ".json", ".yaml", ".smk"
"""Folders and files of the code."""
OTHERS = "fontset get_legend grep includegraphics map_x_y mathtext mylaws pyuff srun "
OTHERS += "subplots_adjust tight_layout time_maps tmux __use_yte"
"""Names on pages that are those of others, or that the code makes of parts."""


def test_every_command_is_run_by_a_test(root):
    pages = [*root.glob("*.md"), *(root / "docs").rglob("*.md")]
    text = "\n".join(page.read_text(encoding="utf-8") for page in pages)
    named = {" ".join(words.split()) for words in (*LINE.findall(text), *SPAN.findall(text))}
    others = {re.sub(r"^\S*run ", "", words) for words in named}
    others = {words for words in others if not words.startswith(("pytest", "python -m studies"))}
    assert others == {command for commands in ELSEWHERE.values() for command in commands}
    tests = "".join(path.read_text(encoding="utf-8") for path in (root / "tests").rglob("*.py"))
    assert all(f"\ndef {name}(" in tests for name in ELSEWHERE)


def test_every_name_on_a_page_is_one_of_the_code(root):
    """Words between backticks but those in capitals; and files of code with their folder."""
    scripts = root / "workflow" / "scripts"
    places = root, root / "docs", scripts, scripts / "snapmap", scripts / "snapmap" / "applications"
    files = [f for part in PARTS for f in (root / part).rglob("*.*") if f.suffix in SUFFIXES]
    known = {*re.findall(r"\w+", " ".join([OTHERS, *map(Path.read_text, files)]))}
    for page in [root / "README.md", *(root / "docs").rglob("*.md")]:
        text = page.read_text(encoding="utf-8").partition("\n## Tests of ")[0]
        text = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
        for span in re.findall(r"`([^`\n]+)`", text):
            is_known = {*re.findall(r"\b[A-Za-z]?[a-z_]\w+[^\W_]", span)} <= known
            is_file = any((place / span).exists() for place in places)
            assert is_file or (is_known and not re.search(r"/.*\.py$", span)), (page.name, span)


@pytest.mark.parametrize(
    "study",
    [pytest.param(name, marks=[pytest.mark.long] * (name != "tolerances")) for name in NAMES],
)
def test_a_study_makes_its_tables_in_small(monkeypatch, tmp_path, root, study):
    """As by `python -m studies`; what it writes lands in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(root / "workflow" / "scripts"))
    monkeypatch.setattr(sys, "argv", ["studies", study, "--small"])
    runpy.run_module("studies", run_name="__main__")
    made = [path.name for path in sorted((tmp_path / "results" / "studies").glob("*.csv"))]
    record = {path.name: tables.read(path) for path in (root / "docs" / "tables").glob("*.csv")}
    assert made == sorted(name for name, (_, foot) in record.items() if foot[6] == study)
    for name in made:
        (head, *rows), _ = tables.read(tmp_path / "results" / "studies" / name)
        assert head == record[name][0][0] and rows


def test_the_versions_come_in_one_paste(root):
    command = [sys.executable, "-m", "snapmap.study.provenance"]
    said = subprocess.check_output(command, cwd=root / "workflow" / "scripts", text=True)
    assert re.match(r"snapmap \d\S+ sources \w+, Python .*\nnumpy \d", said)
