"""What a rule depends on is what its script runs."""

import json
import re
import subprocess
import sys

import pytest

import snapmap
from snapmap.io.dependencies import code_files, code_hash

# Forks, so that the libraries are imported once.
LOADED = """
import importlib, json, os, sys
import dask.array, jsonschema, matplotlib.figure, netCDF4, numba, pandas, pint, xarray

for script in sys.argv[1:]:
    if os.fork() == 0:
        importlib.import_module(script)
        own = [name for name in sys.modules if name.split(".")[0] == "snapmap"]
        print(json.dumps([script, [sys.modules[name].__file__ for name in own]]), flush=True)
        os._exit(0)
    os.wait()
"""


@pytest.fixture(scope="module")
def scripts(root):
    return sorted((root / "workflow" / "scripts").glob("*.py"))


def test_every_rule_names_the_code_of_its_script(workflow_text):
    rules = re.split(r"^rule ", workflow_text, flags=re.M)[1:]
    with_script = [rule for rule in rules if "script:" in rule]
    assert len(with_script) > 15
    for rule in with_script:
        (script,) = re.findall(r'"\.\./scripts/(\w+)\.py"', rule)
        assert rule.split(":")[0] == script and f'code=code("{script}"),' in rule


def test_no_module_that_a_script_loads_is_forgotten(root, scripts):
    command = [sys.executable, "-c", LOADED, *(path.stem for path in scripts)]
    run = subprocess.run(command, cwd=scripts[0].parent, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    loaded = dict(json.loads(line) for line in run.stdout.splitlines())
    assert len(loaded) == len(scripts)
    for path in scripts:
        assert set(loaded[path.stem]) <= {str(file) for file in code_files(path)}, path.stem


def test_every_module_is_the_code_of_some_command(root, scripts, workflow_text):
    """Of a script, the Snakefile, a study that is run by itself, the command, or a notebook."""
    folder = root / "workflow" / "scripts"
    used = {file for path in scripts for file in code_files(path)}
    for path in (folder / "studies").glob("*.py"):
        if '__name__ == "__main__"' in path.read_text(encoding="utf-8"):
            used.update(code_files(path, folder))
    offered = [getattr(snapmap, name).__wrapped__.__module__ for name in snapmap.__all__]
    offered += "snapmap.command", "snapmap.door"
    for name in [*offered, *re.findall(r"^from (snapmap\.\S+) import", workflow_text, re.M)]:
        used.update(code_files(folder.joinpath(*name.split(".")).with_suffix(".py"), folder))
    for path in folder.rglob("*"):
        if path.is_file() and "__pycache__" not in path.parts:
            assert path in used, path


@pytest.fixture
def project(tmp_path):
    """A script, two modules of a package, one of them in a folder of its own, and their data."""
    package = tmp_path / "studies"
    (package / "inner").mkdir(parents=True)
    (tmp_path / "script.py").write_text("from studies import outer\n")
    (package / "__init__.py").write_text("")
    (package / "outer.py").write_text(
        '"""Says."""\nfrom typing import TYPE_CHECKING\nfrom .inner.deep import f\n'
        'if TYPE_CHECKING:\n    from .typed import T\nTABLE = "table.csv"\n"""Says."""\n'
    )
    (package / "inner" / "__init__.py").write_text("")
    (package / "inner" / "deep.py").write_text(
        'def f():\n    """Says."""\n    from .. import late\n    return late\n'
    )
    for name in ("late", "typed", "other"):
        (package / f"{name}.py").write_text("x = 1\n")
    (package / "table.csv").write_text("1, 2\n")
    (package / "notes.csv").write_text("3, 4\n")
    return tmp_path


USED = ["script.py", *(f"studies/{name}" for name in ("outer.py", "late.py", "table.csv"))]
USED += ["studies/__init__.py", "studies/inner/__init__.py", "studies/inner/deep.py"]


def test_imports_are_followed_and_data_is_found(project):
    found = code_files(project / "script.py")
    assert found == sorted(project / name for name in USED)


@pytest.mark.parametrize("name", USED)
def test_an_edit_of_what_is_used_changes_the_hash(project, name):
    before = code_hash(project / "script.py")
    with open(project / name, "a") as file:
        file.write("y = 2\n")
    assert code_hash(project / "script.py") != before


@pytest.mark.parametrize("name", ["typed.py", "other.py", "notes.csv"])
def test_an_edit_of_what_is_not_used_does_not(project, name):
    before = code_hash(project / "script.py")
    (project / "studies" / name).write_text("y = 2\n")
    assert code_hash(project / "script.py") == before


def test_words_change_nothing(project):
    before = code_hash(project / "script.py")
    for path in project.rglob("*.py"):
        text = path.read_text().replace("Says.", "Says it otherwise.")
        path.write_text(f"# A comment.\n\n{text}")
    assert code_hash(project / "script.py") == before
