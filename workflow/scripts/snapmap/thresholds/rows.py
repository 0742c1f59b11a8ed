"""Thresholds as a plain table, for other tools."""

import numpy as np
import pandas as pd
import xarray as xr

from .islands import STATUS


def tidy(found: xr.Dataset) -> pd.DataFrame:
    """One row per threshold: where it stands on all axes, then every value that it has.

    found: as from `threshold`; the limits of long and short pulses stand in each row that has them,
    the ends of islands do not; `status` in words
    """
    dims = found.N_first.dims
    kept = [key for key in found.data_vars if "island" not in found[key].dims]
    wide = found[kept].broadcast_like(found.N_first).transpose(*dims)
    table = wide.to_dataframe().reset_index()
    table.insert(len(dims), "duration_ms", 1e3 / table["f0"])
    table["status"] = np.array(STATUS)[table["status"]]
    return table[[*dims, "duration_ms", *kept]]
