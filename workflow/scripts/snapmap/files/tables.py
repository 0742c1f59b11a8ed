"""CSV tables whose header names columns and units; errors name the line and the column."""

import codecs
import csv
import io
import math
import re
from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from .atomic import replacing
from .text import show

if TYPE_CHECKING:
    import pandas

ALONG = "along "
"""What a direction begins with in a CSV."""
DIGITS = 6
"""Significant digits of computed numbers in a CSV."""

DECIMALS = "write numbers without a comma, such as 1000, or 1.5 for one and a half"
"""Remedy for a table with commas in its numbers."""
MOST_ROWS = 10_000
ROWS = 2_000_000, f"write at most {MOST_ROWS} rows"
"""Most bytes of a table of shocks, and the remedy for a larger one, as `read_named` takes them."""
SHOCKS = {
    "N": {"": 1.0, "g": 1.0},
    "f0": {"Hz": 1.0, "": 1.0, "kHz": 1e3},
    "duration": {"ms": 1e3, "us": 1.0, "s": 1e6},
}
"""Factors to multiples of g, Hz and us, by column and unit."""
ANSWERS = {
    **dict.fromkeys(("yes", "true", "1", 1), True),
    **dict.fromkeys(("no", "false", "0", 0), False),
}
"""Words and numbers that say whether a device tripped."""
_UNIT = re.compile(r"[(\[]([^)\]]+)[)\]]$")
_FACTOR = re.compile(r"[*×]|10\^|(?<!\w)(x ?\d[\d.eE^]|\d[\d.]*[eE][-+]?\d)")
"""What tells in a head that its numbers are to be multiplied."""
_LAST = re.compile(rb"[^\n]*\n\s*[-+.\d]")
"""A line before one that begins with a number."""


def write_table(
    table: "pandas.DataFrame",
    path: str | Path,
    units: Mapping[str, str],
    exact: Collection[str] = (),
) -> None:
    """Write a table as CSV, as spreadsheets and `read_table` take it.

    units: by column, as its head names them in brackets; a number that is not known stays empty
    exact: columns that keep all digits; others have DIGITS, about two more than their errors allow
    Words that begin with a sign, as a direction does, come after ALONG: they would be formulas.
    """
    written = {}
    for key, values in table.items():
        head = f"{key} ({units[key]})" if units.get(key) else str(key)
        if values.dtype.kind == "f" and key not in exact:
            values = values.map(lambda number: float(f"{number:.{DIGITS}g}"))
        elif values.dtype.kind not in "fiub":
            values = [ALONG * str(word).startswith(("+", "-")) + str(word) for word in values]
        written[head] = values
    with replacing(path) as part:
        type(table)(written).to_csv(part, index=False)


def read_rows(path: str | Path) -> list[dict[str, str]]:
    """Read the rows of a table of `write_table` as text, by the names of its columns."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = csv.DictReader(file)
        return [{name_in(key): row[key].removeprefix(ALONG) for key in row} for row in rows]


def name_in(head: str) -> str:
    """Give the name of a column by its head, which may end with a unit."""
    return _UNIT.sub("", head).strip()


def shocks_in(N_of_g: float) -> dict[str, Mapping[str, float]]:
    """Give SHOCKS for a device whose N of a shock of 1 g is `N_of_g`."""
    return SHOCKS | {"N": {"": 1.0, "g": N_of_g}}


def read_table(
    content: bytes,
    numbers: Mapping[str, Mapping[str, float]],
    words: Mapping[str, Mapping | None] = MappingProxyType({}),
    most: int = MOST_ROWS,
    above: float = -math.inf,
    gaps: bool = False,
    rising: str = "",
) -> dict[str, np.ndarray]:
    """Read the columns of a CSV; raises ValueError, one line without the file's name.

    Lines that begin with # before the header are left out.
    numbers: factors by unit, for each column of numbers, which must be finite and above `above`;
        without `words` the columns come in this order, whatever the header calls them
    words: meanings of its words, for each column of words; None where any word is right
    most: rows; gaps: whether a number may be missing, and then is NaN
    rising: column whose numbers must ascend
    Returns each column, (rows,), numbers times the factor of their unit.
    """
    import pandas  # imported late: most runs read no table

    comments, content = _without_comments(content.removeprefix(codecs.BOM_UTF8))
    header, _, body = content.partition(b"\n")
    header, second = header.decode(), body.partition(b"\n")[0].decode(errors="replace")
    if not header.strip():
        raise ValueError(f"is empty; write a header of {', '.join([*numbers, *words])}")
    separator = max(",;\t", key=header.count)
    head = [word.strip().strip('"') for word in header.split(separator)]
    keys = _keys(head, numbers, words, comments + 1)
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
        raise ValueError(f"is not a CSV of {len(keys)} columns ({error})") from None
    if not isinstance(table.index, pandas.RangeIndex):  # pandas makes surplus columns the index
        remedy = f"write {len(keys)}" if "." in second else DECIMALS
        columns = 1 + second.count(separator)
        raise ValueError(f"line {comments + 2}: has {columns} columns; {remedy}")
    if len(table) > most:
        raise ValueError(f"has more than {most} rows; write fewer")
    table = table[(table.notna() & (table != "")).any(axis=1)]
    columns = {}
    for key in keys:
        if key in numbers:
            values = pandas.to_numeric(table[key], errors="coerce")
            right = (values > above) & (values < math.inf) | (gaps & table[key].isna())
            need = "not a finite number" if above < 0 else f"not a number above {above:g}"
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
            place = f"line {comments + line + 2}, column {key}"
            raise ValueError(f"{place}: {show(word)} is {need}{remedy}")
    if rising:
        lines = comments + table.index.to_numpy() + 2
        require_rising(columns[rising], rising, "line", lines)
    return columns


def require_rising(values: np.ndarray, name: str, what: str, numbers: np.ndarray) -> None:
    """Raise ValueError, one line, unless values ascend; numbers: of what has each of them."""
    steps = np.diff(values)
    for place in np.flatnonzero(steps <= 0):
        is_same = steps[place] == 0
        fault = "that of the one before; remove one" if is_same else "before the last; sort them"
        raise ValueError(f"{what} {numbers[place + 1]}: {name} is {fault}")


def _without_comments(content):
    """Cut off the lines before a header that begin with #, and its own #; returns also how many."""
    number = 0
    while content.startswith(b"#") and not _LAST.match(content):
        number, content = number + 1, content.partition(b"\n")[2]
    return number, content.removeprefix(b"#")


def _keys(head, numbers, words, line):
    """Name each column: by its head, or by its place if there are no columns of words."""
    known = ", ".join([*numbers, *words])
    if not words:
        if len(head) != len(numbers):
            need = f"write {len(numbers)}, {known}, or # before a comment"
            raise ValueError(f"line {line}: the header has {len(head)} columns; {need}")
        return list(numbers)
    keys = [name_in(word) for word in head]
    unknown = [key for key in keys if key not in {*numbers, *words}]
    if len(unknown) == len(keys):  # it is some other file: the message quotes nothing of it
        raise ValueError(f"line {line}: has no known column; write {known}")
    if unknown:
        raise ValueError(f"line {line}: column {show(unknown[0])} is unknown; known are {known}")
    if twice := [key for key in keys if keys.count(key) > 1]:
        raise ValueError(f"line {line}: column {twice[0]} comes twice; write one of them")
    return keys


def _scale(word, key, numbers):
    """Return the factor of a column of numbers by the unit in its head; 1 for a column of words."""
    units, unit = numbers.get(key, {"": 1.0}), "".join(_UNIT.findall(word)[:1]).strip()
    if unit not in units:
        what = f"unit {show(unit)} is unknown" if unit else "does not end with a unit"
        heads = " or ".join(f"{key} ({unit})" if unit else key for unit in units)
        raise ValueError(f"header {show(word)} {what}; write {heads}")
    if _FACTOR.search(_UNIT.sub("", word)):
        raise ValueError(f"header {show(word)} has a factor; multiply the numbers by it")
    return units[unit]
