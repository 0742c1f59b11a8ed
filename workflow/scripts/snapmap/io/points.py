"""A user's own points on the maps: a table of shocks, with what the device did under each."""

import math
from pathlib import Path
from typing import NamedTuple

from .columns import read_words
from .named import DECIMALS, naming

COLUMNS = {
    "N": "N",
    "f0": "f0",
    "f0 (Hz)": "f0",
    "duration": "duration",
    "duration (ms)": "duration",
    "name": "name",
    "snapped": "snapped",
}
"""What a column is, by its header."""
ANSWERS = {"yes": True, "no": False, "": None}


class Point(NamedTuple):
    """A shock, and what the device did under it.

    N: multiples of g; f0: Hz; snapped: None where nobody said
    """

    name: str
    N: float
    f0: float
    snapped: bool | None


def read_points(path: str | Path, sha256: str = "") -> tuple[Point, ...]:
    """Read points from CSV; raises ValueError, one line, naming file, line, column and fault.

    The header names the columns: N; f0 (Hz) or duration (ms); and, if wanted, name and snapped
    (yes, no or nothing).
    sha256: of the file as it was planned, hex digits; nothing where anything goes
    """
    with naming(path):
        return tuple(_points(read_words(path, "N,f0,name,snapped", sha256)))


def _points(rows):
    header = _header([word.strip() for word in rows[0]])
    for key in header:
        if header.count(key) > 1:
            raise ValueError(f"line 1: column {key} comes twice; write it once")
    if "N" not in header:
        raise ValueError("line 1: column N is missing")
    if ("f0" in header) == ("duration" in header):
        raise ValueError("line 1: write one of the columns f0 (Hz) and duration (ms)")
    for line, row in enumerate(rows[1:], start=2):
        if any(word.strip() for word in row):
            if len(row) != len(header):
                found = f"line {line}: has {len(row)} columns, the header {len(header)}"
                raise ValueError(f"{found}; {DECIMALS}" if len(row) > len(header) else found)
            yield _point(dict(zip(header, map(str.strip, row), strict=True)), line)


def _header(words):
    known = ", ".join(COLUMNS)
    if any(word.strip() in COLUMNS for word in ",".join(words).split(";")[1:]):
        raise ValueError(f"line 1: semicolons separate the columns; write commas; {DECIMALS}")
    if not any(word in COLUMNS for word in words):  # another file, which is not to be quoted
        raise ValueError(f"line 1: names no column of points; known are {known}")
    for word in words:
        if word not in COLUMNS:
            raise ValueError(f"line 1: column {word!r} is unknown; known are {known}")
    return [COLUMNS[word] for word in words]


def _point(row, line):
    if row.get("snapped", "").lower() not in ANSWERS:
        raise ValueError(f"line {line}, column snapped: {row['snapped']!r} is not yes or no")
    f0 = _number(row, "f0", line) if "f0" in row else 1e3 / _number(row, "duration", line)
    answer = ANSWERS[row.get("snapped", "").lower()]
    return Point(row.get("name", ""), _number(row, "N", line), f0, answer)


def _number(row, column, line):
    try:
        value = float(row[column])
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        complaint = f"line {line}, column {column}: {row[column]!r} is no number above 0"
        raise ValueError(f"{complaint}; {DECIMALS}" if "," in row[column] else complaint)
    return value
