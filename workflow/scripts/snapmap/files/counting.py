"""A progress line: how many cells have been followed."""

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import RLock

_listeners: list[Callable[[float], object]] = []


def count(cells: float) -> None:
    """Report that so many more cells have been followed; a share of one of a long run."""
    for listen in _listeners:
        listen(cells)


@contextmanager
def counting(what: str, **options) -> Iterator[None]:
    """Show the number of followed cells while the block runs, from its third second on.

    Only a terminal or a notebook shows it, and only if tqdm is installed.
    options: of `tqdm`, in place of the usual ones
    """
    try:
        with warnings.catch_warnings(action="ignore"):  # in a notebook without widgets
            from tqdm.auto import tqdm  # imported late: a solver job needs none
    except ModuleNotFoundError:  # of the extra `workflow`
        yield
        return

    class Line(tqdm):
        _lock = RLock()  # between threads: tqdm's own, between processes, outlives a job's os._exit
        monitor_interval = 0  # no thread, which would not outlive a fork

        @property
        def format_dict(self):
            return super().format_dict | {"n": round(self.n, 2)}

    usual = {"unit": " cells", "delay": 2.0, "leave": False, "disable": None, "miniters": 0}
    with Line(desc=what, **usual | options) as line:
        _listeners.append(line.update)
        try:
            yield
        finally:
            _listeners.remove(line.update)
