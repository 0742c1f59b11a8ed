"""The workflow on a real Slurm of one node, started here: the cube is that of a local run."""

import getpass
import os
import shutil
import socket
import subprocess
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from products import assert_whole
from small_studies import TINY
from small_workflow import wait_for

from snapmap.applications.whole import load_config
from snapmap.sweeps.slabs import slab_name
from snapmap.workflow.plan import make_plan

PROGRAMS = ("munged", "slurmctld", "slurmd", "sinfo", "sbatch", "srun")
IN_SLABS = TINY.replace("points: 8", "points: 8000")
"""A grid that takes longer than the start of a job: a slab for each C."""
SLURM = (Path(__file__).parent / "slurm.conf").read_text()
# Any plugin that starts without a mounted cgroup: nothing above uses one.
CGROUP = "CgroupPlugin=cgroup/v1\n"
# The executor's job step drops SLURM_CONF from the environment in which it calls srun.
SRUN = "#!/bin/sh\nSLURM_CONF='{folder}/slurm.conf' exec '{srun}' \"$@\"\n"
MUNGE = {"key-file": "key", "socket": "socket", "pid-file": "pid", "seed-file": "seed"}
MUNGE |= {"log-file": "txt"}


class Cluster:
    """A Slurm in a folder: its daemons, and its commands, told where their configuration is."""

    def __init__(self, folder):
        path = f"{os.environ['PATH']}:/usr/sbin:/sbin"
        self.folder = folder
        self.programs = {name: shutil.which(name, path=path) for name in PROGRAMS}
        if missing := [name for name in PROGRAMS if not self.programs[name]]:
            pytest.skip(f"not installed: {', '.join(missing)}; apt install slurmctld slurmd munge")
        self.environment = os.environ | {
            "SLURM_CONF": str(folder / "slurm.conf"),
            "PATH": f"{folder}/bin:{os.environ['PATH']}",
        }
        for name in ("bin", "state", "spool"):
            (folder / name).mkdir()
        facts = {"folder": folder, "user": getpass.getuser(), "ports": free_ports(2)}
        (folder / "munge.key").write_bytes(os.urandom(128))
        (folder / "munge.key").chmod(0o400)
        (folder / "slurm.conf").write_text(SLURM.format(**facts))
        (folder / "cgroup.conf").write_text(CGROUP)
        (folder / "bin" / "srun").write_text(SRUN.format(folder=folder, srun=self.programs["srun"]))
        (folder / "bin" / "srun").chmod(0o755)

    @contextmanager
    def daemon(self, name, *options):
        """A daemon in the foreground, its output in the folder; ended with the block."""
        with open(self.folder / f"{name}.log", "w") as log:
            command = [self.programs[name], *options]
            process = subprocess.Popen(command, env=self.environment, stdout=log, stderr=log)
            try:
                yield
            finally:
                process.terminate()
                if not wait_for(lambda: process.poll() is not None, 10):
                    process.kill()
                    process.wait()

    def ask(self, *command):
        """What a Slurm command prints; empty where it fails, as before the daemons are up."""
        done = subprocess.run(command, env=self.environment, capture_output=True, text=True)
        return done.stdout.strip() if done.returncode == 0 else ""

    def end_jobs(self):
        self.ask("scancel", "--me")
        wait_for(lambda: not self.ask("squeue", "--noheader"), 30)

    def jobs(self, folder):
        """The jobs of a workflow's run in `folder`, in order, each a dict of Slurm's facts."""
        lines = self.ask("scontrol", "--oneliner", "show", "jobs").splitlines()
        facts = [dict(word.split("=", 1) for word in line.split() if "=" in word) for line in lines]
        mine = [job for job in facts if job.get("StdOut", "").startswith(f"{folder}/")]
        return sorted(mine, key=lambda job: int(job["JobId"]))


def free_ports(count):
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [each.getsockname()[1] for each in sockets]


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    """A running Slurm with four processors of which it only believes that they are there."""
    folder = tmp_path_factory.mktemp("slurm")
    cluster = Cluster(folder)
    files = [f"--{kind}={folder}/munge.{ending}" for kind, ending in MUNGE.items()]
    with ExitStack() as stack:
        stack.enter_context(cluster.daemon("munged", "--foreground", "--force", *files))
        wait_for((folder / "munge.socket").exists, 10)
        stack.enter_context(cluster.daemon("slurmctld", "-D"))
        stack.enter_context(cluster.daemon("slurmd", "-D", "-N", "one"))
        if not wait_for(lambda: cluster.ask("sinfo", "--noheader", "-o", "%T") == "idle", 60):
            last = [path.read_text().strip().split("\n")[-1] for path in folder.glob("*.log")]
            pytest.skip(f"Slurm did not come up: {'; '.join(last)}")
        stack.callback(cluster.end_jobs)
        yield cluster


@pytest.fixture(scope="module")
def clone(cluster, root, tmp_path_factory):
    """A clone with Slurm's executor in a .venv of its own; not made where there is no cluster."""
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
    """A finished run on the cluster: its folder and its jobs."""
    folder = tmp_path_factory.mktemp("remote")
    command = workflow(clone, folder, "--profile", clone / "profiles" / "slurm")
    done = subprocess.run(command, env=cluster.environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return folder, cluster.jobs(folder)


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
    assert all(job["JobState"] == "COMPLETED" and job["NodeList"] == "one" for job in jobs)
    study = load_config(yaml.safe_load(IN_SLABS))
    plan = make_plan(study)
    names = [slab_name(study, slab) for slab in plan.slabs]
    assert {*names} == {path.stem for path in (folder / "results" / "slabs").glob("*.nc")}
    asked = {job["Comment"]: (job["NumCPUs"], job["MinMemoryNode"]) for job in jobs}
    (drawing,) = (comment for comment in asked if comment.startswith("rule_figures_"))
    processors, memory = asked.pop(drawing)
    assert processors == "4" and int(memory.rstrip("M")) >= 2000, "all figures in one job"
    assert len(names) == 2 and asked == {
        "rule_find_threshold": ("2", "2000M"),
        "rule_find_stress": ("2", "2000M"),
        "rule_simulate_histories": ("1", "1000M"),
        "rule_collect": ("1", "2000M"),
    } | {
        f"rule_simulate_slab_wildcards_{name}": ("1", f"{request.mem_mb}M")
        for name, request in zip(names, plan.requests, strict=True)
    }
    assert_whole(folder, study)
