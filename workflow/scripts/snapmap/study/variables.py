"""Attributes of products and, by the tables variables.csv, of their variables; netCDF files."""

import csv
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import xarray as xr

from ..files.atomic import is_whole, replacing, seal
from ..values.kinds import Fitting
from ..values.units import OF_DAMPER
from .axes import attributes_of
from .provenance import provenance


def _has_flags(value):
    return isinstance(value, xr.DataArray) and "flag_meanings" in value.attrs


_FLAGS = Fitting("a variable with flag_meanings, such as cube.outcome", _has_flags)
FlagVariable = Annotated[xr.DataArray, _FLAGS]
_HERE = Path(__file__)
TABLES = [_HERE.with_suffix(".csv"), *sorted(_HERE.parents[1].glob("applications/*/variables.csv"))]
"""Tables of the core, and of each application in its folder."""


def as_dataset(data: Mapping[str, tuple], axes: Mapping[str, np.ndarray]) -> xr.Dataset:
    """Make the dataset that `xr.Dataset` makes of plain arrays of numbers.

    data: dimensions, values and perhaps attributes, by name; axes: values by name
    To see whether an array is theirs, `xr.Dataset` imports dask and pint where these are installed:
    a sixth of the first threshold of a process. An axis of names still does.
    """
    made = {
        key: xr.Variable(dims, np.asarray(values), *attributes, fastpath=True)
        for key, (dims, values, *attributes) in data.items()
    }
    indexes = {key: pd.Index(row) if row.dtype == float else row for key, row in axes.items()}
    return xr.Dataset(made, indexes)


def dress(product: str, dataset: xr.Dataset, document: Mapping, **attributes) -> xr.Dataset:
    """Give a dataset the CF attributes of a product and its variables, and its provenance.

    document: config; attributes: further ones of the product
    Attributes that a variable has already are kept.
    """
    about = variables(product)
    head, unit_of_C = about[""], document.get("model", {}).get("unit_of_C", OF_DAMPER)
    for key, variable in dataset.variables.items():
        variable.attrs = about.get(key, attributes_of(key, unit_of_C)) | variable.attrs
    return dataset.assign_attrs(
        Conventions="CF-1.11, ACDD-1.3",
        title=head["long_name"],
        summary=head["comment"],
        **attributes,
        **provenance(document),
    )


@cache
def variables(product: str) -> Mapping[str, dict]:
    """Read the CF attributes of a product's variables, by name; title and summary are under ""."""
    rows = []
    for path in TABLES:
        with open(path, encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if row.pop("product") == product]
    return {row.pop("name"): _attributes(**row) for row in rows}


def flags(words: Sequence[str]) -> dict:
    """Make the CF attributes of a variable that is an index into words."""
    return {"flag_values": np.arange(len(words), dtype=np.int8), "flag_meanings": " ".join(words)}


def words(variable: FlagVariable) -> xr.DataArray:
    """Give the words of a variable that holds codes, such as the `outcome` of a cube.

    Parameters
    ----------
    variable
        DataArray of codes with the attribute `flag_meanings`; a lazy one stays lazy.

    Returns
    -------
    DataArray
        A word for each code.

    Raises
    ------
    ValueError
        One line, for a variable without words.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines", until="snap")
    >>> cube = snapmap.sweep(study, [800, 1100], 1500, 25)
    >>> (snapmap.words(cube.outcome) == "snapped").values.ravel().tolist()
    [False, True]
    """
    names = np.array(variable.attrs["flag_meanings"].split())
    lazy = {"dask": "parallelized", "output_dtypes": [names.dtype]}
    return xr.apply_ufunc(lambda codes: names[codes.astype(int)], variable, **lazy)


def _attributes(flag_meanings, **texts):
    attributes = {key: text for key, text in texts.items() if text}
    return attributes | (flags(flag_meanings.split()) if flag_meanings else {})


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
