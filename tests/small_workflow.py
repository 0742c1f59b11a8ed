"""The workflow, run in a copy of a process that has imported what takes long."""

import atexit
import os
import subprocess
import sys
import time
from multiprocessing import get_context
from tempfile import NamedTemporaryFile

FORKS = get_context("forkserver")  # it has no threads, which could hold a lock in a fork
PRELOADED = "snakemake.cli", "snakemake.report.html_reporter", "smart_open", "nbformat", "netCDF4"
FORKS.set_forkserver_preload([*PRELOADED])


def snakemake(root, folder, config, *options, cores="2", check=True, snakefile="Snakefile"):
    """Run the workflow of the clone `root` in `folder`; returns its exit code and output.

    On macOS, where libraries do not outlive a fork, it has a process of its own.
    cores: as of --cores, which "" leaves out
    """
    command = ["--snakefile", root / snakefile, "--directory", folder, "--configfile", config]
    if cores:  # it ends the list of configs
        command += ["--cores", cores]
    command = [str(word) for word in (*command, *options)]
    if sys.platform == "linux":
        with NamedTemporaryFile("w+") as said:
            run = FORKS.Process(target=_run, args=(command, said.name))
            run.start()
            run.join(600)
            code, output = run.exitcode, said.read()
    else:
        done = subprocess.run(["snakemake", *command], capture_output=True, text=True, timeout=600)
        code, output = done.returncode, done.stdout + done.stderr
    assert code is not None and (code == 0 or not check), output
    return code, output


def _run(command, said):
    from snakemake.cli import main

    sys.stdout = sys.stderr = open(said, "w", 1)  # noqa: SIM115, until the process ends
    for output in (1, 2):  # of jobs
        os.dup2(sys.stdout.fileno(), output)
    try:
        main(command)
    finally:
        atexit._run_exitfuncs()  # as a process does that is not forked


def wait_for(what, seconds=60):
    """What a function returns once that is true, or last after so many seconds."""
    end = time.monotonic() + seconds
    while not (answer := what()) and time.monotonic() < end:
        time.sleep(0.02)
    return answer
