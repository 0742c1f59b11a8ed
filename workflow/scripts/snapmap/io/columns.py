"""Tables in CSV: rows of words, and two columns whose header names their units."""

import csv
import io
import re
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from .named import DECIMALS, read_named

MOST_ROWS = 10_000
ROWS = 2_000_000, f"write at most {MOST_ROWS} rows"
"""Bytes that a table of words may have, and what to do about more."""
_UNIT = re.compile(r"[(\[]\s*([^)\]]+?)\s*[)\]]")


def read_words(path: str | Path, header: str, sha256: str = "") -> list[list[str]]:
    """Read the rows of a CSV file, its header first; raises as `read_named` does.

    header: an example; sha256: of the file as it was planned, nothing where anything goes
    """
    text = read_named(path, *ROWS, sha256).decode("utf-8-sig")
    try:
        rows = list(csv.reader(io.StringIO(text, newline="")))
    except csv.Error as error:
        raise ValueError(f"is no CSV ({error})") from None
    if not rows:
        raise ValueError(f"is empty; write a header such as {header}")
    if len(rows) > MOST_ROWS + 1:
        raise ValueError(f"has more than {MOST_ROWS} rows; write fewer")
    return rows


def read_columns(
    content: bytes, kinds: Mapping[str, Sequence], most: int, rows: str
) -> list[np.ndarray]:
    """Read two columns from CSV, in internal units; raises ValueError, one line.

    kinds: of each column by its name, factors by unit and an example of its header
    most: rows that it may have; rows: what they are called
    """
    import pandas  # imported late: most runs read no file

    header = content.splitlines()[0].decode("utf-8-sig", errors="replace")
    separator = max(",;\t", key=header.count)
    names = [name.strip().strip('"') for name in header.split(separator)]
    if len(names) != 2:
        raise ValueError(f"has {len(names)} columns; write two, {' and '.join(kinds)}")
    scales = [_scale(name, *kind) for name, kind in zip(names, kinds.values(), strict=True)]
    reading = {"sep": separator, "names": ["x", "y"], "header": 0, "index_col": False}
    try:
        with warnings.catch_warnings(action="error", category=pandas.errors.ParserWarning):
            table = pandas.read_csv(io.BytesIO(content), nrows=most + 1, **reading)
    except pandas.errors.ParserWarning:  # it would leave out what is beyond two columns
        raise ValueError(f"line 2: has more than two columns; {DECIMALS}") from None
    except (pandas.errors.ParserError, pandas.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise ValueError(f"is no CSV of two columns ({error}); {DECIMALS}") from None
    if len(table) > most:
        raise ValueError(f"has more than {most} {rows}; write fewer")
    columns = []
    for key, name, scale in zip("xy", names, scales, strict=True):
        values = pandas.to_numeric(table[key], errors="coerce").to_numpy(float)
        if not np.isfinite(values).all():
            row = int(np.flatnonzero(~np.isfinite(values))[0])
            complaint = f"line {row + 2}, {name}: is no finite number"
            comma = "," in str(table[key][row])
            raise ValueError(f"{complaint}; {DECIMALS}" if comma else complaint)
        columns.append(values * scale)
    return columns


def _scale(name, units, example):
    found = _UNIT.search(name)
    unit = found.group(1) if found else ""
    if unit not in units:
        what = f"unit {unit!r} is unknown" if unit else "names no unit"
        raise ValueError(f"header {name!r} {what}; write such as {example}, of {', '.join(units)}")
    return units[unit]
