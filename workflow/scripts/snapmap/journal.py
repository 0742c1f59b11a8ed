"""The log of a rule's script."""

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from pathlib import Path


@contextmanager
def journal(path: str | Path) -> Iterator[None]:
    """Keep what a script prints in its log as well; what it complains of goes there alone.

    Snakemake shows the log of a job that fails. A fault that the user can mend (ValueError,
    OSError, MemoryError) is one line there, any other a traceback.
    """
    with (
        open(path, "w", buffering=1, encoding="utf-8") as log,
        redirect_stdout(_Both(sys.stdout, log)),
        redirect_stderr(log),
    ):
        try:
            yield
        except (MemoryError, OSError, ValueError) as fault:
            print(str(fault) or type(fault).__name__, file=log)
            sys.exit(1)
        except Exception:
            traceback.print_exc()
            sys.exit(1)


class _Both:
    """A text stream that writes to two."""

    def __init__(self, *streams):
        self.streams = streams

    def write(self, text):
        for stream in self.streams:
            stream.write(text)

    def flush(self):
        for stream in self.streams:
            stream.flush()
