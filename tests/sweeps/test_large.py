"""A cube of 10^8 cells, made of synthetic slabs: collected within 1 GiB."""

import netCDF4
import numpy as np
import pytest
import xarray as xr
from small_studies import cases_of

from snapmap.files.atomic import seal
from snapmap.solver.outcome import LATCHED, NEVER

AXES = {"C": np.linspace(0.5, 50, 100), "f0": np.geomspace(100, 30e3, 1000)}
AXES |= {"N": np.linspace(600, 2400, 1000)}
(COLLECT,) = cases_of(__file__).values()


def values(C, f0, N):
    """Made-up values over a box, such that every cell is told from every other."""
    place = np.add.outer(np.add.outer(C, f0), N)
    outcome = np.where(place > 3e3, LATCHED, NEVER).astype(np.int8)
    return {"outcome": outcome, "t_snap": np.round(place), "t_settled": np.round(place)}


@pytest.mark.long
def test_collecting_takes_less_than_a_gibibyte(python, tmp_path):
    for number, C in enumerate(AXES["C"]):
        slab = AXES | {"C": np.array([C])}
        with netCDF4.Dataset(tmp_path / f"{number:012x}.nc", "w") as file:
            file.slab, file.code = f"{number:012x}", "of no code"
            for axis, points in slab.items():
                file.createDimension(axis, len(points))
                file.createVariable(axis, "f8", (axis,))[:] = points
            for key, column in values(*slab.values()).items():
                file.createVariable(key, column.dtype, tuple(slab), compression="zlib")[:] = column
        seal(tmp_path / f"{number:012x}.nc")
    folder = tmp_path / "cube"
    folder.mkdir()
    np.savez(folder / "axes.npz", **AXES)
    said, faults = python(COLLECT, tmp_path, folder / "axes.npz", folder / "cube.nc")
    assert float(said.splitlines()[-1]) < 1, faults
    with xr.open_dataset(folder / "cube.nc") as whole:
        counts = {name: whole.attrs[f"cells_{name}"] for name in ("never", "latched")}
        assert sum(counts.values()) == whole.outcome.size == 10**8
        part = whole.isel(C=[0, 57, 99], f0=[0, 249, 250, 999], N=slice(None, None, 37))
        for key, expected in values(part.C.values, part.f0.values, part.N.values).items():
            np.testing.assert_array_equal(part[key], expected)
