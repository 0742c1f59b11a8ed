"""A table of measured shots, CSV with units, to the columns that a calibration takes."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..checks import show
from .columns import read_words
from .named import DECIMALS, naming

COLUMNS = {
    "N": ("N", 1.0),
    "N (g)": ("N", 1.0),
    "f0 (Hz)": ("f0", 1.0),
    "f0 (kHz)": ("f0", 1e3),
    "duration (us)": ("duration", 1.0),
    "duration (ms)": ("duration", 1e3),
    "duration (s)": ("duration", 1e6),
    **{key: (key, None) for key in ("tripped", "direction", "shape", "file", "unit")},
}
"""What a column is, by its header, and its factor to multiples of g, Hz and us; None for words."""
ANSWERS = {
    **dict.fromkeys(("yes", "true", "1", 1), True),
    **dict.fromkeys(("no", "false", "0", 0), False),
}
"""What a shot did, also as a number."""


def read_shots(path: str | Path, sha256: str = "") -> Mapping[str, list]:
    """Read shots from CSV; raises ValueError, one line, naming file, line, column and fault.

    The header names the columns: N; f0 (Hz, kHz) or duration (us, ms, s); tripped (yes or no);
    and, if wanted, direction, shape, file and unit. An empty number is NaN.
    sha256: of the file as it was planned, hex digits; nothing where anything goes
    """
    with naming(path):
        rows = read_words(path, "N,duration (ms),tripped", sha256)
        return _columns(*_header(rows[0]), rows[1:])


def answers(values: Sequence) -> np.ndarray:
    """Whether each shot tripped, (shots,); ValueError, one line, for what tells it of none."""
    words = [one.strip().lower() if isinstance(one, str) else one for one in values]
    for place, (word, value) in enumerate(zip(words, values, strict=True), start=1):
        if word not in ANSWERS:
            raise ValueError(f"shots, row {place}: tripped: {show(value)} is not true or false")
    return np.array([ANSWERS[word] for word in words], bool)


def _header(row):
    words = [word.strip() for word in row]
    for word in words:
        if word not in COLUMNS:
            known = ", ".join(COLUMNS)
            raise ValueError(f"line 1: column {word!r} is unknown; known are {known}")
    names, factors = zip(*(COLUMNS[word] for word in words), strict=True)
    twice = [name for name in names if names.count(name) > 1]
    if twice:
        raise ValueError(f"line 1: column {twice[0]} comes twice; write one of them")
    return names, factors


def _columns(names, factors, rows):
    columns = {name: [] for name in names}
    for line, row in enumerate(rows, start=2):
        if not any(word.strip() for word in row):
            continue
        if len(row) != len(names):
            raise ValueError(f"line {line}: has {len(row)} columns, not {len(names)}; {DECIMALS}")
        for name, factor, word in zip(names, factors, row, strict=True):
            columns[name].append(_value(name, factor, word.strip(), line))
    return columns


def _value(name, factor, word, line):
    if name == "tripped":
        if word.lower() not in ANSWERS:
            raise ValueError(f"line {line}, column tripped: {word!r} is not yes or no")
        return ANSWERS[word.lower()]
    if factor is None or not word:
        return word if factor is None else math.nan
    try:
        return float(word) * factor
    except ValueError:
        complaint = f"line {line}, column {name}: {word!r} is no number"
        raise ValueError(f"{complaint}; {DECIMALS}" if "," in word else complaint) from None
