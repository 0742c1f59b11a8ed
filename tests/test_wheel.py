"""The wheel, made from the sdist, in fresh environments: the newest packages, and the oldest."""

import subprocess
import sys

import numpy as np
import pytest
import yaml

import snapmap
from snapmap.config.yaml_file import read_document

pytestmark = pytest.mark.long

SOLVER = {"matplotlib", "netcdf4", "numba", "numpy", "scipy", "xarray"}
BROUGHT = {"certifi", "cftime", "contourpy", "cycler", "fonttools", "kiwisolver", "llvmlite"}
BROUGHT |= {"packaging", "pandas", "pillow", "pyparsing", "python-dateutil", "pytz", "six"}
BROUGHT |= {"tzdata"}
"""By the six, some of them by old versions."""

SOLVE = """
import snapmap
from snapmap.device import Beam, Device

beam = Beam(600.0, 10.0, 2.0, 22.0, youngs_modulus=1.5e5, density=2.33e-3)
device = Device(beam, mass=1e4, spring=5.5, contact=40.0, gravity=9.81e-6)
edge = snapmap.threshold(device, f0=[1500.0], C=[25.0])
print(edge.N_first.item(), edge.N_error.item())
"""
PACKAGES = """
from importlib.metadata import distributions

print(*(one.name.lower().replace("_", "-") for one in distributions()))
"""
EXAMPLES = """
import doctest, sys, warnings
import snapmap

warnings.simplefilter("ignore")
for name in snapmap.__all__:
    function = getattr(snapmap, name)
    finder = doctest.DocTestFinder(recurse=False)
    (example,) = finder.find(function, name, globs={"snapmap": snapmap})
    assert not doctest.DocTestRunner().run(example).failed, name
"""


@pytest.fixture(scope="module")
def made(root, tmp_path_factory):
    """The folder of the sdist and the wheel that is made from it."""
    folder = tmp_path_factory.mktemp("made")
    source = folder / "source"
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    for name in subprocess.check_output(command, cwd=root, text=True).split("\0")[:-1]:
        if (root / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((root / name).read_bytes())
    subprocess.run(["uv", "build", "--quiet", "--out-dir", folder, source], check=True)
    return folder


@pytest.fixture(params=["highest", "lowest-direct"])
def installed(request, root, made, tmp_path):
    """A function that installs the wheel with extras and one that runs a command of it."""
    venv = tmp_path / "venv"
    subprocess.run(["uv", "venv", "--quiet", "--python", sys.executable, venv], check=True)
    (wheel,) = made.glob("*.whl")

    def install(*extras):
        asked = [word for extra in extras for word in ("--extra", extra)]
        command = ["uv", "pip", "compile", "--quiet", "--python", sys.executable]
        command += ["--resolution", request.param, "--output-file", tmp_path / "packages.txt"]
        subprocess.run([*command, *asked, "pyproject.toml"], cwd=root, check=True)
        command = ["uv", "pip", "install", "--quiet", "--python", venv / "bin" / "python"]
        command += ["--requirements", tmp_path / "packages.txt", wheel]
        subprocess.run(command, cwd=root, check=True)

    def run(command, *words):
        told = {"capture_output": True, "text": True, "cwd": tmp_path}
        return subprocess.run([venv / "bin" / command, *words], **told)

    return install, run


def test_the_solver_needs_six_packages(installed, handout):
    """As few as there are; a missing one is a line, and the threshold is that of the checkout."""
    install, run = installed
    install()
    listed = run("python", "-c", PACKAGES).stdout.split()
    assert SOLVER < set(listed) <= SOLVER | BROUGHT | {"snapmap"}
    done = run("python", "-I", "-c", SOLVE)
    assert done.returncode == 0, done.stderr
    edge = snapmap.threshold(handout, f0=[1500.0], C=[25.0])
    found, error = map(float, done.stdout.split())
    assert found == pytest.approx(edge.N_first.item(), abs=error)
    assert run("snapmap", "init").returncode == 0
    for verb, package in (("check", "pydantic"), ("run", "snakemake")):
        refused = run("snapmap", verb, "config.yaml")
        assert refused.returncode == 1
        assert refused.stderr.startswith(f"snapmap {verb} needs {package}: pip install 'snapmap[")


def test_with_all_extras_every_function_and_the_workflow_run(root, installed, tmp_path):
    install, run = installed
    install("all")
    (tmp_path / "config").symlink_to(root / "config")
    done = run("python", "-I", "-c", EXAMPLES)
    assert done.returncode == 0, done.stdout + done.stderr
    document = read_document(root / "config" / "config.yaml")
    sweep = {"N": [700, 1000], "f0": ["500 Hz", "1500 Hz"], "C": ["25 uN*us/um"]}
    sweep |= {"horizon": "300 us", "until": "snap"}
    small = document | {"sweep": sweep, "model": {"name": "cosines", "modes": 3}}
    (tmp_path / "small.yaml").write_text(yaml.safe_dump(small))
    for verb in ("check", "run"):
        done = run("snapmap", verb, "small.yaml")
        assert done.returncode == 0, done.stderr
    assert (tmp_path / "results" / "explore.html").exists()
    cube = snapmap.open_cube(tmp_path / "results" / "cube.nc")
    assert np.isin(cube.outcome, ["never", "latched", "returned", "snapped"]).all()
