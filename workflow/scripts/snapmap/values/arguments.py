"""Arguments: from what is written to values, for calls, for records and for sections of a config.

Whatever is written goes one way. A name says which argument it is, the argument has a kind, and
the kind converts the value: `Beam(span="600 um")`, `threshold(study, f0="1 kHz")` and a section of
a config differ in no more than `Reading`. All faults of a call or a section are told at once, a
line for each.
"""

import inspect
from collections.abc import Collection, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, NamedTuple

from .faults import LONGEST_KEY, Faults, line_at
from .units import OF_DAMPER

MOST_KNOWN = 20
"""Most names that a message lists in full; of more, it lists half as many, the nearest."""


class Reading(NamedTuple):
    """How values are converted.

    written: as a config has them, not Python; unit_of_C: as a config spells it, "" for a number
    """

    written: bool = False
    unit_of_C: str = OF_DAMPER


PYTHON = Reading()


class Argument(NamedTuple):
    """The kind of an argument, and whether it may be left out, or be None."""

    kind: Any
    is_optional: bool = False
    may_be_none: bool = False

    def convert(self, value: object, reading: Reading) -> object:
        """Convert a value; ValueError, a line for each fault."""
        if value is None and self.may_be_none and not reading.written:
            return None
        return self.kind.convert(value, reading)


def convert(
    arguments: Mapping[str, Argument],
    given: Mapping,
    reading: Reading = PYTHON,
    faults: Mapping[str | tuple, str] | None = None,
    unknown: str = "unknown key",
    elsewhere: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Convert values by name, in the order given; raises Faults, lines that begin with the name.

    faults: lines that are known before, by name or path
    unknown: what a name is that no argument has; elsewhere: the remedy for some of them
    """
    known = {
        key if isinstance(key, tuple) else (key,): line
        for key, line in (faults or {}).items()
        if not (key in given and line.startswith("missing"))
    }
    lines, values = [line_at(path, line) for path, line in known.items()], {}
    for key, value in given.items():
        try:
            if key not in arguments:
                raise ValueError(f"{unknown}{_remedy(key, arguments, elsewhere or {})}")
            values[key] = arguments[key].convert(value, reading)
        except ValueError as error:
            lines += [line_at((key,), line) for line in lines_of(error)]
    for key, argument in arguments.items():
        if not (argument.is_optional or key in given or (key,) in known):
            lines.append(f"{key}: missing; write {argument.kind.wants(reading)}")
    if lines:
        raise Faults(*lines)
    return values


def lines_of(error: ValueError) -> Sequence[str]:
    """Give the lines of a fault."""
    return error.args if isinstance(error, Faults) else [str(error)]


def _remedy(key, known, elsewhere):
    """Write what to do with an unknown name."""
    if key in elsewhere:
        return elsewhere[key]
    name = str(key)[:LONGEST_KEY]
    if near := nearest(name, [*known, *elsewhere]):
        return near
    names = [*known]
    if len(names) <= MOST_KNOWN:
        return f"; known here are {', '.join(names)}"
    names = get_close_matches(name, names, MOST_KNOWN // 2, 0)
    return f"; known here are {', '.join(names)} and {len(known) - len(names)} others"


def nearest(name: str, known: Iterable[str]) -> str:
    """Ask for the known name that a misspelt one is most like; "" if it is like none."""
    words, name = {word.lower(): word for word in known}, name.lower()
    near = get_close_matches(name, words, 4, 0.75)  # as many cosines as a beam has
    word = min(near, key=lambda word: sorted(word) != sorted(name), default="")
    return f"; did you mean {words[word]}?" if word else ""


def by_name(
    owner: str,
    parameters: Mapping[str, inspect.Parameter],
    positional: Sequence,
    named: Mapping[str, Any],
) -> tuple[dict[str, Any], dict[str, str]]:
    """Give the values of a call by name, and lines, by name, on those that are too many."""
    first = [key for key, part in parameters.items() if part.kind is not part.KEYWORD_ONLY]
    values, faults = dict(zip(first, positional, strict=False)), {}
    if len(positional) > len(first):
        faults[owner] = f"takes {len(first)} arguments without a name, not {len(positional)}"
    faults |= {key: "comes twice; write it once" for key in values if key in named}
    return values | named, faults


def one_time(written: Collection, lasts_itself: bool = False) -> dict[str, str]:
    """Find f0 and duration beside each other, or neither unless the shock sets its duration."""
    if "f0" in written and "duration" in written:
        return {"duration": "excludes f0, which is 1/duration; write one of them"}
    if "f0" in written or "duration" in written or lasts_itself:
        return {}
    return {"f0": "missing; write f0 or duration"}
