"""Thresholds as a plain table, for other tools."""

import numpy as np
import pandas as pd
import xarray as xr

from .survey import STATUS


def tidy(thresholds: xr.Dataset) -> pd.DataFrame:
    """Make a table with a row for each threshold: its place on all axes, then its variables.

    thresholds: a Dataset of `threshold`
    Limits of long and short pulses are repeated in each row. `status` is in words. The ends of
    islands are left out.
    """
    N_first = thresholds.N_first
    dims, kept = N_first.dims, [key for key, a in thresholds.items() if "island" not in a.dims]
    table = thresholds[kept].broadcast_like(N_first).transpose(*dims).to_dataframe().reset_index()
    table.insert(len(dims), "duration_ms", 1e3 / table["f0"])
    table["status"] = np.array(STATUS)[table["status"]]
    return table[[*dims, "duration_ms", *kept]]
