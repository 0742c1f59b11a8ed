"""Slabs on the way to a cube: what is broken, missing or there twice is named, never merged."""

import pytest
import xarray as xr
import yaml
from small_studies import THREE_COSINES

from snapmap.config.study import load_config
from snapmap.sweeps.collect import collect_slabs
from snapmap.sweeps.slabs import slab_name, write_slab

SWEEP = """sweep:
  N: [600, 1200, 2400]
  f0: [1 kHz, 3 kHz]
  C: [0.025 uN*us/um, 25 uN*us/um, 50 uN*us/um]
  horizon: 300 us
  until: snap
"""


@pytest.fixture(scope="module")
def study():
    return load_config(yaml.safe_load(THREE_COSINES + SWEEP))


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
    "empty": lambda path, other: path.write_bytes(b""),
    "text": lambda path, other: path.write_text("N: 600\n"),
    "foreign": lambda path, other: path.write_bytes(other.read_bytes()),
    "another file": lambda path, other: xr.Dataset({"N": [600.0]}).to_netcdf(path),
    "missing": lambda path, other: path.unlink(),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_file_is_named(slabs, fault):
    paths, axes = slabs
    FAULTS[fault](paths[1], paths[2])
    with pytest.raises(ValueError) as refusal:
        collect_slabs(paths, axes, {})
    assert str(refusal.value).startswith(f"{paths[1]}: ")
    assert "\n" not in str(refusal.value)


def test_holes_and_slabs_given_twice_are_refused(slabs):
    paths, axes = slabs
    with pytest.raises(ValueError) as refusal:
        collect_slabs([paths[0]], axes, {})
    lines = str(refusal.value).splitlines()
    assert [f"C = {C} " in line for C, line in zip(axes["C"][1:], lines, strict=True)] == [True] * 2
    with pytest.raises(ValueError, match=r"24 cells .* 18"):
        collect_slabs([*paths, paths[-1]], axes, {})


@pytest.mark.parametrize("stride", [197, pytest.param(7, marks=pytest.mark.long)])
def test_a_flipped_byte_is_refused_or_without_effect(slabs, stride):
    (path, *_), axes = slabs
    axes = axes | {"C": axes["C"][:1]}
    whole = path.read_bytes()
    right = collect_slabs([path], axes, {}).load(scheduler="synchronous")
    refused = 0
    for place in range(0, len(whole), stride):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            found = collect_slabs([path], axes, {}).load(scheduler="synchronous")
        except ValueError as refusal:
            assert str(path) in str(refusal)
            refused += 1
        else:
            assert found.equals(right)
    assert refused
