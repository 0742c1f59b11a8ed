"""The progress of a run: one line on a terminal, and the names of its stages in a log."""

import logging
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from threading import Event, Thread

import psutil
from tqdm import tqdm

from .job_log import count_path

CELLS, ALL_CELLS = "simulate_slab", "simulate_all"
"""Names of the rules that follow the cells of a slab, and all cells."""
WRAPPED = (
    "RuleException:\nCalledProcessError in file",
    "WorkflowError:\nAt least one job did not complete",
    "Restored previous version of",
    "Cannot restore",
)
"""Beginnings of messages that repeat the log of a job, which is shown beside them, or tell of a
product that stays as it was, or is not there yet."""
AGAIN = "Trying to restart job"
STOPPED = "interrupted: finished files are kept; the same command continues"
LOOK = "{n_fmt} of {total_fmt} cells, {percentage:.0f} %, {remaining} left for them{postfix}"


class Progress(logging.Handler):
    """A handler that sums up Snakemake's log."""

    def __init__(self, cells: Mapping[str, int]):
        """Take the numbers of cells of slabs to simulate, by their names."""
        super().__init__(logging.INFO)
        self.cells, self.jobs, self.stages, self.done = cells, {}, [], ""
        self.line, self.closed, self.stopped = tqdm(disable=True), Event(), Event()

    def begin(self) -> None:
        """Draw the line if there is a terminal, and update it every second; hear Ctrl-C."""
        if signal.getsignal(signal.SIGINT) != signal.SIG_IGN:
            signal.signal(signal.SIGINT, self._stop)
        look = {"bar_format": LOOK, "leave": False, "file": sys.stderr}
        self.line = tqdm(total=sum(self.cells.values()), disable=None, **look)
        if not self.line.disable:
            Thread(target=self._tick, daemon=True).start()

    def emit(self, record: logging.LogRecord) -> None:
        """Take note of jobs that start or end, and of progress."""
        event = str(getattr(record, "event", ""))
        if event == "job_info" and record.rule_msg:
            self.jobs[record.jobid] = record
            if self.line.disable and record.rule_msg not in self.stages:
                self.stages.append(record.rule_msg)
                print(record.rule_msg, file=sys.stderr)
        elif event == "job_finished" and record.job_id in self.jobs:
            job = self.jobs.pop(record.job_id)
            if job.rule_name == CELLS:
                self.line.update(self.cells.get(job.wildcards["slab"], 0))
            elif job.rule_name == ALL_CELLS:
                self.line.update(sum(self.cells.values()))
        elif event == "progress":
            self.done = f"{record.done} of {record.total} jobs"
        self._name_stages()

    def close(self) -> None:
        """Clear the line."""
        self.closed.set()
        self.line.close()
        super().close()

    def is_shown(self, record: logging.LogRecord) -> bool:
        """Keep warnings, faults and restarts alone, and none of a run that the user has stopped."""
        words = record.getMessage()
        is_fault = record.levelno >= logging.WARNING and not words.startswith(WRAPPED)
        return (is_fault or words.startswith(AGAIN)) and not self.stopped.is_set()

    def _stop(self, number, frame):
        """End the jobs in one line, without their complaints; Snakemake then ends the run."""
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C must not disturb it
        self.stopped.set()
        tqdm.write(STOPPED, file=sys.stderr)
        Thread(target=_end_jobs, daemon=True).start()
        raise KeyboardInterrupt

    def _name_stages(self):
        if not self.line.disable:
            stages = dict.fromkeys(map(_stage, self.jobs.values()))
            self.line.set_postfix_str("; ".join(filter(None, [self.done, *stages])))

    def _tick(self):
        while not self.closed.wait(1.0):
            self._name_stages()


def _stage(job):
    """Say what a job does, and how many cells it has followed unless the line counts them."""
    with suppress(OSError):
        if job.rule_name != CELLS:
            *_, cells = count_path(job.log[0]).read_text(encoding="utf-8").split("\n")
            return ", ".join(filter(None, [job.rule_msg, cells.strip()]))
    return job.rule_msg


def _end_jobs():
    """End the processes of jobs again and again, as more may just be starting."""
    while True:
        for job in psutil.Process().children():
            job.terminate()
        time.sleep(0.1)
