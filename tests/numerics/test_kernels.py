"""Compiled kernels on disk: never of another source, whole, and compiled by one process."""

import os
import subprocess
import sys

import pytest
from numba import njit
from small_studies import cases_of

import snapmap
from snapmap import Study
from snapmap.numerics.kernels import _hash, compiled
from snapmap.solver.kernel import lanes, trace

OUTER, INNER = cases_of(__file__).values()


@pytest.mark.parametrize(
    "variable", ["XDG_CACHE_HOME", pytest.param("NUMBA_CACHE_DIR", marks=pytest.mark.long)]
)
def test_a_kernel_is_compiled_by_a_single_process_of_its_own_source(root, tmp_path, variable):
    """All start at once; what does not compile waits, and loads. Nor does another clone compile.

    numba by itself would keep the kernel after an edit: its own file stays as it is.
    """
    path = {"PYTHONPATH": str(root / "workflow" / "scripts"), variable: str(tmp_path)}
    how = {"env": os.environ | path, "stdout": subprocess.PIPE, "text": True}
    folder = path.get("NUMBA_CACHE_DIR", "").split()
    for clone, factor, hits in (("one", 3.0, "01"), ("one", 5.0, "0"), ("other", 5.0, "1")):
        (place := tmp_path / clone).mkdir(exist_ok=True)
        (place / "outer.py").write_text(OUTER)
        (place / "inner.py").write_text(f"{INNER}    return {factor}")
        command = [sys.executable, "-B", "-c", "import outer"]
        runs = [subprocess.Popen(command, **how, cwd=place) for _ in hits]
        printed = [run.communicate(timeout=120)[0].split() for run in runs]
        assert sorted(printed) == [[str(2 * factor), count, *folder] for count in hits]
    assert len({path.parent for path in tmp_path.rglob("*.nbi")}) == 2


def test_a_numba_that_does_not_compile_is_told(monkeypatch):
    monkeypatch.setattr("numba.core.config.DISABLE_JIT", 1)
    with pytest.raises(ValueError, match=r"^NUMBA_DISABLE_JIT: is set, .*; unset it$"):
        compiled(lambda x: x)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setattr("numba.core.config.CACHE_DIR", str(tmp_path))
    return tmp_path


def _size(shape):
    return len(shape)


def test_a_kernel_that_cannot_be_kept_runs(cache, monkeypatch):
    def replace(*_):
        raise OSError(28, os.strerror(28))

    with monkeypatch.context() as full:
        full.setattr(os, "replace", replace)
        assert compiled(_size)((0,) * 3) == 3
    assert not [*cache.rglob("*.nbc")]


def test_a_damaged_kernel_is_compiled_anew_and_kept(cache):
    assert compiled(_size)((0, 0)) == 2
    for path in [*cache.rglob("*.nbi"), *cache.rglob("*.nbc")]:
        whole = path.read_bytes()
        places = range(0, len(whole), len(whole) // 5)
        flips = (whole[:at] + bytes([whole[at] ^ 255]) + whole[at + 1 :] for at in places)
        for damaged in (*flips, whole[: len(whole) // 2], b""):
            path.write_bytes(damaged)
            for hits in (0, 1):
                kernel = compiled(_size)
                assert kernel((0, 0)) == 2
                assert sum(kernel.stats.cache_hits.values()) == hits


def test_another_numba_keeps_kernels_of_its_own(cache, monkeypatch):
    for version in ("0.61.0", "0.68.1"):
        with monkeypatch.context() as other:
            other.setattr("numba.__version__", version)
            _hash.cache_clear()
            assert compiled(_size)((0,) * 3) == 3
        _hash.cache_clear()
    assert len({path.parent for path in cache.rglob("*.nbi")}) == 2


def test_no_kernel_has_one_that_refers_to_objects_of_python(handout):
    """Those of one that is compiled anew, and of its copy on disk, may have other numbers."""
    snapmap.simulate(Study(handout, "cosines", horizon=9.0), 1300.0, 1500.0, 25.0)
    snapmap.sweep(Study(handout, "cosines"), [1300.0], [1500.0], [25.0])
    for kernel in (lanes.follow_all, trace.keep_motion, trace.keep_seen, trace.leap):
        for whole in kernel.overloads.values():
            assert not any(part.consts for part in whole._find_referenced_environments())
    assert lanes.follow_all.overloads and trace.keep_motion.overloads


@pytest.mark.filterwarnings("error")
def test_a_kernel_is_announced_once_when_it_is_compiled(cache, caplog):
    """Also where each warning is an error, as in the tests of others."""
    for _ in range(2):
        assert njit(cache=True)(_size)((0,) * 23) == 23
    assert ["23 modes" in message for message in caplog.messages] == [True]
