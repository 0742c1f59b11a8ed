"""The files of the project agree with each other."""

import ast
import inspect
import re
import runpy
import subprocess
import sys
import tomllib

import pytest
import yaml
from sizes import code_lines, functions

import snapmap
from snapmap.applications import attached
from snapmap.applications.application import Application
from snapmap.files.extras import EXTRAS


def test_every_equation_of_the_theory_has_a_test_that_names_it(root):
    """As the last table of the page says."""
    made = runpy.run_path(root / "docs" / "make_equations.py")
    page = (root / "docs" / "theory.md").read_text(encoding="utf-8")
    numbers = made["numbered"](page)
    assert numbers == {*made["named"]()} == {*range(1, 1 + max(numbers))}
    assert made["complete"](page) == page


CORE = "numerics", "files", "values", "device", "pulse", "beam", "solver", "study", "thresholds"
CORE += ("sweeps",)
SHELL = ("config", "figures", "workflow", "public")
LISTING = ("public", "workflow")
"""Who reads the list of applications, which holds names alone."""
MOST_LINES = {"applications": 4_687, "core and shell": 10_923, "tests": 12_053}
"""Most lines of code; who raises one says why in the commit."""
LONGEST, MANY, MOST_OF_MANY = 80, 6, 40
"""Lines of the longest function; a number of parameters, and how many functions may reach it."""


def room_of(path, package):
    """The room of a file: a folder or module at the top of the package, or an application."""
    parts = path.relative_to(package).with_suffix("").parts
    is_application = parts[0] == "applications" and len(parts) > 2
    return "/".join(parts[:2]) if is_application else parts[0]


def imported(path, package):
    """The other rooms that a file imports, wherever in it."""
    rooms = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            for module in [node.module] if node.module else [name.name for name in node.names]:
                target = path.parents[node.level - 1].joinpath(*module.split("."))
                if target.is_dir() and target != package:
                    rooms.add(room_of(target / "__init__.py", package))
                elif target.with_suffix(".py").exists():
                    rooms.add(room_of(target, package))
    return rooms - {room_of(path, package)}


@pytest.fixture(scope="module")
def package(root):
    return root / "workflow" / "scripts" / "snapmap"


@pytest.fixture(scope="module")
def rooms(package):
    """Files of each room."""
    rooms = {}
    for path in {*package.rglob("*.py")} - {package / "__init__.py"}:
        rooms.setdefault(room_of(path, package), []).append(path)
    return rooms


def test_rooms_import_those_before_them_and_the_core_no_application(rooms, package):
    order, applications = (*CORE, *SHELL), (*CORE, *SHELL[:-1], "applications")
    for room, paths in rooms.items():
        for path, other in ((at, other) for at in paths for other in imported(at, package)):
            where = f"{path.relative_to(package)} imports {other}"
            if room.startswith("applications"):  # the class `Application` imports types alone
                assert other.startswith("applications/") or other in applications, where
            elif other == "applications":
                assert room in LISTING, where
            else:
                assert order.index(other) < order.index(room), where


def test_an_application_imports_those_that_its_first_line_names(rooms, package):
    for name, application in attached().items():
        first = inspect.getmodule(type(application)).__doc__.partition("\n")[0]
        named = re.findall(r"\w+", first.partition("Imports:")[2].replace("core alone", ""))
        paths = rooms[f"applications/{name}"]
        others = {other for path in paths for other in imported(path, package)}
        used = {other.partition("/")[2] for other in others if other.startswith("applications/")}
        assert used <= {*named}, (name, used)


def test_an_application_overrides_what_the_class_has():
    """What another name would define, nobody would call."""
    for name, application in attached().items():
        own = {key for key in vars(type(application)) if not key.startswith("__")}
        assert own <= {*vars(Application)}, name


def test_the_code_is_no_larger_than_one_reads(root, rooms):
    paths = {"applications": [], "core and shell": [], "tests": [*(root / "tests").rglob("*.py")]}
    for room, files in rooms.items():
        paths["applications" if room.startswith("applications") else "core and shell"] += files
    lines = {part: sum(map(code_lines, files)) for part, files in paths.items()}
    assert all(lines[part] <= most for part, most in MOST_LINES.items()), lines


def test_functions_are_no_longer_than_one_reads(rooms):
    every = [function for files in rooms.values() for path in files for function in functions(path)]
    assert max(lines for _, lines, _ in every) <= LONGEST
    assert sum(parameters >= MANY for _, _, parameters in every) <= MOST_OF_MANY


def test_the_page_on_architecture_names_every_room_and_each_application_has_a_page(root, rooms):
    page = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    (tree,) = re.findall(r"```text\n(.*?)```", page, re.S)
    assert {*CORE, *SHELL, *attached()} <= {*re.findall(r"\w+", tree)}
    assert {room.partition("/")[0] for room in rooms} == {*CORE, *SHELL, "applications"}
    assert {*attached()} <= {page.stem for page in (root / "docs" / "applications").glob("*.md")}


@pytest.fixture(scope="module")
def pyproject(root):
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_version_is_the_same_everywhere(root, pyproject):
    assert pyproject["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "snapmap.__version__"}
    citation = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    changes = re.findall(r"^## \[?(\d+\.\d+\.\d+)", (root / "CHANGELOG.md").read_text(), re.M)
    assert citation["version"] == changes[0] == snapmap.__version__


def test_the_wheel_has_every_folder_of_the_package_and_its_types(package, pyproject):
    folders = [path.parent.relative_to(package.parent) for path in package.rglob("__init__.py")]
    names, wheel = {".".join(folder.parts) for folder in folders}, pyproject["tool"]["setuptools"]
    assert {*wheel["packages"]} == names | {"snapmap.pipeline"}
    assert (package / "py.typed").exists() and "py.typed" in wheel["package-data"]["*"]


def test_a_missing_package_is_named_with_its_extra(pyproject):
    extras = pyproject["project"]["optional-dependencies"]
    needs = [(need, extra) for extra in extras for need in extras[extra] if "[" not in need]
    named = {re.match(r"\w+", need)[0]: extra for need, extra in needs}
    assert {key.replace("yaml", "pyyaml"): extra for key, extra in EXTRAS.items()} == named


def test_the_types_fit(root):
    """The command of CONTRIBUTING: 1 s, and 10 s where it has not run before."""
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def anchors(page):
    """Of headings, as a Markdown viewer makes them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_relative_links_lead_to_a_file_and_to_a_heading_of_it(root):
    for page in [*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("config/*.md")]:
        for link in re.findall(r"\]\((?![a-z]+:)([^)\s]+)\)", page.read_text(encoding="utf-8")):
            target, _, anchor = link.partition("#")
            path = page.parent / target if target else page
            assert path.exists(), f"{page.name}: {link}"
            assert not anchor or anchor in anchors(path), f"{page.name}: {link}"
