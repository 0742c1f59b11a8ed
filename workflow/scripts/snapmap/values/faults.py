"""Faults of a config or a call, one line each."""

import inspect
import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from ..files.text import describe

MOST_ALIKE = 3
"""Most faults of items of a list that have a line each."""
LONGEST_KEY = 40
_BEGINS = re.compile(r"[A-Za-z_]\w*(\.\w+|\[[^]]*\])*: ")
_WITHIN = re.compile(r"(\.[A-Za-z_]\w*|\[[^]]*\])+: ")


class Faults(ValueError):
    """Faults, one line each, in `args`."""

    def __str__(self):
        """Write all lines."""
        return "\n".join(self.args)


class WrongCall(Faults, TypeError):
    """Faults of a call: of names and of values."""


def warn(line: str) -> None:
    """Warn, as if it arose there, in the line of the code that has called the package."""
    names = [place.frame.f_globals.get("__name__") for place in inspect.stack(0)]
    ours = [depth for depth, name in enumerate(names) if str(name).startswith("snapmap.")]
    warnings.warn(line, stacklevel=2 + ours[-1])


def few(lines: Sequence[str]) -> list[str]:
    """Keep the faults of a list's items, or of more than MOST_ALIKE the first and their number."""
    if len(lines) <= MOST_ALIKE:
        return [*lines]
    return [f"{lines[0]} (and {len(lines) - 1} others of this list)"]


def line_at(path: Sequence[str | int], line: str) -> str:
    """Put the name of its key before a fault, unless the line has it, or begins with `.key: `."""
    name = name_of(path)
    if _WITHIN.match(line):
        return f"{name if path else ''}{line}".removeprefix(".")
    return line if line.startswith((f"{name}:", f"{name}.")) else f"{name}: {line}"


@contextmanager
def at_key(*path: str | int) -> Iterator[None]:
    """Put the name of a key, as `.key: ` or `[place]: `, before a fault of the block."""
    try:
        yield
    except ValueError as error:
        raise ValueError(within(line_at(path, str(error)))) from None


def name_of(path: Sequence[str | int]) -> str:
    """Write a path as `device.beam.span` or `sweep.f0[2]`; the document itself is `config`."""
    name = ""
    for key in path:
        plain = isinstance(key, str) and key.isidentifier() and len(key) <= LONGEST_KEY
        name += f".{key}" if plain else f"[{describe(key, LONGEST_KEY)}]"
    return name.removeprefix(".") or "config"


def within(line: str) -> str:
    """Mark a line that begins with the name of a key as one of the section around it."""
    return f".{line}" if _BEGINS.match(line) else line
