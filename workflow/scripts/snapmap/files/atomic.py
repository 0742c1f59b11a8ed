"""Files that stay whole or absent even if a job that writes them is killed; and locks."""

import fcntl
import mmap
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path
from tempfile import NamedTemporaryFile

SEAL = b"BLAKE2b-512 of all bytes before: "
"""This and 64 bytes of hash end a sealed file: HDF5 ignores them, and drops them when it writes."""


@contextmanager
def replacing(path: str | Path) -> Iterator[str]:
    """Yield a temporary path, which replaces `path` once the block has ended without an error.

    Raises OSError, one line with the free space, if the file could not be written.
    """
    # The name holds the process: a job that outlives its run shares no file with the next one's.
    part = f"{path}.{os.getpid()}.part"
    try:
        yield part
        os.replace(part, path)
    except (OSError, RuntimeError) as error:  # netCDF4 raises RuntimeError on a full disk
        free = shutil.disk_usage(Path(path).parent).free / 1e6
        raise OSError(f"{path}: not written, {free:.3g} MB are free there: {error}") from error
    finally:
        Path(part).unlink(missing_ok=True)


def write_text(text: str, path: str | Path) -> None:
    """Write a text to a file, whole or not at all."""
    with replacing(path) as part:
        Path(part).write_text(text, encoding="utf-8")


def seal(path: str | Path) -> None:
    """Append a hash of all bytes to a file: HDF5's own checksums cover the data alone."""
    with open(path, "r+b") as file:
        digest = blake2b(mmap.mmap(file.fileno(), 0)).digest()
        file.seek(0, 2)
        file.write(SEAL + digest)


def is_whole(path: str | Path) -> bool | None:
    """Return whether a file is as `seal` left it; None for a file without a seal."""
    with open(path, "rb") as file:
        size = file.seek(0, 2) - len(SEAL) - 64
        if size <= 0:
            return None
        file.seek(size)
        mark, digest = file.read(len(SEAL)), file.read()
        if mark != SEAL:
            return None
        held = memoryview(mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ))
        return blake2b(held[:size]).digest() == digest


def fingerprint(path: str | Path) -> str:
    """Hash a file to 12 hex digits: its seal, which stands for all bytes, or else its content."""
    with open(path, "rb") as file:
        file.seek(max(0, file.seek(0, 2) - len(SEAL) - 64))
        content = file.read()
        if not content.startswith(SEAL):
            file.seek(0)
            content = file.read()
    return blake2b(content, digest_size=6).hexdigest()


def hold(path: str | Path) -> str:
    """Lock a file until this process ends.

    Returns "", or the error of a file system without locks, as some clusters have.
    Raises BlockingIOError if another process holds the lock.
    """
    try:
        _lock(path)
    except BlockingIOError as error:
        with NamedTemporaryFile(dir=Path(path).parent) as other:
            try:
                _lock(other.name)
            except BlockingIOError:  # though nobody else knows it
                return error.strerror
        raise
    except OSError as error:
        return error.strerror
    return ""


def _lock(path):
    file = os.open(path, os.O_CREAT | os.O_WRONLY)  # stays open
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def remove_leftovers(folder: str | Path) -> None:
    """Remove the temporary files of killed jobs below `folder`."""
    for part in Path(folder).rglob("*.part"):
        part.unlink(missing_ok=True)
