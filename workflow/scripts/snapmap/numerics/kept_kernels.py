"""Compiled kernels on disk: a damaged file is as none, and what is compiled anew is said."""

import hashlib
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from numba.core import caching, event, types

DIGEST = hashlib.sha256().digest_size


class CheckedFiles(caching.IndexDataCacheFile):
    """The files of one function in numba's cache, each with the hash of its content at its end.

    numba checks nothing: a flipped byte is a traceback in every job, or another machine code.
    """

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BinaryIO]:
        with super()._open_for_write(filepath) as file:
            yield file
            file.flush()
            file.write(hashlib.sha256(Path(file.name).read_bytes()).digest())

    def _load_index(self) -> dict:
        return super()._load_index() if _is_whole(self._index_path) else {}

    def _load_data(self, name: str) -> tuple:
        if not _is_whole(self._data_path(name)):
            raise FileNotFoundError(name)  # numba takes it for one that was removed
        return super()._load_data(name)


def _is_whole(path):
    try:
        content = Path(path).read_bytes()
    except FileNotFoundError:
        return False
    return hashlib.sha256(content[:-DIGEST]).digest() == content[-DIGEST:]


caching.IndexDataCacheFile = CheckedFiles


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
