"""Tables in CSV whose header names columns and units; a fault is one line, with line and column."""

import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from .named import naming, read_named
from .text import show

DECIMALS = "write decimals with a point, not a comma"
"""Remedy for a table of a country that writes decimals with a comma."""
MOST_ROWS = 10_000
ROWS = 2_000_000, f"write at most {MOST_ROWS} rows"
"""Most bytes of a table of shocks, and the remedy for more, as `read_named` takes both."""
SHOCKS = {
    "N": {"": 1.0, "g": 1.0},
    "f0": {"Hz": 1.0, "": 1.0, "kHz": 1e3},
    "duration": {"ms": 1e3, "us": 1.0, "s": 1e6},
}
"""Columns of numbers, and by unit the factors to multiples of g, Hz and us."""
ANSWERS = {
    **dict.fromkeys(("yes", "true", "1", 1), True),
    **dict.fromkeys(("no", "false", "0", 0), False),
}
"""Words and numbers that say whether a device tripped."""
SHOTS = {"tripped": ANSWERS, **dict.fromkeys(("direction", "shape", "file"))}
"""Columns of words in a table of shots, with their meanings; None where any word goes."""
_UNIT = re.compile(r"[(\[]([^)\]]+)[)\]]")


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


def read_shots(path: str | Path, sha256: str = "") -> dict[str, np.ndarray]:
    """Read shots from CSV, columns by name; raises ValueError, one line.

    The header names the columns: N; f0 (Hz, kHz) or duration (us, ms, s); tripped (yes or no);
    and, if wanted, direction, shape and file. An empty number is NaN.
    sha256: of the file as the run was planned, hex digits; empty for any
    """
    with naming(path):
        content = read_named(path, *ROWS, sha256)
        return read_table(content, SHOCKS, SHOTS, above=0.0, gaps=True)


def shot_columns(shots: str | Path | Mapping[str, Sequence]) -> dict[str, np.ndarray]:
    """Columns of shots from a file, or as they are given; ValueError, one line, if they cannot be.

    N, f0 (Hz) and duration (us) are above 0, or NaN; tripped are bools, the others text. N may be
    missing beside file.
    """
    table = read_shots(shots) if isinstance(shots, str | Path) else shots
    columns = {str(key): np.asarray(table[key]).ravel() for key in table}
    known = f"columns are {', '.join([*SHOCKS, *SHOTS])}"
    for key in columns:
        if key not in SHOCKS | SHOTS:
            raise ValueError(f"shots: column {key!r} is unknown; {known}")
    for key in ("tripped",) if "file" in columns else ("N", "tripped"):
        if key not in columns:
            raise ValueError(f"shots: column {key} is missing; {known}")
    sizes = {key: values.size for key, values in columns.items()}
    if len(set(sizes.values())) > 1:
        raise ValueError(f"shots: columns differ in length, {sizes}; write a row for each shot")
    for key, values in columns.items():
        entries = [_entry(key, row, value) for row, value in enumerate(values.tolist(), 1)]
        kind = bool if key == "tripped" else float if key in SHOCKS else object
        columns[key] = np.array(entries, kind)
    return columns


def _entry(key, row, value):
    """Convert a value of a column of shots: whether it tripped, a number or NaN, or text."""
    is_empty = value is None or value == "" or value != value
    if key == "tripped":
        word = value.strip().lower() if isinstance(value, str) else value
        if word not in ANSWERS:
            raise ValueError(f"shots, row {row}: tripped: {show(value)} is not true or false")
        return ANSWERS[word]
    if key in SHOTS:
        return "" if is_empty else str(value)
    try:
        number = math.nan if is_empty else float(value)
    except (TypeError, ValueError):
        number = 0.0
    if not (is_empty or 0 < number < math.inf):
        raise ValueError(f"shots, row {row}: {key}: {show(value)} is no number above 0")
    return number


def read_verdicts(path: str | Path) -> list[dict]:
    """Read the rows of requirements.csv: names stay text, even such as 12 or nan.

    `must_snap` is True, False or `any`.
    """
    import pandas  # imported late: most runs read no table

    text = {"dtype": str, "keep_default_na": False}
    words = pandas.read_csv(path, usecols=["requirement", "device", "must_snap"], **text)
    truths = {"True": True, "False": False}
    must_snap = words.must_snap.map(lambda word: truths.get(word, word))
    rows = pandas.read_csv(path).assign(**words.assign(must_snap=must_snap))
    return rows.to_dict("records")


def read_table(
    content: bytes,
    numbers: Mapping[str, Mapping[str, float]],
    words: Mapping[str, Mapping | None] = MappingProxyType({}),
    most: int = MOST_ROWS,
    above: float = -math.inf,
    gaps: bool = False,
) -> dict[str, np.ndarray]:
    """Read columns from CSV, each in one unit; raises ValueError, one line without the file's name.

    numbers: factors by unit of each column of numbers, which are finite and above `above`; where no
        other columns may be, they come in this order, whatever the header calls them
    words: of each column of words their meanings, or None where any goes
    most: rows that it may have; gaps: whether a missing number is NaN
    """
    import pandas  # imported late: most runs read no table

    header = content.partition(b"\n")[0].decode("utf-8-sig")
    if not header.strip():
        raise ValueError(f"is empty; write a header of {', '.join([*numbers, *words])}")
    separator = max(",;\t", key=header.count)
    head = [word.strip().strip('"') for word in header.split(separator)]
    keys = _keys(head, numbers, words)
    scales = {key: _scale(word, key, numbers) for key, word in zip(keys, head, strict=True)}
    try:
        table = pandas.read_csv(
            io.BytesIO(content),
            sep=separator,
            names=keys,
            header=0,
            nrows=most + 1,
            skipinitialspace=True,
            skip_blank_lines=False,
            low_memory=False,
            keep_default_na=False,
            na_values={key: [""] for key in numbers},
            dtype=dict.fromkeys(words, str),
        )
    except pandas.errors.ParserError as error:
        raise ValueError(f"is no CSV of {len(keys)} columns ({error}); {DECIMALS}") from None
    if not isinstance(table.index, pandas.RangeIndex):  # made of what is beyond the header
        raise ValueError(f"line 2: has more than {len(keys)} columns; {DECIMALS}")
    if len(table) > most:
        raise ValueError(f"has more than {most} rows; write fewer")
    table = table[(table.notna() & (table != "")).any(axis=1)]
    columns = {}
    for key in keys:
        if key in numbers:
            values = pandas.to_numeric(table[key], errors="coerce")
            right = (values > above) & (values < math.inf) | (gaps & table[key].isna())
            need = "no finite number" if above < 0 else f"no number above {above:g}"
            columns[key] = values.to_numpy(float) * scales[key]
        else:
            values = table[key].str.strip()
            meanings = words[key] or dict(zip(values, values, strict=True))
            lower = values if words[key] is None else values.str.lower()
            right, need = lower.isin(list(meanings)), "not yes or no"
            columns[key] = np.array([meanings.get(word) for word in lower], object)
        for line in table.index[~right]:
            word = str(table[key][line]) if table[key].notna()[line] else ""
            remedy = f"; {DECIMALS}" if "," in word else ""
            raise ValueError(f"line {line + 2}, column {key}: {word!r} is {need}{remedy}")
    return columns


def _keys(head, numbers, words):
    """Name each column, by its head or, where there are no words, by its place."""
    known = ", ".join([*numbers, *words])
    if not words:
        if len(head) != len(numbers):
            raise ValueError(f"has {len(head)} columns; write {len(numbers)}, {known}")
        return list(numbers)
    keys = [_UNIT.sub("", word).strip() for word in head]
    unknown = [key for key in keys if key not in {*numbers, *words}]
    if len(unknown) == len(keys):  # another file, which is not to be quoted
        raise ValueError(f"line 1: names no column of this table; known are {known}")
    if unknown:
        raise ValueError(f"line 1: column {unknown[0]!r} is unknown; known are {known}")
    if twice := [key for key in keys if keys.count(key) > 1]:
        raise ValueError(f"line 1: column {twice[0]} comes twice; write one of them")
    return keys


def _scale(word, key, numbers):
    """Give the factor of a column of numbers, by the unit in its header; 1 of one of words."""
    units, unit = numbers.get(key, {"": 1.0}), "".join(_UNIT.findall(word)[:1]).strip()
    if unit not in units:
        what = f"unit {unit!r} is unknown" if unit else "names no unit"
        raise ValueError(f"header {word!r} {what}; write such as {key} ({next(iter(units))})")
    return units[unit]
