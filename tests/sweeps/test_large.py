"""A cube of 10^8 cells, made of synthetic slabs: collected and drawn within 1 GiB."""

import os
import subprocess
import sys
import time

import netCDF4
import numpy as np
import pytest
import xarray as xr

from snapmap.io.atomic import seal
from snapmap.solver.outcome import LATCHED, NEVER

AXES = {
    "C": np.linspace(0.5, 50, 100),
    "f0": np.geomspace(100, 30e3, 1000),
    "N": np.linspace(600, 2400, 1000),
}
ROWS = 250
GIB = 2**30
KINDS = {"outcome": "i1", "t_snap": "f8", "t_settled": "f8", "energy_error": "f8"}


def values(key, C, f0, N):
    """Made-up values of a variable over a box, such that every cell is told from every other."""
    place = np.add.outer(np.add.outer(C, f0), N)
    if key == "outcome":
        return np.where(place > 3e3, LATCHED, NEVER).astype(np.int8)
    return np.round(place)


@pytest.fixture(scope="module")
def slabs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("slabs")
    paths = []
    for C in AXES["C"]:
        for first in range(0, AXES["f0"].size, ROWS):
            rows = AXES["f0"][first : first + ROWS]
            slab = {"C": np.array([C]), "f0": rows, "N": AXES["N"]}
            paths.append(folder / f"{len(paths):012x}.nc")
            write_synthetic(slab, paths[-1])
    return paths


def write_synthetic(slab, path):
    with netCDF4.Dataset(path, "w") as file:
        file.slab = path.stem
        for axis, points in slab.items():
            file.createDimension(axis, len(points))
            file.createVariable(axis, "f8", (axis,))[:] = points
        for key, kind in KINDS.items():
            variable = file.createVariable(key, kind, tuple(slab), compression="zlib", complevel=1)
            variable[:] = values(key, *slab.values())
    seal(path)


def peak(root, script, *arguments):
    """Run a script in a Python of its own; returns its peak of resident memory in bytes."""
    folder = root / "workflow" / "scripts"
    command = [sys.executable, "-c", script, *map(str, arguments)]
    begin = time.perf_counter()
    process = subprocess.Popen(command, env=os.environ | {"PYTHONPATH": str(folder)})
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    seconds = time.perf_counter() - begin
    print(f"{usage.ru_maxrss / 2**10:.0f} MiB, {seconds:.0f} s")
    return usage.ru_maxrss * 2**10


COLLECT = """
import sys
from pathlib import Path
import numpy as np
from jobs import collect
folder, axes, cube = sys.argv[1:]
axes = np.load(axes)
paths = sorted(Path(folder).glob("*.nc"))
collect(paths, {key: axes[key] for key in ("C", "f0", "N")}, {"sweep": {"horizon": "1 us"},
        "model": {"name": "cosines"}}, cube)
"""
DRAW = """
import sys
import xarray as xr
from snapmap.figures import maps, style
with xr.open_dataset(sys.argv[1], engine="netcdf4") as cube, style.paper():
    figure = style.single_column(height=3.6)
    maps.draw_snap_map(figure.subplots(), cube.isel(C=50))
    style.save(figure, sys.argv[2], cube.attrs)
"""


@pytest.fixture(scope="module")
def cube(root, slabs, tmp_path_factory):
    """The collected cube and the peak of the memory that took."""
    folder = tmp_path_factory.mktemp("cube")
    np.savez(folder / "axes.npz", **AXES)
    taken = peak(root, COLLECT, slabs[0].parent, folder / "axes.npz", folder / "cube.nc")
    print(f"{(folder / 'cube.nc').stat().st_size / 1e8:.3g} bytes per cell")
    return folder / "cube.nc", taken


@pytest.mark.long
def test_collecting_takes_less_than_a_gibibyte(cube):
    path, taken = cube
    assert taken < GIB
    with xr.open_dataset(path) as whole:
        assert [whole.sizes[key] for key in AXES] == [values.size for values in AXES.values()]
        counts = {name: whole.attrs[f"cells_{name}"] for name in ("never", "latched")}
        assert sum(counts.values()) == whole.outcome.size == 10**8
        for C in (0, 57, 99):
            part = whole.isel(C=[C], f0=[0, 249, 250, 999], N=slice(None, None, 37))
            for key in KINDS:
                expected = values(key, part.C.values, part.f0.values, part.N.values)
                assert np.array_equal(part[key].values, expected)


@pytest.mark.long
def test_drawing_a_map_takes_less_than_a_gibibyte(root, cube, tmp_path):
    pdf = tmp_path / "map.pdf"
    assert peak(root, DRAW, cube[0], pdf.with_suffix("")) < GIB
    print(f"{pdf.stat().st_size / 1e6:.3g} MB of PDF")
