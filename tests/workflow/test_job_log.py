"""The log of a script: what it prints, and how it ends."""

import logging
import os
import subprocess
import sys
import time
import warnings

import psutil
import pytest
from small_studies import cases_of
from small_workflow import wait_for

from snapmap.workflow.job_log import job_log

(JOB,) = cases_of(__file__).values()


def test_a_job_ends_with_its_run(root, tmp_path):
    environment = os.environ | {"PYTHONPATH": str(root / "workflow" / "scripts")}
    start = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {JOB!r}])"
    run = subprocess.Popen([sys.executable, "-c", start], cwd=tmp_path, env=environment)
    assert wait_for((tmp_path / "log").exists)
    (job,) = psutil.Process(run.pid).children()
    time.sleep(0.1)
    assert job.is_running()
    run.kill()
    run.wait()
    assert wait_for(lambda: not job.is_running() or job.status() == psutil.STATUS_ZOMBIE)


def test_the_log_has_what_is_printed_and_the_terminal_warnings(tmp_path, capsys):
    with job_log(tmp_path / "log"):
        print("12 cells")
        warnings.warn("about 5 min", stacklevel=1)
        logging.getLogger("snapmap").warning("%d modes", 3)
        print("careful", file=sys.stderr)
    logging.getLogger("snapmap").warning("after it")
    assert capsys.readouterr() == ("", "about 5 min\n3 modes\n")
    assert (tmp_path / "log").read_text() == "12 cells\nabout 5 min\n3 modes\ncareful\n"


def log_of(fault, path):
    """What a log says of a fault, which ends the job."""
    with pytest.raises(SystemExit) as end, job_log(path):
        raise fault
    assert end.value.code == 1
    return path.read_text()


def test_what_a_user_can_mend_is_one_line_and_all_else_has_a_traceback(tmp_path):
    for fault in (ValueError("cube.nc: a hole"), OSError("cube.nc: not written")):
        assert log_of(fault, tmp_path / "log") == f"{fault}\n"
    assert log_of(MemoryError(), tmp_path / "log") == "MemoryError\n"
    unforeseen = log_of(KeyError("f0"), tmp_path / "log")
    assert unforeseen.startswith("Traceback") and "KeyError: 'f0'" in unforeseen


def test_the_traceback_of_a_users_code_comes_before_the_line(tmp_path):
    fault = ValueError("model.laws: mine: KeyError: 'x'")
    fault.__cause__ = KeyError("x")
    *before, line = log_of(fault, tmp_path / "log").splitlines()
    assert line == str(fault) and before == ["KeyError: 'x'"]
    fault = OSError("cube.nc: not written")
    fault.__cause__ = OSError("disk")
    assert log_of(fault, tmp_path / "log") == f"{fault}\n"


def test_where_the_log_is_full_the_terminal_hears_of_it(capsys):
    with pytest.raises(SystemExit), job_log("/dev/full"):
        raise OSError("cube.nc: not written")
    assert capsys.readouterr().err == "cube.nc: not written\n"
