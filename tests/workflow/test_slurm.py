"""The workflow by Slurm's executor, with stubs of its commands: the cube is a local run's."""

import os
import re
import shutil
import subprocess
from importlib.util import find_spec

import numpy as np
import pytest
import xarray as xr
import yaml
from products import assert_whole
from small_studies import TINY, cases_of

from snapmap.applications.whole import load_config
from snapmap.sweeps.slabs import slab_name
from snapmap.workflow.plan import make_plan

IN_SLABS = TINY.replace("points: 8", "points: 24000")
"""A grid that takes longer than the start of a job: a slab for each C."""


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """The environment of Slurm as users see it, and the file of what jobs asked for.

    A job runs while it is handed in.
    """
    folder = tmp_path_factory.mktemp("slurm")
    for name, text in cases_of(__file__).items():
        (folder / name).write_text(f"#!/bin/sh\n{text.format(asked=folder / 'asked')}\n")
        (folder / name).chmod(0o755)
    return os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"}, folder / "asked"


@pytest.fixture(scope="module")
def clone(root, tmp_path_factory):
    """A clone with Slurm's executor in a .venv of its own."""
    clone = tmp_path_factory.mktemp("project") / "clone"
    ignore = shutil.ignore_patterns(".venv*", ".git", "results", ".snakemake", "__pycache__")
    shutil.copytree(root, clone, ignore=ignore)
    lock = ["--require-hashes", "--requirements", "locks/requirements-slurm.lock"]
    subprocess.run([clone / "run", "uv", "pip", "install", *lock], cwd=clone, check=True)
    return clone


def workflow(clone, folder, *options):
    """The command that makes a study in `folder`."""
    (folder / "tiny.yaml").write_text(IN_SLABS)
    command = [clone / "run", "snapmap", "run", folder / "tiny.yaml"]
    return [*command, "--directory", folder, *options]


@pytest.fixture(scope="module")
def remote(cluster, clone, tmp_path_factory):
    """A finished run on the cluster: its folder, and what each job asked for."""
    folder, (environment, asked) = tmp_path_factory.mktemp("remote"), cluster
    command = workflow(clone, folder, "--profile", clone / "profiles" / "slurm")
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    words = r"--comment (\S+) .*--mem (\d+) .*--cpus-per-task=(\d+)"
    return folder, re.findall(words, asked.read_text())


def contents(path):
    """Every variable of a netCDF file: its type, shape and bytes."""
    with xr.open_dataset(path, decode_cf=False) as file:
        variables = {name: file[name].variable for name in file.variables}
        return {name: (v.dtype.str, v.shape, v.values.tobytes()) for name, v in variables.items()}


def test_a_slab_asks_for_more_the_more_there_is_to_do(monkeypatch):
    monkeypatch.setattr("snapmap.workflow.plan.JOB_SECONDS", np.inf)

    document = yaml.safe_load(TINY)

    def request(f0, points):
        axes = {"f0": [f0], "N": {"from": 600, "to": 20600, "points": points}, "C": ["1 kg/s"]}
        study = load_config(document | {"sweep": document["sweep"] | axes})
        (request,) = make_plan(study).requests
        return request

    one, many, longer = request("100 Hz", 2), request("100 Hz", 200_000), request("10 Hz", 200_000)
    assert one.mem_mb < many.mem_mb == longer.mem_mb
    assert 1 <= one.runtime < many.runtime < longer.runtime


@pytest.mark.skipif(find_spec("snakemake_executor_plugin_slurm"), reason="it is there")
def test_the_profile_without_its_plugin_says_what_to_install(root, tmp_path):
    command = ["snakemake", "--snakefile", root / "Snakefile", "--profile", root / "profiles/slurm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    _, last = done.stderr.splitlines()
    assert done.returncode == 1 and last.endswith("locks/requirements-slurm.lock")


@pytest.mark.long
def test_the_cube_is_that_of_a_local_run_bit_for_bit(clone, remote, tmp_path):
    subprocess.run([*workflow(clone, tmp_path, "--cores", "2"), "results/cube.nc"], check=True)
    local = contents(tmp_path / "results" / "cube.nc")
    assert {"C", "f0", "N", "outcome", "t_snap", "energy_error"} <= set(local)
    assert contents(remote[0] / "results" / "cube.nc") == local


@pytest.mark.long
def test_every_job_went_through_slurm_with_what_it_asked_for(remote):
    folder, jobs = remote
    study = load_config(yaml.safe_load(IN_SLABS))
    plan = make_plan(study)
    names = [slab_name(study, slab) for slab in plan.slabs]
    assert {*names} == {path.stem for path in (folder / "results" / "slabs").glob("*.nc")}
    asked = {name: (processors, memory) for name, memory, processors in jobs}
    (drawing,) = (name for name in asked if name.startswith("rule_figures_"))
    processors, memory = asked.pop(drawing)
    assert processors == "4" and int(memory) >= 2000, "all figures in one job"
    assert len(names) == 2 and asked == {
        "rule_find_threshold": ("2", "2000"),
        "rule_find_stress": ("2", "2000"),
        "rule_simulate_histories": ("1", "1000"),
        "rule_collect": ("1", "2000"),
    } | {
        f"rule_simulate_slab_wildcards_{name}": ("1", f"{request.mem_mb}")
        for name, request in zip(names, plan.requests, strict=True)
    }
    assert_whole(folder, study)
