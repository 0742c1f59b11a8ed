"""Text for messages and tables: values in one line, names, and tables in Markdown."""

import hashlib
import math
import re
import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from numbers import Number
from os import PathLike

import numpy as np

LONGEST = 60
"""Most characters of a value in a message."""
LONGEST_STEM = 80
"""Most characters of a file's name that is made of values, without its ending."""


def show(value: object) -> str:
    """Write a value in one short line; of an object other than plain data only its type."""
    value = str(value) if isinstance(value, PathLike) else value
    if not isinstance(value, str | bytes | Number | list | tuple | dict | None):
        name = type(value).__name__
        return f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"
    try:
        text = reprlib.repr(value.item() if isinstance(value, np.generic) else value)
    except ValueError:  # an int of more than 4300 digits
        return "a number of thousands of digits"
    text = " ".join(text.split())
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 4]}...{text[-1]}"


FEW = 4
"""Most items of a list or mapping that `describe` shows."""


def describe(value: object, longest: int = LONGEST) -> str:
    """Quote a value of a config, in one line; text of more than `longest` signs is cut."""
    if isinstance(value, Mapping):
        keys = f" of {', '.join(map(describe, value))}" if 0 < len(value) <= FEW else ""
        return f"a mapping{keys}"
    if isinstance(value, list | tuple):
        if any(isinstance(item, Mapping | list | tuple) for item in value) or len(value) > FEW:
            return "a list"
        return f"the list {', '.join(map(describe, value))}" if value else "an empty list"
    if value is None or isinstance(value, bool):
        return {None: "an empty value", True: "true", False: "false"}[value]
    text = repr(value)
    return text if len(text) <= longest else f"{text[:40]}...{text[-1]}"


NAME = "letters, digits, spaces, .,:()/%+-_, the first a letter or digit"
"""What `is_name` takes, in words."""


def is_name(text: str) -> bool:
    """Return whether a text is safe as it is in CSV, in Markdown and on the page."""
    return re.fullmatch(r"[^\W_][\w .,:()/%+-]*", text) is not None


def is_title(value: object) -> bool:
    """Tell whether a value is a name of at most 60 signs."""
    return isinstance(value, str) and len(value) <= 60 and is_name(value)


SIGNS = '<>&|"`*[]\\'
"""Signs to which Markdown, HTML or CSV give a meaning."""


def is_showable(text: str) -> bool:
    """Return whether a text is without SIGNS, and without those that steer a terminal."""
    return text.isprintable() and not set(SIGNS).intersection(text)


def exact(value: float) -> str:
    """Write a number for a file's name, in as few digits from 15 on as give it back."""
    words = (f"{value:.{digits}g}" for digits in (15, 16, 17))
    return "hard" if value == math.inf else next(word for word in words if float(word) == value)


def stem_of(*words: str) -> str:
    """Join words to the name of a file without its ending, unique to them.

    A name that is too long is cut, and a sign that no file should have replaced by `_`; then the
    name ends with the beginning of the SHA-256 of all words.
    """
    whole = "_".join(words).replace(" ", "_")
    name = re.sub(r"[^\w.+-]", "_", whole, flags=re.ASCII)
    if name == whole and len(name) <= LONGEST_STEM:
        return name
    ending = f"_{hashlib.sha256(whole.encode()).hexdigest()[:8]}"
    return name[: LONGEST_STEM - len(ending)] + ending


def plain(value: float, digits: int = 4) -> str:
    """Write a number with so many significant digits, without an exponent if it is not extreme."""
    return f"{float(f'{value:.{digits}g}'):.12g}"


def leaves(section: Mapping, path: str = "") -> Iterator[tuple[str, str]]:
    """Yield the path of each key in a section of a config, and its value as text."""
    for key, value in section.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{path}{key}.")
        else:
            yield f"{path}{key}", str(value)


DASH = "–"


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Write a Markdown table, its first column left-aligned; dashes fill up short rows."""
    rule = f"|:--{'|--:' * (len(head) - 1)}|\n"
    filled = [[*row, *[DASH] * (len(head) - len(row))] for row in rows]
    first, *others = (f"| {' | '.join(cells)} |\n" for cells in (head, *filled))
    return "".join((first, rule, *others))
