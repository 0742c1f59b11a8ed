"""The wheel, made from the sdist, in fresh environments: the newest packages, and the oldest.

What other systems install is resolved here, and not installed.
"""

import os
import subprocess
import sys

import numpy as np
import pytest
from small_studies import TINY, cases_of

import snapmap
from snapmap.solver.outcome import LATCHED, NEVER, RETURNED, SNAPPED

pytestmark = pytest.mark.long

SOLVER = {"matplotlib", "netcdf4", "numba", "numpy", "scipy", "xarray"}
CASES = cases_of(__file__)


@pytest.fixture(scope="module")
def wheel(root, tmp_path_factory):
    """The wheel that is made from the sdist of the files that git knows, or would."""
    folder = tmp_path_factory.mktemp("made")
    source = folder / "source"
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in subprocess.check_output(command, cwd=root, text=True).split("\0")[:-1]:
        if (root / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((root / name).read_bytes())
    subprocess.run(["uv", "build", "--quiet", "--out-dir", folder, source], check=True)
    (wheel,) = folder.glob("*.whl")
    return wheel


@pytest.fixture(params=["highest", "lowest-direct"])
def installed(request, root, wheel, tmp_path):
    """A function that installs the wheel with extras and one that runs a command of it."""
    venv, packages = tmp_path / "venv", tmp_path / "packages.txt"

    def uv(command, *words):
        subprocess.run(["uv", *command.split(), "--quiet", *words], cwd=root, check=True)

    def install(*extras):
        uv("venv", "--python", sys.executable, venv)
        asked = ["--resolution", request.param, "--output-file", packages, *extras]
        uv("pip compile", "--python", sys.executable, *asked, "pyproject.toml")
        uv("pip install", "--python", venv / "bin" / "python", "--requirements", packages, wheel)

    def run(command, *words):
        how = {"env": {key: os.environ[key] for key in os.environ if key != "PYTHONPATH"}}
        command = [venv / "bin" / command, *words]
        return subprocess.run(command, capture_output=True, text=True, cwd=tmp_path, **how)

    return install, run


SYSTEMS = "x86_64-manylinux_2_28", "aarch64-manylinux_2_28", "aarch64-apple-darwin"


@pytest.mark.parametrize("python", ["3.11", "3.13", "3.14"])
@pytest.mark.parametrize("system", SYSTEMS)
def test_every_system_installs_from_wheels(root, tmp_path, system, python):
    """The locked packages, and the newest that `pip install '.[all]'` takes; macOS from 15 on."""
    built = ["connection-pool", *(["immutables"] if python == "3.14" else [])]
    asked = ["--quiet", "--python-platform", system, "--python-version", python]
    asked += ["--only-binary", ":all:", *(f"--no-binary={name}" for name in built)]
    environment = os.environ | {"MACOSX_DEPLOYMENT_TARGET": "15.0"}
    lock = ["--require-hashes", "--requirements", "locks/requirements.lock"]
    for packages in (lock, ["--requirements", "pyproject.toml", "--extra", "all"]):
        command = ["uv", "pip", "install", "--dry-run", "--target", tmp_path, *asked, *packages]
        done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_the_solver_needs_eight_packages(installed, handout):
    """As few as there are; a missing one is a line, and the threshold is that of the checkout."""
    install, run = installed
    install()
    done = run("python", "-I", "-c", CASES["solve"])
    assert done.returncode == 0, done.stderr
    packages, numbers = done.stdout.splitlines()
    assert SOLVER < {*packages.split()} <= SOLVER | {*CASES["brought"]} | {"snapmap"}
    first, error = map(float, numbers.split())
    edge = snapmap.threshold(handout, f0=[1500.0], C=[25.0])
    assert first == pytest.approx(edge.N_first.item(), abs=error)
    assert run("snapmap", "init").returncode == 0
    for verb, package in (("check", "yaml"), ("run", "snakemake")):
        refused = run("snapmap", verb, "config.yaml")
        assert refused.returncode == 1
        assert refused.stderr.startswith(f"snapmap {verb} needs {package}: pip install 'snapmap[")


def test_with_all_extras_every_function_and_the_workflow_run(root, installed, tmp_path):
    install, run = installed
    install("--extra", "all")
    (tmp_path / "config").symlink_to(root / "config")
    done = run("python", "-I", "-c", CASES["examples"])
    assert done.returncode == 0, done.stdout + done.stderr
    (tmp_path / "small.yaml").write_text(TINY)
    for verb in ("check", "run"):
        done = run("snapmap", verb, "small.yaml")
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "results" / "explore.html").exists()
    cube = snapmap.open_cube(tmp_path / "results" / "cube.nc")
    assert np.isin(cube.outcome, [NEVER, SNAPPED, LATCHED, RETURNED]).all()
