"""Compiled kernels on disk: a damaged file is as none, and its kernel is compiled again."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from numba.core import caching

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
