"""How many cells have been followed, shown to who waits."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listeners: list[Callable[[int], object]] = []


def count(cells: int) -> None:
    """Add cells that have been followed."""
    for listen in _listeners:
        listen(cells)


@contextmanager
def counting(what: str, **options) -> Iterator[None]:
    """Show from the third second on how many cells have been followed.

    Only a terminal or a notebook shows it, and only where tqdm is installed.
    options: those of `tqdm`, in place of the usual ones
    """
    try:
        from tqdm.auto import tqdm  # imported late: a solver job does without
    except ModuleNotFoundError:  # of the extra `workflow`
        yield
        return

    usual = {"unit": " cells", "delay": 2.0, "leave": False, "disable": None}
    with tqdm(desc=what, **usual | options) as line:
        _listeners.append(line.update)
        try:
            yield
        finally:
            _listeners.remove(line.update)
