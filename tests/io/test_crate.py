"""The crate of a study: what it refuses. What it holds: tests/workflow/test_pipeline.py."""

import sys

import pytest

from snapmap.io.crate import _inside, write_crate


def test_without_its_library_one_line_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "rocrate.rocrate", None)
    with pytest.raises(ValueError, match=r"^rocrate: is not installed; .*-publish\.lock$"):
        write_crate(tmp_path / "crate.zip", tmp_path, {}, [], ["results/cube.nc"])


@pytest.mark.parametrize("path", ["/data/shock.csv", "../shock.csv", "a/../../shock.csv"])
def test_a_file_that_would_be_lost_is_refused(path):
    assert _inside("config/shock.csv") == "config/shock.csv"
    with pytest.raises(ValueError, match=r"lies outside the study's folder; copy it there"):
        _inside(path)
