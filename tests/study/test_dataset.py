"""Datasets of plain arrays are those of xarray, made without packages of other arrays."""

import numpy as np
import xarray as xr
from small_studies import cases_of

from snapmap.study.variables import as_dataset


def test_a_dataset_is_that_of_xarray():
    axes = {"device": np.array(["thin", "thick"]), "C": np.array([0.0, 25.0, np.inf])}
    data = {
        "status": (("device", "C"), np.zeros((2, 3), np.int8), {"flag_meanings": "found"}),
        "N_first": (("device", "C"), np.array([[1.0, np.nan, 2.0], [3.0, 4.0, np.nan]])),
        "edges": (("C", "island"), np.ones((3, 2))),
        "area": ((), 0.6),
    }
    made, by_xarray = as_dataset(data, axes), xr.Dataset(data, axes)
    xr.testing.assert_identical(made, by_xarray)
    assert all(made[key].dtype == by_xarray[key].dtype for key in made.variables)
    assert made.indexes["C"].equals(by_xarray.indexes["C"])


def test_a_threshold_imports_neither_dask_nor_pint(python):
    said, faults = python(*cases_of(__file__).values())
    assert said == "set()\n", faults
