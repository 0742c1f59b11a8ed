"""The log of a script: what it prints, and how it ends."""

import sys
import warnings

import pytest

from snapmap.workflow.job_log import job_log


def test_the_log_has_what_is_printed_and_the_terminal_warnings(tmp_path, capsys):
    with job_log(tmp_path / "log"):
        print("12 cells")
        warnings.warn("about 5 min", stacklevel=1)
        print("careful", file=sys.stderr)
    assert capsys.readouterr() == ("", "about 5 min\n")
    assert (tmp_path / "log").read_text() == "12 cells\nabout 5 min\ncareful\n"


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (ValueError("cube.nc: a hole"), "cube.nc: a hole\n"),
        (OSError("cube.nc: not written"), "cube.nc: not written\n"),
        (MemoryError(), "MemoryError\n"),
    ],
)
def test_what_a_user_can_mend_is_one_line(tmp_path, fault, said):
    with pytest.raises(SystemExit) as end, job_log(tmp_path / "log"):
        raise fault
    assert end.value.code == 1 and (tmp_path / "log").read_text() == said


def test_what_nobody_foresaw_has_a_traceback(tmp_path):
    with pytest.raises(SystemExit), job_log(tmp_path / "log"):
        raise KeyError("f0")
    said = (tmp_path / "log").read_text()
    assert said.startswith("Traceback") and "KeyError: 'f0'" in said


def test_where_the_log_is_full_the_terminal_hears_of_it(capsys):
    with pytest.raises(SystemExit), job_log("/dev/full"):
        raise OSError("cube.nc: not written")
    assert capsys.readouterr().err == "cube.nc: not written\n"
