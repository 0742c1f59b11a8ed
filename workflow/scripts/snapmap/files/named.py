"""Files that a config names: they are of bounded size, and as they were when a run was planned."""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path, PurePath

from .text import SIGNS, describe, is_showable

PLANNED = "SNAPMAP_PLANNED"
"""Environment variable by which jobs inherit the hashes of files."""
EDITED = "was edited after the run was planned; run again"


@contextmanager
def naming(path: str | Path) -> Iterator[None]:
    """Turn an error of the block into a ValueError, one line that begins with the path."""
    if not str(path).isprintable():
        path = repr(str(path))
    try:
        yield
    except FileNotFoundError:
        raise ValueError(f"{path}: is not there") from None
    except UnicodeDecodeError:
        raise ValueError(f"{path}: is not text in UTF-8") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ValueError(f"{path}: {' '.join(reason.split())}") from None


def read_named(path: str | Path, most: int, remedy: str, sha256: str = "") -> bytes:
    """Read a whole file; raises OSError, or ValueError without its name, for a wrong one.

    most: bytes; remedy: what to do about a larger file, such as "write at most 100 rows"
    sha256: expected hash of the content, hex digits; empty for any
    """
    path = Path(path)
    size = path.stat().st_size
    if not path.is_file():  # a pipe or a device may never end
        raise ValueError("is not a file")
    if size > most:
        raise ValueError(f"has {size / 1e6:.0f} MB; {remedy}")
    with open(path, "rb") as file:
        content = file.read(most)
    if sha256 and hashlib.sha256(content).hexdigest() != sha256:
        raise ValueError("was edited: its SHA-256 is not the expected one")
    return content


def sha256_of(path: str | Path, most: int, remedy: str) -> str:
    """Hash the content of a file, read by `read_named`; raises ValueError, one line."""
    with naming(path):
        return hashlib.sha256(read_named(path, most, remedy)).hexdigest()


def inside(file: str) -> str:
    """Return the path of a file in the study's folder; ValueError, one line, for any other.

    Paths stand in tables and on the terminal.
    """
    if not is_showable(file):
        raise ValueError(
            f"{describe(file)} has signs that do not print or are in {SIGNS}; rename it"
        )
    if PurePath(file).is_absolute() or ".." in PurePath(file).parts:
        raise ValueError(f"{file} lies outside the study's folder; copy it there")
    return file


def plan_with(files: Mapping[str, str]) -> None:
    """Let the jobs of a run inherit the hashes of files, by path or by what the files are."""
    os.environ[PLANNED] = json.dumps(files)


def hold_to_plan(files: Mapping[str, str]) -> None:
    """Raise ValueError, one line, if a file has changed since the run was planned.

    files: hashes as for `plan_with`
    """
    planned = json.loads(os.environ.get(PLANNED, "{}"))
    for path, sha256 in files.items():
        if planned.get(path, sha256) != sha256:
            raise ValueError(f"{path}: {EDITED}")
