"""Products that are read are held against their study."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from .made import difference


def check_alike(products: Mapping[str | Path, xr.Dataset], document: Mapping) -> None:
    """Raise ValueError, one line, unless products by their paths belong to one study.

    document: of the study, as `Study.document` gives it
    On an axis one product may have more values than another, or fewer.
    """
    for path, product in products.items():
        if why := difference(document, product.attrs.get("config", "{}")):
            raise ValueError(f"{path}: belongs to another study ({why}); remove it and run again")
    (first, cube), *others = products.items()
    for path, other in others:
        axes = [(key, cube[key].values, other[key].values) for key in {*cube.dims} & {*other.dims}]
        for key, u, v in axes:
            if not (np.isin(u, v).all() or np.isin(v, u).all()):
                raise ValueError(
                    f"{first}, {path}: belong to two studies, as {key} differs; remove them and "
                    "run again"
                )
