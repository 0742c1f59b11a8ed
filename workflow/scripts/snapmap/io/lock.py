"""One run at a time in a folder."""

import fcntl
import os
from pathlib import Path


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
