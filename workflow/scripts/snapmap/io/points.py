"""A user's own points on the maps: a table of shocks, with what the device did under each."""

import csv
import math
from pathlib import Path
from typing import NamedTuple

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
MOST = 10_000


class Point(NamedTuple):
    """A shock, and what the device did under it.

    N: multiples of g; f0: Hz; snapped: None where nobody said
    """

    name: str
    N: float
    f0: float
    snapped: bool | None


def read_points(path: str | Path) -> tuple[Point, ...]:
    """Read points from CSV; raises ValueError, one line, naming file, line, column and fault.

    The header names the columns: N; f0 (Hz) or duration (ms); and, if wanted, name and snapped
    (yes, no or nothing).
    """
    try:
        with open(path, newline="", encoding="utf-8-sig") as file:
            rows = list(csv.reader(file))[: MOST + 2]
        return tuple(_points(rows))
    except FileNotFoundError:
        raise ValueError(f"{path}: is not there") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: is no text in UTF-8") from None
    except (OSError, csv.Error, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ValueError(f"{path}: {reason}") from None


def _points(rows):
    if not rows:
        raise ValueError("is empty; write a header such as N,f0,name,snapped")
    if len(rows) > MOST + 1:
        raise ValueError(f"has more than {MOST} rows; write fewer")
    header = [_column(word.strip()) for word in rows[0]]
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
                raise ValueError(f"line {line}: has {len(row)} columns, the header {len(header)}")
            yield _point(dict(zip(header, map(str.strip, row), strict=True)), line)


def _column(word):
    if word not in COLUMNS:
        known = ", ".join(COLUMNS)
        raise ValueError(f"line 1: column {word!r} is unknown; known are {known}")
    return COLUMNS[word]


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
        raise ValueError(f"line {line}, column {column}: {row[column]!r} is no number above 0")
    return value
