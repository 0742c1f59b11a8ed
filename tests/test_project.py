"""The project's own files agree with each other."""

import ast
import re
import runpy
import shutil
import subprocess
import sys
import tomllib

import pytest
import yaml
from jsonschema import Draft202012Validator

import snapmap
from snapmap.io.extras import EXTRAS

HOSTS = ("pypi" + ".org", "pythonhosted" + ".org", "conda" + ".anaconda", "anaconda" + ".org")
DOWNLOAD = re.compile(r"github\.com/\S*/(releases/download|archive|raw)/|://\S+\.(whl|tar\.gz)\b")


@pytest.fixture(scope="module")
def tracked(root):
    """Paths of the files that belong to the project, new ones too."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=root, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git repository")
    return [path for name in listed.stdout.splitlines() if (path := root / name).is_file()]


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


def test_the_page_on_architecture_names_files_and_types_that_there_are(root, architecture):
    scripts = root / "workflow" / "scripts"
    folders = root, root / "workflow", scripts, scripts / "snapmap"
    names = re.findall(r"`([\w/]+(?:/|\.(?:py|yaml)))`", architecture)
    assert len(names) > 15
    for name in names:
        assert any((folder / name).exists() for folder in folders), name
    types = re.findall(r"^\| `(\w+)`[^|]*\| `(\S+)` \|", architecture, re.M)
    assert len(types) > 2
    for kind, name in types:
        assert re.search(rf"^class {kind}\b", (folders[-1] / name).read_text(), re.M), kind


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


def test_the_workflow_has_what_its_catalog_asks_for(root, pyproject):
    needed = pyproject["project"]["optional-dependencies"]["workflow"]
    (snakemake,) = (one for one in needed if one.startswith("snakemake"))
    (least,) = re.findall(r'^min_version\("(.+)"\)', (root / "Snakefile").read_text(), re.M)
    assert snakemake.startswith(f"snakemake>={least},")
    assert 'include: "../Snakefile"' in (root / "workflow" / "Snakefile").read_text()
    assert (root / "config" / "README.md").exists()
    shown = yaml.safe_load((root / ".snakemake-workflow-catalog.yml").read_text())
    assert set(shown) == {"usage"} and shown["usage"]["report"] is True
    assert set(shown["usage"]["software-stack-deployment"].values()) == {False}


def test_hooks_have_the_versions_of_the_lock(root):
    lock = (root / "requirements.lock").read_text(encoding="utf-8")
    hooks = yaml.safe_load((root / ".pre-commit-config.yaml").read_text(encoding="utf-8"))
    revisions = {one["hooks"][0]["id"].split("-")[0]: one["rev"] for one in hooks["repos"]}
    for name in ("ruff", "snakefmt"):
        assert f"\n{name}=={revisions[name][1:]} " in lock


def test_the_forge_runs_commands_that_there_are(root):
    groups = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    optional = {re.match(r"[\w-]+", name)[0] for name in groups["dependency-groups"]["docs"]}
    files = list((root / ".github" / "workflows").glob("*.yml"))
    assert files
    for path in files:
        forge = yaml.safe_load(path.read_text(encoding="utf-8"))
        assert forge["permissions"] == {"contents": "read"}
        steps = [step for job in forge["jobs"].values() for step in job["steps"]]
        for step in steps:
            run, name, *_ = [*step.get("run", "./run uv").split(), ""]
            assert run == "./run" and (shutil.which(name) or name in optional), step
            assert re.fullmatch(r"[\w/-]+@v\d+", step.get("uses", "none@v1")), step


def test_the_citation_has_what_the_format_requires(root):
    citation = yaml.safe_load((root / "CITATION.cff").read_text(encoding="utf-8"))
    required = ["authors", "cff-version", "message", "title"]
    author = {"type": "object", "anyOf": [{"required": ["name"]}, {"required": ["family-names"]}]}
    schema = {
        "required": required,
        "properties": {
            "cff-version": {"const": "1.2.0"},
            "type": {"const": "software"},
            "license": {"const": "MIT"},
            "version": {"type": "string"},
            "authors": {"type": "array", "minItems": 1, "items": author},
            "keywords": {"type": "array", "items": {"type": "string"}},
            "date-released": {},
            **{key: {"type": "string"} for key in ("message", "title", "abstract", "doi")},
        },
        "additionalProperties": False,
    }
    Draft202012Validator(schema).validate(citation)


def test_the_types_of_beam_and_solver_fit(root):
    """The command of CONTRIBUTING: 1 s, and 10 s where it has not run before."""
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy"], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout


def test_relative_links_lead_somewhere(tracked):
    pages = [path for path in tracked if path.suffix == ".md"]
    assert len(pages) > 5
    for page in pages:
        for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
            if not re.match(r"[a-z]+:", link):
                target, _, anchor = link.partition("#")
                path = page.parent / target if target else page
                assert path.exists(), f"{page.name}: {link}"
                assert not anchor or anchor in anchors(path), f"{page.name}: {link}"


def anchors(page):
    """Headings as the anchors that a Markdown viewer makes of them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.M)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_no_file_names_a_package_host(tracked):
    for path in tracked:
        text = path.read_bytes().decode("utf-8", errors="ignore")
        assert not [host for host in HOSTS if host in text], path
        if path.suffix in (".lock", ".toml", ".yaml", ".txt"):
            assert not DOWNLOAD.search(text), path
