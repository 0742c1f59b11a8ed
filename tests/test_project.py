"""The project's own files agree with each other."""

import ast
import re
import runpy
import subprocess
import sys
import tomllib

import pytest
import yaml

import snapmap
from snapmap.applications import attached
from snapmap.files.extras import EXTRAS


def test_the_config_reference_is_what_the_models_say(root):
    page = (root / "docs" / "config.md").read_text(encoding="utf-8")
    assert runpy.run_path(root / "docs" / "make_config_reference.py")["reference"]() == page


CORE = ("numerics", "files", "device", "pulse", "beam", "solver", "study", "thresholds", "sweeps")
SHELL = ("config", "figures", "workflow", "public")
LISTING = ("config", "public", "workflow")
"""Who reads the list of applications, which holds names alone."""
MOST_LINES = {"core": 10_100, "shell": 4_000, "application": 900}


def rooms_of(path, package):
    """The room of a file: a folder or module at the top of the package, or an application."""
    parts = path.relative_to(package).with_suffix("").parts
    is_application = parts[0] == "applications" and len(parts) > 2
    return "/".join(parts[:2]) if is_application else parts[0]


def imported(path, package):
    """The rooms that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1]
            modules = [node.module] if node.module else [name.name for name in node.names]
            for module in modules:
                target = base.joinpath(*module.split("."))
                if target.is_dir() and target != package:
                    yield rooms_of(target / "__init__.py", package)
                elif target.with_suffix(".py").exists():
                    yield rooms_of(target, package)


@pytest.fixture(scope="module")
def package(root):
    return root / "workflow" / "scripts" / "snapmap"


def test_rooms_import_those_before_them_and_the_core_no_application(package):
    ranks = {name: rank for rank, name in enumerate((*CORE, *SHELL))}
    for path in set(package.rglob("*.py")) - {package / "__init__.py"}:
        room = rooms_of(path, package)
        for other in set(imported(path, package)) - {room}:
            where = f"{path.relative_to(package)} imports {other}"
            if room.startswith("applications/"):
                known = (*CORE, *SHELL[:-1], "applications")
                assert other.startswith("applications/") or other in known, where
            elif other == "applications":
                assert room in LISTING, where
            else:
                assert room in SHELL or other in CORE, where
                assert ranks[other] < ranks[room], where


def test_an_application_imports_those_that_its_first_line_names(package):
    for name, application in attached().items():
        first = application.__doc__.partition("\n")[0]
        named = re.findall(r"\w+", first.partition("Imports:")[2].replace("core alone", ""))
        folder = package / "applications" / name
        rooms = {room for path in folder.rglob("*.py") for room in imported(path, package)}
        rooms -= {f"applications/{name}", "applications"}
        used = {room.partition("/")[2] for room in rooms if room.startswith("applications/")}
        assert used <= {*named}, (name, used)


def test_rooms_are_no_larger_than_one_reads(package):
    def lines(*rooms):
        files = [path for path in package.rglob("*.py") if rooms_of(path, package) in rooms]
        return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files)

    assert lines(*CORE) <= MOST_LINES["core"] and lines(*SHELL) <= MOST_LINES["shell"]
    for name in attached():
        assert lines(f"applications/{name}") <= MOST_LINES["application"], name


def test_the_page_on_architecture_names_every_room_and_each_application_has_a_page(root, package):
    page = (root / "docs" / "architecture.md").read_text(encoding="utf-8")
    (tree,) = re.findall(r"```text\n(.*?)```", page, re.S)
    words = set(re.findall(r"\w+", tree))
    assert {*CORE, *SHELL, *attached()} <= words
    folders = {path.name for path in package.iterdir() if (path / "__init__.py").exists()}
    assert folders <= {*CORE, *SHELL, "applications"}
    pages = {page.stem for page in (root / "docs" / "applications").glob("*.md")}
    assert {*attached()} <= pages


@pytest.fixture(scope="module")
def pyproject(root):
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_version_is_the_same_everywhere(root, pyproject):
    assert pyproject["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "snapmap.__version__"}
    citation = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    changes = re.findall(r"^## \[?(\d+\.\d+\.\d+)", (root / "CHANGELOG.md").read_text(), re.M)
    versions = {citation["version"], changes[0], snapmap.__version__}
    assert len(versions) == 1, versions


def test_the_wheel_has_every_folder_of_the_package_and_its_types(package, pyproject):
    folders = [path.parent.relative_to(package.parent) for path in package.rglob("__init__.py")]
    names, told = {".".join(folder.parts) for folder in folders}, pyproject["tool"]["setuptools"]
    assert {*told["packages"]} == names | {"snapmap.pipeline"}
    assert (package / "py.typed").exists() and "py.typed" in told["package-data"]["*"]


def test_a_missing_package_is_named_with_its_extra(pyproject):
    extras = pyproject["project"]["optional-dependencies"]
    named = {extra: {re.match(r"\w+", one)[0] for one in extras[extra]} for extra in extras}
    for package, extra in EXTRAS.items():
        assert {"yaml": "pyyaml"}.get(package, package) in named[extra]
    assert len(EXTRAS) == sum("snapmap[" not in one for extra in extras.values() for one in extra)


def test_the_types_of_beam_and_solver_fit(root):
    """The command of CONTRIBUTING: 1 s, and 10 s where it has not run before."""
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_relative_links_lead_somewhere(root):
    """To a file, and to a heading of it, as a Markdown viewer makes anchors of them."""
    for page in [*root.glob("*.md"), *root.glob("docs/**/*.md"), *root.glob("config/*.md")]:
        for link in re.findall(r"\]\((?![a-z]+:)([^)\s]+)\)", page.read_text(encoding="utf-8")):
            target, _, anchor = link.partition("#")
            path = page.parent / target if target else page
            assert path.exists(), f"{page.name}: {link}"
            if anchor:
                heads = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.M)
                plain = {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
                assert anchor in plain, f"{page.name}: {link}"
