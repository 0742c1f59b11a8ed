"""How much a study takes: all, or with --small just what shows that it runs."""

import sys
from collections.abc import Mapping, Sequence
from itertools import islice

SMALL = "--small"


def is_small() -> bool:
    """Whether the command asks for a small run."""
    return SMALL in sys.argv[1:]


def few(values: Sequence | Mapping | int, count: int = 1) -> Sequence | Mapping | int:
    """All values, or how many there are; in a small run the first `count`."""
    if not is_small():
        return values
    if isinstance(values, int):
        return min(values, count)
    return dict(islice(values.items(), count)) if isinstance(values, Mapping) else values[:count]
