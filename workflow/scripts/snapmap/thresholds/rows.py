"""Thresholds as a plain table, for other tools."""

import numpy as np
import pandas as pd
import xarray as xr

from .survey import STATUS


def tidy(thresholds: xr.Dataset) -> pd.DataFrame:
    """Make a table of one row per threshold: its place on all axes, then every value that it has.

    thresholds: as from `threshold`; the limits of long and short pulses stand in each row that has
    them, the ends of islands do not; `status` in words
    """
    N_first = thresholds.N_first
    dims, kept = N_first.dims, [key for key, a in thresholds.items() if "island" not in a.dims]
    wide = thresholds[kept].broadcast_like(N_first).transpose(*dims)
    table = wide.to_dataframe().reset_index()
    table.insert(len(dims), "duration_ms", 1e3 / table["f0"])
    table["status"] = np.array(STATUS)[table["status"]]
    return table[[*dims, "duration_ms", *kept]]
