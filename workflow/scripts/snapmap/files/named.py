"""Files that a config names: plain ones of a bounded size, read whole, as they were planned."""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

PLANNED = "SNAPMAP_PLANNED"
"""The variable of the environment by which jobs inherit the hashes of files."""
EDITED = "was edited after the run was planned; run again"


@contextmanager
def naming(path: str | Path) -> Iterator[None]:
    """Make what goes wrong with a file a ValueError of one line that names it."""
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
    """Read a file; raises OSError, or ValueError without its name, for one that cannot be.

    most: bytes; remedy: what to do about more, such as "write at most 100 rows"
    sha256: of the content that the run was planned with, hex digits; empty for any
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
    """Hash what a file holds, as `read_named` reads it; raises ValueError, one line."""
    with naming(path):
        return hashlib.sha256(read_named(path, most, remedy)).hexdigest()


def hold_to_plan(files: Mapping[str, str], plans: bool) -> None:
    """Raise ValueError, one line, for a file that the run was planned with other content of.

    files: SHA-256 by path
    plans: whether this process plans the run, whose hashes its jobs then inherit
    """
    if plans:
        os.environ[PLANNED] = json.dumps(files)
    planned = json.loads(os.environ.get(PLANNED, "{}"))
    for path, sha256 in files.items():
        if planned.get(path, sha256) != sha256:
            raise ValueError(f"{path}: {EDITED}")
