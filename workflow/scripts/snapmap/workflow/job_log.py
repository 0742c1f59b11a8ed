"""The call of a rule's function with the arguments of its job, and the log of the job."""

import inspect
import logging
import os
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from functools import partial
from pathlib import Path
from threading import Thread

from ..files.counting import counting
from ..files.named import hold_to_plan
from .made import hold_to_list, list_made

RUN = "SNAPMAP_RUN"
"""Name of the environment variable with the process number of a job's run."""
SHELL_PREFIX = f"trap '' INT; OPENBLAS_NUM_THREADS=1 {RUN}=$PPID exec "
"""Prefix of a job's command, which makes the run its parent. The job ignores Ctrl-C, as it might
answer with a traceback while it imports; the run ends it. No job needs threads of BLAS."""
LOOK_AROUND = 1.0
"""Seconds after which a job checks again whether its run still exists."""


def run_rule(function: Callable, job, code_of: Callable, study_of: Callable | None = None) -> None:
    """Call a rule's function with those values of its job that have the names of its parameters.

    job: the `snakemake` object. Its values are wildcards and params; NAME_path, or NAME_paths, of
        inputs and outputs; `files`, the inputs by name; `path`, the first output, and its `folder`;
        the number of `threads`. It is listed with the hash `made_from` of its params.
    code_of: gives the hash of the code by what it does; it must be the plan's, before and after
    study_of: makes `study` of the run's config and threads
    A function that takes `watch` calls it once it has forked, as no thread outlives a fork.
    """
    first = Path(job.output[0])
    threads = max(1, job.threads)
    values = {"path": str(first), "folder": first.parent, "threads": threads}
    values["files"] = dict(job.input.items())
    values |= {**dict(job.wildcards.items()), **dict(job.params.items())}
    for name, files in [*job.input.items(), *job.output.items()]:
        values[f"{name}_path" if isinstance(files, str) else f"{name}_paths"] = files
    wanted = inspect.signature(function).parameters
    watch = partial(end_with, int(os.environ[RUN]))
    if "watch" in wanted:
        values["watch"] = watch
    else:
        watch()
    with job_log(job.log[0]), _counted(job.log[0]):
        hold_to_plan(code_of())
        hold_to_list(job.input)
        if "study" in wanted:
            values["study"] = study_of(job.config, threads)
        function(**{name: values[name] for name in wanted if name in values})
        hold_to_plan(code_of())  # parts of it were imported on the way
        list_made(job.output, job.params.made_from)
    os._exit(0)  # a regular exit would take a sixth of a job


@contextmanager
def job_log(path: str | Path) -> Iterator[None]:
    """Keep what a rule's function prints in a log; warnings and logging also go to the terminal.

    Snakemake shows the log of a job that fails. A fault that the user can mend (ValueError,
    OSError, MemoryError) is one line in it, after the traceback of a user's own code that raised
    it; any other is a traceback.
    """
    complaint = ""
    log = open(path, "w", buffering=1, encoding="utf-8")  # noqa: SIM115, closing may fail, too
    terminal = sys.stderr

    def warn(message, *_, **__):
        for stream in (log, terminal):
            print(message, file=stream)

    with redirect_stdout(log), redirect_stderr(log), warnings.catch_warnings(), _logged_by(warn):
        warnings.showwarning = warn
        try:
            yield
        except (MemoryError, OSError, ValueError) as fault:
            complaint = str(fault) or type(fault).__name__
            if isinstance(fault, ValueError) and fault.__cause__:  # in a user's own code
                traceback.print_exception(fault.__cause__)
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


@contextmanager
def _logged_by(tell):
    """Have a function tell the messages of the package's logger."""
    logger, handler = logging.getLogger("snapmap"), logging.Handler()
    handler.emit = lambda record: tell(record.getMessage())
    logger.addHandler(handler)
    try:
        yield
    finally:
        logger.removeHandler(handler)


def count_path(log: str | Path) -> Path:
    """Give the path of the file in which a job, by its log, counts the cells it has followed."""
    return Path(log).with_suffix(".part")


@contextmanager
def _counted(log):
    path = count_path(log)
    look = {"bar_format": "{n_fmt} cells, {rate_fmt}", "mininterval": 1.0, "disable": False}
    try:
        with open(path, "w", encoding="utf-8") as file, counting("", file=file, **look):
            yield
    finally:
        path.unlink(missing_ok=True)


def end_with(parent: int) -> None:
    """End this process when its parent ends: a killed run must leave no jobs."""

    def look():
        while os.getppid() == parent:
            time.sleep(LOOK_AROUND)
        os._exit(1)

    Thread(target=look, daemon=True).start()
