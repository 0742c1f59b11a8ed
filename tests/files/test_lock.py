"""One run at a time in a folder, and a word where that cannot be had."""

import errno
import fcntl
import os

import pytest

from snapmap.files.atomic import hold


def test_a_file_is_held_once(tmp_path):
    assert hold(tmp_path / "running") == ""
    with pytest.raises(BlockingIOError):
        hold(tmp_path / "running")


@pytest.mark.parametrize("code", [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP])
def test_without_locks_it_says_so(tmp_path, monkeypatch, code):
    def flock(*_):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(fcntl, "flock", flock)
    assert hold(tmp_path / "running") == os.strerror(code)
