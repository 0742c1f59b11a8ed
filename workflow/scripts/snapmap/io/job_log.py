"""The log of a rule's script."""

import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout, suppress
from pathlib import Path


@contextmanager
def job_log(path: str | Path) -> Iterator[None]:
    """Keep what a script prints in its log, and its warnings there and on the terminal.

    Snakemake shows the log of a job that fails. A fault that the user can mend (ValueError,
    OSError, MemoryError) is one line there, and so is Ctrl-C; any other a traceback.
    """
    complaint = ""
    log = open(path, "w", buffering=1, encoding="utf-8")  # noqa: SIM115, closing may fail, too
    terminal = sys.stderr

    def warn(message, *_, **__):
        for stream in (log, terminal):
            print(message, file=stream)

    with redirect_stdout(log), redirect_stderr(log), warnings.catch_warnings():
        warnings.showwarning = warn
        try:
            yield
        except (MemoryError, OSError, ValueError) as fault:
            complaint = str(fault) or type(fault).__name__
        except KeyboardInterrupt:
            complaint = "interrupted; what is whole is kept, and the same command goes on"
        except Exception:
            complaint = traceback.format_exc()
    if complaint:
        _complain(complaint, log)
    with suppress(OSError):
        log.close()
    if complaint:
        sys.exit(1)


def _complain(complaint, log):
    """Write to the log or, where the disk is full, to the terminal."""
    try:
        print(complaint, file=log, flush=True)
    except OSError:
        print(complaint, file=sys.stderr)
