"""Tables on pages are those of files, and files those of studies."""

import re
import runpy
import sys

import pytest
from small_workflow import snakemake

import snapmap
from studies import tables
from studies.__main__ import NAMES, SLOW, fault_of

VERSION = re.compile(r"(?:[Vv]ersion |snapmap |\(|, )(\d+\.\d+\.\d+)(?=[,;)+ ]|$)", re.M)
"""A version in text, but not of another package."""


@pytest.fixture(scope="module")
def made(root):
    """What docs/make_tables.py defines."""
    return runpy.run_path(str(root / "docs" / "make_tables.py"))


@pytest.fixture(scope="module")
def files(root):
    """The files of record, by their names."""
    return {path.stem: path for path in sorted((root / "docs" / "tables").glob("*.csv"))}


def test_pages_show_what_their_files_say(made, files):
    text = {page: page.read_text(encoding="utf-8") for page in made["PAGES"]}
    assert [page for page in text if made["shown"](text[page]) != text[page]] == []
    shown = re.findall(r"<!-- table: (\w+) -->", "".join(text.values()))
    linked = re.findall(r"tables/(\w+)\.csv", "".join(text.values()))
    assert {*shown, *linked} == {*files}


def test_each_file_is_of_a_whole_study_of_this_version_and_each_study_has_one(made, files):
    assert {tables.read(path)[1][6] for path in files.values()} == {*NAMES}
    for path in files.values():
        (head, *rows), foot = tables.read(path)
        assert made["is_whole"](path), path.name
        assert foot[1].startswith(f"snapmap {snapmap.__version__}"), path.name
        assert rows and all(len(row) <= len(head) for row in rows), path.name


def test_no_page_names_an_older_version(made):
    for page in made["PAGES"]:
        said = {*VERSION.findall(page.read_text(encoding="utf-8"))}
        assert said <= {snapmap.__version__}, page.name


def test_the_workflow_of_studies_plans_each_and_by_default_no_slow_one(root, tmp_path):
    config = root / ".test" / "config" / "config.yaml"  # of no account
    for target, names in (("all", {*NAMES} - {*SLOW}), ("all_slow", {*NAMES})):
        _, said = snakemake(root, tmp_path, config, "--dry-run", target, snakefile="studies.smk")
        assert {*re.findall(r"output: results/studies/(\w+)\.md", said)} == names


def test_no_study_ends_without_a_table_or_a_word(tmp_path, monkeypatch):
    """Whatever ends it: a library, a signal, or its last line before it has written."""
    monkeypatch.chdir(tmp_path)
    write = "from studies.tables import Table, write; write('laws', Table('laws', ['a'], [['1']]))"
    ends = {"import os; os._exit(0)": "without a table", "raise SystemExit(3)": "status 3"}
    ends |= {"import os; os.kill(os.getpid(), 9)": "status -9", write: ""}
    for line, word in ends.items():
        fault = fault_of([sys.executable, "-c", line])
        assert word in fault and bool(fault) == bool(word)
