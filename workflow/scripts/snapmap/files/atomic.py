"""Files that stay whole or absent even if a job that writes them is killed; and locks."""

import fcntl
import mmap
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path

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


def hold(path: str | Path) -> str:
    """Lock a file until this process ends.

    Returns "", or the error of a file system without locks, as some clusters have.
    Raises BlockingIOError if another process holds the lock.
    """
    file = os.open(path, os.O_CREAT | os.O_WRONLY)  # stays open
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise
    except OSError as error:
        return error.strerror
    return ""


def refuse_folders(folder: str | Path, endings: Sequence[str]) -> None:
    """Raise ValueError, one line, if a folder below `folder` has a name with one of the endings."""
    for path in Path(folder).rglob("*.*"):
        if path.suffix in endings and path.is_dir():
            raise ValueError(f"{path}: is a folder, where a file belongs; remove it")


def remove_leftovers(folder: str | Path) -> None:
    """Remove the temporary files of killed jobs below `folder`."""
    for part in Path(folder).rglob("*.part"):
        part.unlink(missing_ok=True)
