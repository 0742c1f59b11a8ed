"""A user's own points, shocks that a device was given, from a table."""

from pathlib import Path
from typing import NamedTuple

from ..files.named import naming, read_named
from ..files.tables import ANSWERS, ROWS, SHOCKS, read_table


class Point(NamedTuple):
    """A shock, and whether the device snapped under it.

    N: multiples of g; f0: Hz; snapped: None where the table leaves it open
    """

    name: str
    N: float
    f0: float
    snapped: bool | None


def read_points(path: str | Path, sha256: str = "") -> tuple[Point, ...]:
    """Read a user's own points from CSV; raises ValueError, one line.

    The header names the columns: N; f0 (Hz) or duration (ms); and, if wanted, name and snapped
    (yes, no or nothing).
    sha256: of the file as the run was planned, hex digits; empty for any
    """
    numbers = SHOCKS | {"duration": SHOCKS["duration"] | {"": 1e3}}
    words = {"name": None, "snapped": ANSWERS | {"": None}}
    with naming(path):
        content = read_named(path, *ROWS, sha256)
        table = read_table(content, numbers, words, above=0.0)
        if "N" not in table:
            raise ValueError("line 1: column N is missing")
        if ("f0" in table) == ("duration" in table):
            raise ValueError("line 1: write one of the columns f0 (Hz) and duration (ms)")
    f0 = table["f0"] if "f0" in table else 1e6 / table["duration"]
    names, snapped = table.get("name", [""] * f0.size), table.get("snapped", [None] * f0.size)
    return tuple(map(Point, names, table["N"].tolist(), f0.tolist(), snapped))
