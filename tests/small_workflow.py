"""The workflow: run in a process of its own, or planned in a copy of this one."""

import subprocess
import sys
import time
from multiprocessing import get_context
from tempfile import NamedTemporaryFile

FORKS = get_context("forkserver")  # it has no threads, which could hold a lock in a fork
FORKS.set_forkserver_preload(["numpy", "snakemake.cli"])


def snakemake(root, folder, config, *options, cores="2", check=True):
    """Run the workflow of the clone `root` in `folder`; returns its exit code and output.

    What runs no job is done in a fork of a process that has imported what takes long; but not on
    macOS, where libraries do not outlive a fork.
    cores: as of --cores, which "" leaves out
    """
    command = ["--snakefile", root / "Snakefile", "--directory", folder, "--configfile", config]
    if cores:  # it ends the list of configs
        command += ["--cores", cores]
    command = [str(word) for word in (*command, *options)]
    if sys.platform == "linux" and {"--dry-run", "--lint"} & {*options}:
        with NamedTemporaryFile("w+") as said:
            plan = FORKS.Process(target=_plan, args=(command, said.name))
            plan.start()
            plan.join()
            code, output = plan.exitcode, said.read()
    else:
        done = subprocess.run(["snakemake", *command], capture_output=True, text=True, timeout=600)
        code, output = done.returncode, done.stdout + done.stderr
    assert not check or code == 0, output
    return code, output


def _plan(command, said):
    from snakemake.cli import main

    sys.stdout = sys.stderr = open(said, "w")  # noqa: SIM115, until the process ends
    main(command)


def wait_for(what, seconds=60):
    """What a function returns once that is true, or last after so many seconds."""
    end = time.monotonic() + seconds
    while not (answer := what()) and time.monotonic() < end:
        time.sleep(0.02)
    return answer
