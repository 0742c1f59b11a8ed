"""How many cells have been followed, shown to who waits."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[int], object]] = []


def count(cells: int) -> None:
    """Add cells that have been followed."""
    for listen in _listeners:
        listen(cells)


@contextmanager
def counting(what: str, **look) -> Iterator[None]:
    """Show from the third second on how many cells have been followed.

    On a terminal or in a notebook alone, and where tqdm is installed
    look: of `tqdm`, if it is to be otherwise
    """
    try:
        from tqdm.auto import tqdm  # imported late: a solver job does without
    except ModuleNotFoundError:  # of the extra `workflow`
        yield
        return

    usual = {"unit": " cells", "delay": 2.0, "leave": False, "disable": None}
    with tqdm(desc=what, **usual | look) as line:
        _listeners.append(line.update)
        try:
            yield
        finally:
            _listeners.remove(line.update)
