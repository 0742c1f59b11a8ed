"""Products that are read are held against their study."""

import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from ..files.text import show


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


def difference(document: Mapping, config: str) -> str:
    """Say where the attribute `config` of a product differs from a study; "" if nowhere.

    Compared are device, pulse, model, and those settings that the product depends on.
    """
    asked, made = json.loads(json.dumps(document, default=str)), json.loads(config)
    if not made:
        return "it names none"
    for key in ("device", "devices", "pulse", "model"):
        if asked.get(key) != made.get(key):
            return _difference(key, asked.get(key), made.get(key))
    for key in asked["sweep"].keys() & made["sweep"].keys():
        if asked["sweep"][key] != made["sweep"][key]:
            return _difference(f"sweep.{key}", asked["sweep"][key], made["sweep"][key])
    return ""


def _difference(key, asked, made):
    if isinstance(asked, dict) and isinstance(made, dict):
        first = next(k for k in {**asked, **made} if asked.get(k) != made.get(k))
        return _difference(f"{key}.{first}", asked.get(first), made.get(first))
    words = ("left out" if value is None else show(value).strip("'") for value in (made, asked))
    return f"{key} is {', not '.join(words)}"
