"""Datasets are written to netCDF files, and read from them."""

from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path

import xarray as xr

from ..files.atomic import is_whole, replacing, seal

ENCODING = {"zlib": True, "complevel": 1, "shuffle": True, "fletcher32": True}
DIGITS = {"quantize_mode", "significant_digits"}
"""Encodings that limit the digits of a variable."""


def write(dataset: xr.Dataset, path: str | Path) -> None:
    """Write a dataset compressed and with checksums, under a temporary name until it is whole."""
    with replacing(path) as temporary, _in_this_thread(dataset):
        axes = dataset.drop_vars(dataset.data_vars)
        no_fill = {key: {"_FillValue": None} for key in axes.coords}  # CF has none on an axis
        # Of a file that it was read from, a dataset would inherit unlimited dimensions.
        options = {"engine": "netcdf4", "unlimited_dims": ()}
        axes.to_netcdf(temporary, encoding=no_fill, **options)
        # Together, dask would write blocks in another order every time.
        for key, variable in dataset.data_vars.items():
            kept = DIGITS & variable.encoding.keys()
            encoding = ENCODING | {digits: variable.encoding[digits] for digits in kept}
            if variable.chunks:  # each block is compressed once
                encoding["chunksizes"] = [size[0] for size in variable.chunks]
            dataset[[key]].to_netcdf(temporary, mode="a", encoding={key: encoding}, **options)
        seal(temporary)


def write_product(
    dataset: xr.Dataset, path: str | Path, summary: Callable[[xr.Dataset], str]
) -> None:
    """Write a dataset, and print its summary, one line."""
    write(dataset, path)
    print(f"{path}: {summary(dataset)}")


def open_whole(path: str | Path, **options) -> xr.Dataset:
    """Open a file of `write`; raises ValueError, one line, if it has changed since.

    options: as for `xarray.open_dataset`
    """
    if not is_whole(path):
        raise ValueError(f"{path}: is damaged; remove it and run again")
    return xr.open_dataset(path, engine="netcdf4", **options)


def _in_this_thread(dataset):
    """Keep dask in this thread for a lazy dataset, as netCDF4 is not safe in threads."""
    if not dataset.chunks:
        return nullcontext()
    import dask  # imported late: only the workflow has lazy ones

    return dask.config.set(scheduler="synchronous")
