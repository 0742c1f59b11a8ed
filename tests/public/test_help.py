"""`help`, the page of functions and editors show the same names, arguments and sentences."""

import ast
import doctest
import inspect
import pydoc
import re
import runpy
import subprocess
import sys
from dataclasses import is_dataclass

import pytest
from small_studies import cases_of

import snapmap
from snapmap.values.records import rows, sentences

SECTION = re.compile(r"^(\w+)\n-{3,}\n", re.M)
RECORDS = ("Auto", "Beam", "Cosines", "Device", "Elements", "Reference", "Study")
CASES = cases_of(__file__)
THREADS = "number of threads, which change no result"


def parts_of(name):
    """Sections of the docstring of a public name, with the text before them under ""."""
    head, *parts = SECTION.split(inspect.getdoc(getattr(snapmap, name)))
    return {"": head} | dict(zip(parts[::2], parts[1::2], strict=True))


def entries_of(text):
    return [line.partition(" : ")[0] for line in text.splitlines() if line and line[0] != " "]


@pytest.mark.parametrize("name", snapmap.__all__)
def test_a_docstring_has_the_sections_of_numpydoc_and_each_argument(name):
    described, parts = getattr(snapmap, name), parts_of(name)
    assert re.match(r"[A-Z][^\n]*[.:]\n", parts[""])
    named = [key for entry in entries_of(parts["Parameters"]) for key in entry.split(", ")]
    assert named == [*inspect.signature(described).parameters]
    assert doctest.DocTestParser().get_examples(parts["Examples"])
    if not isinstance(described, type):
        assert {"Returns", "Raises"} <= parts.keys()


@pytest.mark.parametrize("name", RECORDS)
def test_a_record_says_of_each_field_what_its_source_says(name):
    record, parts = getattr(snapmap, name), parts_of(name)
    for row in rows(record):
        assert row.what and row.what == sentences(record)[row.key]
        assert f"{row.key} : " in parts["Parameters"] and row.what in parts["Parameters"]
    assert is_dataclass(record) and parts["Parameters"] in pydoc.plain(
        pydoc.render_doc(record)
    ).replace("\n |  ", "\n").replace("\n |\n", "\n\n")


def test_the_page_has_each_name_with_all_that_help_says(root):
    """Once: the page of the config has the sentences of fields, which are its keys, too."""
    page = runpy.run_path(root / "docs" / "make_reference.py")["reference"]()
    assert (root / "docs" / "reference.md").read_text(encoding="utf-8") == page
    config = (root / "docs" / "config.md").read_text(encoding="utf-8")
    here, there = " ".join(page.split()), " ".join(config.split())
    for name in snapmap.__all__:
        assert f"## `{name}`\n" in page
        for title, text in parts_of(name).items():
            is_key = title == "Parameters" and name in {*RECORDS} - {"Study"}
            lines = [line for line in text.splitlines() if line[:1] == " " or not is_key]
            if title == "Examples":
                lines = [line for line in lines if "load_device" not in line]
            for line in lines:
                said = " ".join(line.partition(" : ")[2 * (line[:1] != " ")].split())
                is_there = (is_key and said in there) or said == THREADS
                assert is_there or said in here, (name, line)


def test_a_signature_is_short_and_hides_no_argument():
    for name in snapmap.__all__:
        signature = inspect.signature(getattr(snapmap, name))
        kinds = {part.kind for part in signature.parameters.values()}
        assert kinds <= {inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY}
        annotations = {part.annotation for part in signature.parameters.values()}
        assert not [of for of in annotations if re.search("object|Annotated", str(of))], name
        assert inspect.Parameter.empty not in annotations, name


def test_the_stub_names_where_each_public_name_is_defined(root):
    """So an editor, which runs nothing, finds the definition with its arguments."""
    package = root / "workflow" / "scripts" / "snapmap"
    stub = ast.parse((package / "__init__.pyi").read_text(encoding="utf-8"))
    found = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    assert sorted(node.names[0].name for node in found) == snapmap.__all__
    for node in found:
        (alias,), module = node.names, package.joinpath(*node.module.split("."))
        tree = ast.parse(module.with_suffix(".py").read_text(encoding="utf-8"))
        (defined,) = (part for part in tree.body if getattr(part, "name", None) == alias.name)
        assert alias.asname == alias.name
        if isinstance(defined, ast.FunctionDef):
            arguments = [*defined.args.args, *defined.args.kwonlyargs]
            assert defined.returns and all(argument.annotation for argument in arguments)
            public = [*inspect.signature(getattr(snapmap, alias.name)).parameters]
            named = [argument.arg for argument in arguments if argument.arg != "observers"]
            assert named == public


def test_a_checker_of_types_finds_names_arguments_and_words(root, tmp_path):
    pytest.importorskip("mypy")

    def check(text):
        path = tmp_path / "use.py"
        path.write_text(text)
        command = [sys.executable, "-m", "mypy", "--follow-imports=silent", path]
        return subprocess.run(command, cwd=root, capture_output=True, text=True).stdout

    assert check(CASES["right"]).startswith("Success")
    lines = {int(line) for line in re.findall(r"use\.py:(\d+): error", check(CASES["wrong"]))}
    assert lines == {2, 3, 4, 5, 6}
