"""A cube of 10^8 cells, made of synthetic slabs: collected within 1 GiB."""

import os
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
import xarray as xr

from snapmap.files.atomic import seal
from snapmap.solver.outcome import LATCHED, NEVER

pytestmark = pytest.mark.long
AXES = {
    "C": np.linspace(0.5, 50, 100),
    "f0": np.geomspace(100, 30e3, 1000),
    "N": np.linspace(600, 2400, 1000),
}
KINDS = {"outcome": "i1", "t_snap": "f8", "t_settled": "f8", "energy_error": "f8"}
COLLECT = """
import sys
from pathlib import Path
from types import SimpleNamespace
import numpy as np
from jobs import collect
folder, axes, cube = sys.argv[1:]
document = {"sweep": {"horizon": "1 us"}, "model": {"name": "cosines"}}
study = SimpleNamespace(axes=dict(np.load(axes)), document=lambda: document)
collect(study, sorted(Path(folder).glob("*.nc")), cube)
"""


def values(key, C, f0, N):
    """Made-up values of a variable over a box, such that every cell is told from every other."""
    place = np.add.outer(np.add.outer(C, f0), N)
    if key == "outcome":
        return np.where(place > 3e3, LATCHED, NEVER).astype(np.int8)
    return np.round(place)


def write_slab(slab, path):
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
    """Run a script in a Python of its own; returns its peak of resident memory in GiB."""
    command = [sys.executable, "-c", script, *map(str, arguments)]
    path = {"PYTHONPATH": str(root / "workflow" / "scripts")}
    process = subprocess.Popen(command, env=os.environ | path)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    return usage.ru_maxrss / 2**20


def test_collecting_takes_less_than_a_gibibyte(root, tmp_path):
    for number, C in enumerate(AXES["C"]):
        for part, f0 in enumerate(np.split(AXES["f0"], 4)):
            slab = {"C": np.array([C]), "f0": f0, "N": AXES["N"]}
            write_slab(slab, tmp_path / f"{4 * number + part:012x}.nc")
    folder = tmp_path / "cube"
    folder.mkdir()
    np.savez(folder / "axes.npz", **AXES)
    path = folder / "cube.nc"
    assert peak(root, COLLECT, tmp_path, folder / "axes.npz", path) < 1
    with xr.open_dataset(path) as whole:
        counts = {name: whole.attrs[f"cells_{name}"] for name in ("never", "latched")}
        assert sum(counts.values()) == whole.outcome.size == 10**8
        for C in (0, 57, 99):
            part = whole.isel(C=[C], f0=[0, 249, 250, 999], N=slice(None, None, 37))
            for key in KINDS:
                expected = values(key, part.C.values, part.f0.values, part.N.values)
                assert np.array_equal(part[key].values, expected)
