"""The workflow as a process of its own."""

import subprocess


def snakemake(root, folder, config, *options, cores="2", check=True):
    """Run the workflow of the clone `root` in `folder`; returns its exit code and output.

    cores: as of --cores, which "" leaves out
    """
    command = ["snakemake", "--snakefile", root / "Snakefile", "--directory", folder]
    command += ["--configfile", config]
    if cores:  # it ends the list of configs
        command += ["--cores", cores]
    command += options
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    output = done.stdout + done.stderr
    assert not check or done.returncode == 0, output
    return done.returncode, output
