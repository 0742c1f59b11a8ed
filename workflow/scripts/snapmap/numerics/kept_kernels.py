"""Compiled kernels, and these on disk: never of another source."""

import hashlib
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path

from numba import njit
from numba.core import config, event, types
from numba.misc.appdirs import AppDirs

INLINED = "forceinline", "no_cpython_wrapper", "no_cfunc_wrapper"
"""Options of what is compiled into its callers alone."""


def compiled(function: Callable) -> Callable:
    """Compile a function for the types that it is called with, and keep that on disk.

    No fast maths: NaN stays visible, and a result does not depend on how a call was compiled. What
    speed needs is written out: fused multiply-adds, and sums in an order that vectorises over
    lanes. numba reads where to keep it here, and no other package's functions are moved.
    """
    users = config.CACHE_DIR
    own = users or AppDirs("snapmap", False).user_cache_dir
    config.CACHE_DIR = str(Path(own, _name_of_sources(Path(function.__code__.co_filename).parent)))
    try:
        # numba hands the options of an inlined caller down unless they are said.
        return njit(nogil=True, cache=True, error_model="numpy", **dict.fromkeys(INLINED, False))(
            function
        )
    finally:
        config.CACHE_DIR = users


def inlined(function: Callable) -> Callable:
    """Compile a function into each of its callers, without which nothing is vectorised.

    Python itself cannot call it: what that takes would be half of its time to compile.
    """
    return njit(error_model="numpy", **dict.fromkeys(INLINED, True))(function)


@cache
def _name_of_sources(room):
    """A name for what kernels of a folder are compiled from: its modules and those of this one.

    numba by itself sees an edit in the file of the function, and none in a file of what it calls.
    """
    digest = hashlib.sha256()
    for path in sorted({*room.glob("*.py"), *Path(__file__).parent.glob("*.py")}):
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return f"kernels_{digest.hexdigest()[:12]}"


class Teller(event.Listener):
    """Says once what size of kernel is compiled: a user would else wait in silence."""

    def __init__(self):
        """Begin with no compilation under way, and none told."""
        self.depth, self.told = 0, set()

    def on_start(self, told: event.Event) -> None:
        """Take note of a compilation; those within another are a part of it."""
        self.depth += 1
        sizes = [kind.count for kind in told.data["args"] if isinstance(kind, types.UniTuple)]
        if self.depth > 1 or not sizes or sizes[0] in self.told:
            return
        self.told.add(sizes[0])
        # Where numba was called from is of no interest.
        words = f"compiling the kernel of {sizes[0]} modes: once, some seconds"
        warnings.warn_explicit(words, UserWarning, "snapmap", 1)

    def on_end(self, told: event.Event) -> None:
        """Take note of its end."""
        self.depth -= 1


event.register("numba:compile", Teller())
