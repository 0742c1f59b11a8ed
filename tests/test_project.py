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
from snapmap.files.extras import EXTRAS


def test_the_config_reference_is_what_the_models_say(root):
    page = (root / "docs" / "config.md").read_text(encoding="utf-8")
    assert runpy.run_path(root / "docs" / "make_config_reference.py")["reference"]() == page


@pytest.fixture(scope="module")
def architecture(root):
    return (root / "docs" / "architecture.md").read_text(encoding="utf-8")


def imported(path, package):
    """The folders and modules at the top of the package that a file imports."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1]
            targets = [node.module] if node.module else [name.name for name in node.names]
            for target in targets:
                yield base.joinpath(*target.split(".")).relative_to(package).parts[0]


def test_imports_point_as_the_page_on_architecture_shows(root, architecture):
    package = root / "workflow" / "scripts" / "snapmap"
    (diagram,) = re.findall(r"```text\n(.*?)```", architecture, re.S)
    lines = [re.findall(r"(\w+)(?:/|\.py)(?= |$)", line[:38]) for line in diagram.splitlines()]
    level = {name: place for place, names in enumerate(lines) for name in names}
    files = [path for path in package.rglob("*.py") if path != package / "__init__.py"]
    top = {path: path.relative_to(package).with_suffix("").parts[0] for path in files}
    assert set(level) == set(top.values())
    for path, name in top.items():
        for other in set(imported(path, package)) & set(level) - {name}:
            assert level[other] < level[name], f"{path.relative_to(package)} imports {other}"


@pytest.fixture(scope="module")
def pyproject(root):
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))


def test_the_version_is_the_same_everywhere(root, pyproject):
    assert pyproject["tool"]["setuptools"]["dynamic"]["version"] == {"attr": "snapmap.__version__"}
    citation = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    changes = re.findall(r"^## \[?(\d+\.\d+\.\d+)", (root / "CHANGELOG.md").read_text(), re.M)
    versions = {citation["version"], changes[0], snapmap.__version__}
    assert len(versions) == 1, versions


def test_the_wheel_has_every_folder_of_the_package(root, pyproject):
    scripts = root / "workflow" / "scripts"
    folders = [path.parent.relative_to(scripts) for path in scripts.rglob("snapmap/**/__init__.py")]
    names = {".".join(folder.parts) for folder in folders}
    assert {*pyproject["tool"]["setuptools"]["packages"]} == names | {"snapmap.pipeline"}


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
    for page in [*root.glob("*.md"), *root.glob("docs/*.md"), *root.glob("config/*.md")]:
        for link in re.findall(r"\]\((?![a-z]+:)([^)\s]+)\)", page.read_text(encoding="utf-8")):
            target, _, anchor = link.partition("#")
            path = page.parent / target if target else page
            assert path.exists(), f"{page.name}: {link}"
            if anchor:
                heads = re.findall(r"^#+ (.+)$", path.read_text(encoding="utf-8"), re.M)
                plain = {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
                assert anchor in plain, f"{page.name}: {link}"
