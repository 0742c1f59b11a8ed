"""Every command that the documents name runs: here, in small, or in another test."""

import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from small_studies import cases_of

from studies import tables
from studies.__main__ import NAMES

LINE = re.compile(r"^    ((?:\./|/path/to/)run .*?)(?:  +#.*)?$", re.M)
SPAN = re.compile(r"`(\./run [^`]+|snapmap [^`]+)`")

ELSEWHERE = cases_of(__file__)
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
