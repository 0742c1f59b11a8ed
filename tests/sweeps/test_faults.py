"""Slabs and cubes that are broken, changed or not ours: named in a line, never misread."""

import re

import numpy as np
import pytest
import xarray as xr
import yaml
from small_results import TINY, make_cells
from small_studies import THREE_COSINES, cases_of

import snapmap
from snapmap.applications.whole import load_config
from snapmap.study.variables import write
from snapmap.sweeps.cube import collect_slabs
from snapmap.sweeps.slabs import slab_name, write_slab


@pytest.fixture(scope="module")
def study():
    return load_config(yaml.safe_load(THREE_COSINES) | cases_of(__file__))


@pytest.fixture
def slabs(study, tmp_path):
    """Files of slabs, of a damper each, and the axes of the grid."""
    paths = []
    for value in study.axes["C"]:
        slab = {"C": (value,)} | {key: tuple(study.axes[key]) for key in ("f0", "N")}
        paths.append(tmp_path / f"{slab_name(study, slab)}.nc")
        write_slab(study, slab, paths[-1])
    return paths, study.axes


FAULTS = {
    "truncated": lambda path, other: path.write_bytes(path.read_bytes()[:-1000]),
    "flipped": lambda path, other: path.write_bytes(flipped(path.read_bytes())),
    "empty": lambda path, other: path.write_bytes(b""),
    "text": lambda path, other: path.write_text("N: 600\n"),
    "foreign": lambda path, other: path.write_bytes(other.read_bytes()),
    "another file": lambda path, other: xr.Dataset({"N": [600.0]}).to_netcdf(path),
    "missing": lambda path, other: path.unlink(),
}


def flipped(whole):
    """Another bit, in a file of slabs; test_whole.py flips more of them."""
    middle = len(whole) // 2
    return whole[:middle] + bytes([whole[middle] ^ 1]) + whole[middle + 1 :]


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_file_is_named(slabs, fault):
    paths, axes = slabs
    FAULTS[fault](paths[1], paths[2])
    with pytest.raises(ValueError, match=rf"\A{re.escape(str(paths[1]))}: .*\Z"):
        collect_slabs(paths, axes, {})


def test_slabs_of_several_codes_are_refused(study, slabs):
    paths, axes = slabs
    slab = {"C": (axes["C"][1],)} | {key: tuple(axes[key]) for key in ("f0", "N")}
    (other := paths[0].with_name(f"{slab_name(study, slab)}.nc")).unlink()
    write_slab(study, slab, other, "another")
    others = [path for path in paths if path != other]
    one, two, odd = (re.escape(str(path)) for path in (*others, other))
    with pytest.raises(ValueError, match=rf"\A{odd}: has cells of other code; .*\Z"):
        collect_slabs([*others, other], axes, {})
    with pytest.raises(ValueError, match=rf"\A{one}: .* other code.*\n{two}: .*\Z"):
        collect_slabs(paths, axes, {}, code="another")


def test_holes_slabs_given_twice_and_too_many_cells_are_refused(slabs, study, monkeypatch):
    with pytest.raises(ValueError, match=r"^N: 1e\+08 cells with f0, C and .* than 1e\+08; write"):
        snapmap.sweep(study, np.arange(1e4), np.arange(1.0, 10_002), 25)
    paths, axes = slabs
    with pytest.raises(ValueError, match=r"\A.*C = 25\.0 .*\n.*C = 50\.0 .*\Z"):
        collect_slabs([paths[0]], axes, {})
    assert collect_slabs(paths[:2], axes | {"C": axes["C"][:2]}, {}).outcome.size == 12
    monkeypatch.setattr("snapmap.sweeps.cube.BLOCK_CELLS", 6)
    assert collect_slabs(paths, axes, {}).outcome.chunks == ((1, 1, 1), (2,), (3,))
    with pytest.raises(ValueError, match=r"24 cells .* 18"):
        collect_slabs([*paths, paths[-1]], axes, {})


CHANGES = {
    "lost its attribute flag_meanings": lambda cube: cube.drop_attrs(),
    "has no codes of outcomes": lambda cube: cube.assign(outcome=cube.outcome.astype(str)),
    "-1 is not a code of an outcome; codes are 0 to 6": lambda cube: with_code(cube, -1),
    "8 is not a code of an outcome; codes are 0 to 6": lambda cube: with_code(cube, 8),
    "N is an axis of numbers, but": lambda cube: cube.assign_coords(N=[np.nan, 1, 2, 3]),
    "f0 is an axis of numbers, but": lambda cube: cube.assign_coords(f0=[*"abcd"]),
}


def with_code(cube, code):
    return cube.assign(outcome=cube.outcome.where(cube.outcome > 0, code))


@pytest.mark.parametrize("words", CHANGES)
def test_a_changed_cube_is_refused_in_one_line(tmp_path, words):
    cube, path = CHANGES[words](TINY), tmp_path / "cube.nc"
    cube.to_netcdf(path)
    line = rf": .*{re.escape(words)}.*\Z"
    with pytest.raises(ValueError, match=rf"\A{re.escape(str(path))}{line}"):
        snapmap.open_cube(path)
    with pytest.raises(ValueError, match=rf"\Acube{line}"):
        snapmap.plot_outcome(cube)


def test_a_cube_that_was_opened_and_written_again_is_one(tmp_path):
    cube = make_cells(["0123"]).drop_attrs(deep=False)
    write(cube, tmp_path / "one.nc")
    opened = snapmap.open_cube(tmp_path / "one.nc")
    opened.to_netcdf(tmp_path / "other.nc")
    assert snapmap.open_cube(tmp_path / "other.nc").identical(opened)
    snapmap.plot_outcome(opened.assign_attrs(config="{}"))
