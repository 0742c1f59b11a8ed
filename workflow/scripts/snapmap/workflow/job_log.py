"""A rule's script: its arguments, and its log."""

import inspect
import os
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path
from threading import Thread

from ..files.counting import counting

RUN = "SNAPMAP_RUN"
"""The variable of the environment with the process of a job's run."""
SHELL_PREFIX = f"trap '' INT; {RUN}=$PPID exec "
"""Of a job's command: its run becomes its parent. Ctrl-C, which a terminal sends to all, is left to
the run, which ends its jobs: one that began to import would answer with a traceback."""
LOOK_AROUND = 1.0
"""Seconds after which a job looks whether its run is still there."""


def run_rule(function: Callable, job, study_of: Callable | None = None) -> None:
    """Call a script's function with what its job has under the names of its parameters.

    job: the `snakemake` object. A parameter is one of its wildcards or params, or NAME_path
    (several: NAME_paths) of an input or output NAME; `path` is the first output and `folder` where
    it lies, `threads` what the job may use; `study` is what study_of makes of the run's config and
    threads.
    """
    first = Path(job.output[0])
    threads = max(1, job.threads)
    values = {"path": str(first), "folder": first.parent, "threads": threads}
    values |= {**dict(job.wildcards.items()), **dict(job.params.items())}
    for name, files in [*job.input.items(), *job.output.items()]:
        values[f"{name}_path" if isinstance(files, str) else f"{name}_paths"] = files
    wanted = inspect.signature(function).parameters
    end_with(int(os.environ[RUN]))
    with job_log(job.log[0]), _counted(job.log[0]):
        if "study" in wanted:
            values["study"] = study_of(job.config, threads)
        function(**{name: values[name] for name in wanted if name in values})
    os._exit(0)  # all is written; to take down what was imported would take a sixth of a job


@contextmanager
def job_log(path: str | Path) -> Iterator[None]:
    """Keep what a script prints in its log, and its warnings there and on the terminal.

    Snakemake shows the log of a job that fails. A fault that the user can mend (ValueError,
    OSError, MemoryError) is one line there; any other a traceback.
    """
    complaint = ""
    log = open(path, "w", buffering=1, encoding="utf-8")  # noqa: SIM115, closing may fail, too
    terminal = sys.stderr

    def warn(message, *_, **__):
        for stream in (log, terminal):
            print(message, file=stream)

    with redirect_stdout(log), redirect_stderr(log), warnings.catch_warnings():
        warnings.showwarning = warn
        try:
            yield
        except (MemoryError, OSError, ValueError) as fault:
            complaint = str(fault) or type(fault).__name__
        except Exception:
            complaint = traceback.format_exc()
    if complaint:
        try:
            print(complaint, file=log, flush=True)
        except OSError:  # the disk is full
            print(complaint, file=sys.stderr)
    with suppress(OSError):
        log.close()
    if complaint:
        sys.exit(1)


def count_path(log: str | Path) -> Path:
    """Where a job, by its log, leaves how many cells it has followed, as long as it is at work."""
    return Path(log).with_suffix(".part")


@contextmanager
def _counted(log):
    path = count_path(log)
    look = {"bar_format": "{n_fmt} cells", "mininterval": 1.0, "disable": False}
    try:
        with open(path, "w", encoding="utf-8") as file, counting("", file=file, **look):
            yield
    finally:
        path.unlink(missing_ok=True)


def end_with(parent: int) -> None:
    """End this process with its parent: jobs of a killed run would go on beside the next."""

    def look():
        while os.getppid() == parent:
            time.sleep(LOOK_AROUND)
        os._exit(1)

    Thread(target=look, daemon=True).start()
