"""Files: held by one run at a time, complete in a package, and as tools and notebooks read them."""

import errno
import fcntl
import io
import os
import re
import shutil
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from small_studies import cases_of

import snapmap
from snapmap.files import text
from snapmap.files.atomic import fingerprint, hold, replacing
from snapmap.files.counting import count, counting
from snapmap.files.extras import needing
from snapmap.files.named import inside, naming
from snapmap.files.tables import read_rows
from snapmap.solver.options import Cosines
from snapmap.study.variables import write
from snapmap.thresholds.summary import write_thresholds


@pytest.fixture(scope="module")
def study(handout):
    return snapmap.Study(handout, model=Cosines(modes=3), horizon=300.0)


def test_each_threshold_is_a_row(handout, tmp_path):
    """No cell begins with a sign, and axes have all digits, so that rows are found again."""
    study = snapmap.Study(handout, model=Cosines(modes=3), direction="both", horizon=300.0)
    edges = snapmap.threshold(study, [500.0, 1e3 / 0.7], [25.0], axes={"thickness": [1.9, 2.0]})
    write_thresholds(edges, tmp_path / "thresholds.csv")
    written = (tmp_path / "thresholds.csv").read_text()
    head, *lines = (line.split(",") for line in written.splitlines())
    assert head[:2] == ["thickness (um)", "direction"] and head[3:5] == ["f0 (Hz)", "duration (ms)"]
    assert all(cell[:1] not in ("=", "+", "@") for line in lines for cell in line)
    rows = read_rows(tmp_path / "thresholds.csv")
    assert len(rows) == 8 and "island_from" not in rows[0]
    for row in rows:
        place = {key: float(row[key]) for key in ("thickness", "C", "f0")}
        there = edges.sel(place, method=None).sel(direction=row["direction"])
        for key in ("N_first", "N_error", "N_static"):
            written, exact = float(row[key] or "nan"), float(there[key])
            assert written == pytest.approx(exact, rel=1e-5, nan_ok=True)
        assert row["duration"] in ("2.0", "0.7")


@pytest.mark.parametrize(("value", "shown", "told"), cases_of(__file__)["values"])
def test_a_value_is_shown_in_a_short_line(value, shown, told):
    assert (text.show(value), text.describe(value)) == (shown, told)


def test_what_is_no_plain_data_is_shown_by_its_type_and_a_path_as_text(tmp_path):
    values = np.float64(2.5), object(), print, Path("a b"), 10**5000, 3 + 4j
    words = "2.5", "an object", "a builtin_function_or_method", "'a b'", "a number of thousands of"
    assert [*map(text.show, values)] == [*words[:-1], f"{words[-1]} digits", "(3+4j)"]
    numbers = [text.plain(number) for number in (123456.0, 1e-12, 1.23456)]
    assert numbers == ["123500", "1e-12", "1.235"]
    assert [*map(text.is_title, ("a" * 60, "a" * 61, "_a", 3))] == [True, False, False, False]
    assert [*text.leaves({"a": {"b": 1}, "c": None})] == [("a.b", "1"), ("c", "None")]


def test_files_of_a_study_lie_in_its_folder():
    assert inside("a/b.csv") == "a/b.csv"
    for wrong in ("/b.csv", "../b.csv", "a/../../b.csv", "a\nb.csv"):
        with pytest.raises(ValueError, match=r"lies outside the study's folder|do not print"):
            inside(wrong)


def test_a_missing_package_is_named_with_its_extra():
    line = r"^a cube needs dask: pip install 'snapmap\[workflow\]'$"
    with pytest.raises(ImportError, match=line), needing("a cube"):
        raise ModuleNotFoundError(name="dask.array")
    for other in (None, "numpy"):
        with pytest.raises(ModuleNotFoundError), needing("a cube"):
            raise ModuleNotFoundError(name=other)


def test_cells_are_counted_for_who_waits():
    shown = io.StringIO()
    with counting("sweep", file=shown, disable=False, delay=0, mininterval=0, miniters=1):
        count(3)
        count(4)
    count(5)
    assert re.findall(r"sweep: (\d+) cells", shown.getvalue()) == ["0", "3", "7"]
    silent = io.StringIO()
    with counting("sweep", file=silent):
        count(3)
    assert not silent.getvalue()


NUMBERS = 0.1, np.nextafter(0.1, 1.0), 9.3, 1e-15, 1500.0, np.nextafter(1500.0, 2e3), np.inf
WORDS = [("spring" * 20, "a"), ("a", "spring" * 20), ("spring" * 20, "b")]
WORDS += [("x" * 78,), ("x" * 79,), ("été.csv",), ("a/b.csv",), ("a:b.csv",), ("a_b.csv",)]


def test_names_of_files_are_short_and_plain_and_differ_as_their_words_do():
    words = [text.exact(number) for number in NUMBERS]
    assert [float(word.replace("hard", "inf")) for word in words] == [*NUMBERS]
    assert [*words[:3], words[4]] == ["0.1", "0.10000000000000002", "9.3", "1500"]
    names = [text.stem_of("N", word) for word in words] + [text.stem_of(*each) for each in WORDS]
    assert len({*names}) == len(names)
    assert all(re.fullmatch(r"[\w.+-]{1,80}", name, re.ASCII) for name in names)
    assert text.table(["a", "b"], [["1"], []]) == "| a | b |\n|:--|--:|\n| 1 | – |\n| – | – |\n"
    assert text.stem_of("map", "thickness1.9", "versed sine") == "map_thickness1.9_versed_sine"


@pytest.mark.parametrize("sign", [*'<>&|"`*[]\\', "\n", "\x1b", "\u202e"])
def test_signs_with_a_meaning_to_a_page_a_table_or_a_terminal_are_not_shown(sign):
    assert text.is_showable("a (b) {c} é_-.,:;/%+'") and not text.is_showable(f"a{sign}b")


@pytest.fixture(scope="module")
def cube(study):
    return snapmap.sweep(study, [800, 1000, 1300], [800, 1500], [25, 200])


def test_an_opened_cube_is_that_of_sweep_and_of_the_file(cube, tmp_path):
    write(cube, tmp_path / "cube.nc")
    opened = snapmap.open_cube(tmp_path / "cube.nc")
    with xr.open_dataset(tmp_path / "cube.nc") as file:
        assert file.identical(opened) and opened.outcome.identical(cube.outcome)
    with pytest.raises(ValueError, match="several C"):
        snapmap.plot_outcome(opened)
    assert file.outcome.dtype == opened.outcome.dtype == cube.outcome.dtype == np.int8
    with pytest.raises(ValueError, match=r"none\.nc' is not the path of a file"):
        snapmap.open_cube(tmp_path / "none.nc")
    whole = (tmp_path / "cube.nc").read_bytes()
    for at in (0, 50, len(whole) // 2, len(whole) - 1):
        (tmp_path / "bad.nc").write_bytes(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1 :])
        with pytest.raises(ValueError, match=r"bad\.nc: is damaged; take another copy"):
            snapmap.open_cube(tmp_path / "bad.nc")


def test_a_fault_of_a_file_is_a_line_that_names_it(monkeypatch):
    faults = OSError(28, "full"), OSError("so\n  to say"), ValueError("wrong")
    faults += FileNotFoundError(2, "none"), UnicodeDecodeError("utf-8", b"a", 0, 1, "begin")
    words = "full", "so to say", "wrong", "is not there", "is not text in UTF-8"
    for fault, said in zip(faults, words, strict=True):
        with pytest.raises(ValueError, match=f"^a b: {said}$"), naming("a b"):
            raise fault
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=1234567))
    line = r"^a b: not written, 1\.23 MB are free there: full$"
    with pytest.raises(OSError, match=line), replacing("a b"):
        raise OSError("full")


def test_the_installed_package_has_all_its_files(root):
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    patterns = project["tool"]["setuptools"]["package-data"]
    package = root / "workflow" / "scripts" / "snapmap"
    for path in package.rglob("*"):
        if path.is_file() and path.suffix not in (".py", ".pyc", ".nbi", ".nbc"):
            assert any(fnmatch(path.name, pattern) for pattern in patterns["*"]), path


def test_a_file_is_held_once(tmp_path):
    assert hold(tmp_path / "running") == ""
    with pytest.raises(BlockingIOError):
        hold(tmp_path / "running")


NO_LOCKS = [errno.ENOLCK, errno.ENOSYS, errno.EOPNOTSUPP, errno.EACCES, errno.EAGAIN]


@pytest.mark.parametrize("code", NO_LOCKS)
def test_a_file_system_without_locks_is_named(tmp_path, monkeypatch, code):
    def flock(*_):
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(fcntl, "flock", flock)
    assert hold(tmp_path / "running") == os.strerror(code)


@pytest.fixture
def no_locks(tmp_path):
    """An environment in which no file can be locked."""
    if not shutil.which("gcc"):
        pytest.skip("no compiler is here")
    (source := tmp_path / "flock.c").write_text(cases_of(__file__)["flock"])
    library = tmp_path / "flock.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", library, source], check=True)
    environment = os.environ | {"LD_PRELOAD": str(library)}
    environment.pop("HDF5_USE_FILE_LOCKING", None)
    return environment


def test_without_locks_files_are_read_and_written_or_the_remedy_is_named(cube, tmp_path, no_locks):
    write(cube, path := tmp_path / "cube.nc")

    def opened(first):
        command = [sys.executable, "-c", cases_of(__file__)["opened"].format(first=first), path]
        return subprocess.run(command, env=no_locks, stderr=subprocess.PIPE, text=True).stderr

    assert opened("") == "" and (tmp_path / "cube.nc.nc").exists()
    remedy = "set HDF5_USE_FILE_LOCKING=FALSE, or import snapmap before netCDF4\n"
    assert opened("import netCDF4").endswith(f"{path}: cannot be locked; {remedy}")


def test_a_fingerprint_is_that_of_the_seal_or_of_the_content(cube, tmp_path):
    for path in (tmp_path / "a.nc", tmp_path / "b.nc"):
        write(cube, path)
    assert fingerprint(tmp_path / "a.nc") == fingerprint(tmp_path / "b.nc")
    write(cube.isel(C=[0]), tmp_path / "b.nc")
    texts = "", "1,2\n", "1,3\n", "1,2\n" * 100
    for number, held in enumerate(texts):
        (tmp_path / f"{number}.csv").write_text(held)
    assert len({fingerprint(path) for path in tmp_path.iterdir()}) == 2 + len(texts)
