"""A cube from its file, for a notebook: outcomes in words."""

from pathlib import Path

import numpy as np
import xarray as xr

from ..io.netcdf import check_seal
from ..solver.outcome import OUTCOMES


def open_cube(path: str | Path) -> xr.Dataset:
    """Open a cube; `outcome` is its name, such as "latched", and `outcome_code` its number.

    The rest stays in the file until it is used.

    >>> snapmap.open_cube("config/config.yaml")
    Traceback (most recent call last):
    ValueError: config/config.yaml: is no cube; `results/cube.nc` is one
    """
    try:
        check_seal(path)
        cube = xr.open_dataset(path, engine="netcdf4")
        codes = cube.outcome
    except (OSError, RuntimeError, AttributeError):
        raise ValueError(f"{path}: is no cube; `results/cube.nc` is one") from None
    names = np.array(OUTCOMES)
    words = codes.copy(data=names[codes.values.astype(int)])
    words.attrs = {"long_name": codes.attrs["long_name"]}
    return cube.assign(outcome=words, outcome_code=codes)
