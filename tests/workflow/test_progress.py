"""What a run tells while it is at work."""

import io
import logging
import signal
import sys
from contextlib import closing
from pathlib import Path

import pytest
from small_studies import cases_of

from snapmap.workflow.job_log import count_path
from snapmap.workflow.progress import STOPPED, Progress


def record(event=None, level=logging.INFO, **facts):
    return logging.makeLogRecord({"msg": "said", "levelno": level, "event": event, **facts})


def job(number, rule, message, **wildcards):
    facts = {"jobid": number, "rule_name": rule, "rule_msg": message, "wildcards": wildcards}
    return record("job_info", **facts, log=[f"results/logs/{rule}.log"])


RECORDS = (
    job(1, "simulate_slab", "Simulate the cells", slab="a"),
    job(2, "simulate_slab", "Simulate the cells", slab="b"),
    record("job_finished", job_id=1),
    job(3, "find_threshold", "Find the thresholds"),
    *(record("progress", done=1, total=3), record("shellcmd")),
)


def said_on(stream, monkeypatch):
    """What is said of two slabs that begin, of which one ends, and of a threshold that begins."""
    monkeypatch.setattr(sys, "stderr", stream)
    with closing(Progress({"a": 30, "b": 90})) as progress:
        progress.begin()
        for each in RECORDS:
            progress.emit(each)
        return stream.getvalue()


def test_a_terminal_has_one_line_with_cells_and_jobs_at_work(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("results/logs").mkdir(parents=True)
    count_path("results/logs/find_threshold.log").write_text("\r100 cells\r700 cells ")
    (terminal := io.StringIO()).isatty = lambda: True
    said = said_on(terminal, monkeypatch)
    parts = "30 of 120 cells, 25 %", "left", "1 of 3 jobs", "Find the thresholds, 700 cells"
    assert all(part in said.split("\r")[-1] for part in parts) and "\n" not in said


def test_a_log_has_each_stage_once(monkeypatch):
    said = said_on(io.StringIO(), monkeypatch)
    assert said == "Simulate the cells\nFind the thresholds\n"


def test_a_job_that_counts_leaves_no_semaphore_behind(python):
    """It ends by os._exit; processes that are not forked keep those that they named."""
    assert python(cases_of(__file__)["counting"]) == ("counted\n", "")


def test_faults_are_not_hushed():
    is_shown = Progress({}).is_shown
    assert not any(is_shown(record(event)) for event in ("job_info", "progress", None))
    assert is_shown(record("job_error", logging.ERROR))
    wrapped = 'RuleException:\nCalledProcessError in file "sweep.smk", line 43:\nCommand'
    assert not is_shown(record("error", logging.ERROR, msg=wrapped))


def test_a_run_that_is_stopped_says_so_once_and_nothing_more(capsys, monkeypatch):
    monkeypatch.setattr("snapmap.workflow.progress._end_jobs", lambda: None)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with closing(Progress({})) as progress:
        progress.begin()
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)  # a second one is not heard
        assert not progress.is_shown(record("job_error", logging.ERROR))
    signal.signal(signal.SIGINT, before)
    assert capsys.readouterr().err == f"{STOPPED}\n"
