"""Files that are whole or absent, whatever kills the job that writes them, and a folder's lock."""

import fcntl
import mmap
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path

SEAL = b"BLAKE2b-512 of all bytes before: "
"""And the 64 bytes of it end a file: HDF5 reads past neither, and drops both where it writes."""


@contextmanager
def replacing(path: str | Path) -> Iterator[str]:
    """Give a temporary name beside `path`, which is renamed to it when the block has ended well.

    Raises OSError, one line with the space that is left, for what could not be written.
    """
    # The process is part of the name: a job that outlived its run shares no file with its heir.
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
    """Write a text, whole or not at all."""
    with replacing(path) as part:
        Path(part).write_text(text, encoding="utf-8")


def seal(path: str | Path) -> None:
    """End a file with a hash of it: HDF5's own checksums are of the data alone."""
    with open(path, "r+b") as file:
        digest = blake2b(mmap.mmap(file.fileno(), 0)).digest()
        file.seek(0, 2)
        file.write(SEAL + digest)


def is_whole(path: str | Path) -> bool | None:
    """Whether a file is as `seal` left it; None for a file without a seal."""
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
    """Lock a file until this process ends, whatever ends it.

    Returns what the file system says if it has no locks, as some on clusters; else nothing.
    Raises BlockingIOError if another process holds it.
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
    """Raise ValueError, one line, for a folder below `folder` with the ending of a product."""
    for path in Path(folder).rglob("*.*"):
        if path.suffix in endings and path.is_dir():
            raise ValueError(f"{path}: is a folder, where a file belongs; remove it")


def remove_leftovers(folder: str | Path) -> None:
    """Remove the temporary files of killed jobs below `folder`."""
    for part in Path(folder).rglob("*.part"):
        part.unlink(missing_ok=True)
