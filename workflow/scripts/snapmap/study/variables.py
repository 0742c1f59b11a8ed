"""Attributes of products and, by the tables variables.csv, of their variables."""

import csv
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import xarray as xr

from .axes import COORDINATES
from .provenance import provenance

_HERE = Path(__file__)
TABLES = [_HERE.with_suffix(".csv"), *sorted(_HERE.parents[1].glob("applications/*/variables.csv"))]
"""Tables of the core, and of each application in its folder."""


def dress(product: str, dataset: xr.Dataset, document: Mapping, **attributes) -> xr.Dataset:
    """Give a dataset the CF attributes of a product and its variables, and its provenance.

    document: config; attributes: further ones of the product
    Attributes that a variable has already are kept.
    """
    about = variables(product)
    head = about[""]
    for key, variable in dataset.variables.items():
        variable.attrs = about.get(key, COORDINATES.get(key, {})) | variable.attrs
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


def _attributes(flag_meanings, **texts):
    attributes = {key: text for key, text in texts.items() if text}
    return attributes | (flags(flag_meanings.split()) if flag_meanings else {})
