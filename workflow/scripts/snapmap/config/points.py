"""A user's own points: shocks of an experiment, read from a table to be drawn on maps."""

from pathlib import Path
from typing import NamedTuple

from ..files.named import naming, read_named
from ..files.tables import ANSWERS, ROWS, SHOCKS, read_table, shocks_in
from ..files.text import NAME, is_title, show


class Point(NamedTuple):
    """A shock, and whether the device snapped under it.

    N: multiples of g; f0: Hz; snapped: None if the table does not say
    """

    name: str
    N: float
    f0: float
    snapped: bool | None


def read_points(path: str | Path, sha256: str = "", N_of_g: float = 1.0) -> tuple[Point, ...]:
    """Read a user's own points from a CSV file; raises ValueError, one line.

    The columns are N, or N (g); f0 (Hz) or duration (ms); optionally name, and snapped (yes, no
    or empty).
    sha256: hex digits that the file must have, as when the run was planned; empty for any
    N_of_g: N of a shock of 1 g
    """
    numbers = shocks_in(N_of_g) | {"duration": SHOCKS["duration"] | {"": 1e3}}
    words = {"name": None, "snapped": ANSWERS | {"": None}}
    with naming(path):
        content = read_named(path, *ROWS, sha256)
        table = read_table(content, numbers, words, above=0.0)
        if "N" not in table:
            raise ValueError("line 1: column N is missing")
        if ("f0" in table) == ("duration" in table):
            raise ValueError("line 1: write one of the columns f0 (Hz) and duration (ms)")
        names = table.get("name", [""] * table["N"].size)
        if wrong := [name for name in names if name and not is_title(name)]:
            raise ValueError(f"column name: {show(wrong[0])} is not a name of {NAME}, at most 60")
    f0 = table["f0"] if "f0" in table else 1e6 / table["duration"]
    snapped = table.get("snapped", [None] * f0.size)
    return tuple(map(Point, names, table["N"].tolist(), f0.tolist(), snapped))
