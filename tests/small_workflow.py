"""The workflow as a process of its own."""

import subprocess


def snakemake(root, folder, config, *options, check=True):
    """Run the workflow of the clone `root` in `folder`; returns its exit code and output."""
    command = ["snakemake", "--snakefile", root / "Snakefile", "--directory", folder]
    command += ["--configfile", config, "--cores", "2", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    output = done.stdout + done.stderr
    assert not check or done.returncode == 0, output
    return done.returncode, output
