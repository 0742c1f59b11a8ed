"""The list of files that runs have made: by it others are made again, and older configs' leave.

Neither names nor times tell of which study and code a file is, which may have been copied here.
"""

import fcntl
import json
import os
import time
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from hashlib import blake2b
from pathlib import Path

from ..files.atomic import fingerprint, write_text

FOLDER, SLABS = "results", "results/slabs/"
"""The folder of results, and that of slabs, which stay, as a grid may grow again."""
LIST = "made.txt"
"""Name of the list in the folder: HEAD, then a line for each file. It has the path, the hash of
what the file was made from, and that of its content, between tabs."""
HEAD = "# What runs have made here: of this, and no more, goes what a config no longer asks for."
SHOWN = 4
"""Most files that a line names."""


def hash_of(*sources: object) -> str:
    """Hash what a file is made from: plain values, and hashes of other files."""
    text = json.dumps(sources, sort_keys=True, default=str)
    return blake2b(text.encode(), digest_size=6).hexdigest()


def begin_list() -> None:
    """Write the list with one line for each file; jobs append to it."""
    _write(_read())


def list_made(files: Iterable[str], made_from: str) -> None:
    """Append files that a job has made to the list, after which it tells what they are.

    made_from: hash of what they were made from
    """
    lines = [f"{name}\t{made_from}\t{fingerprint(name)}\n" for name in files]
    with suppress(OSError), open(Path(FOLDER, LIST), "a", encoding="utf-8") as file:
        with suppress(OSError):  # of a file system without locks
            fcntl.flock(file, fcntl.LOCK_EX)
        file.write("".join(lines))


def find_others(plan: Mapping[str, str]) -> list[str]:
    """Find the files of a plan that are there, but not as it would make them.

    plan: hash of what each is made from, by path
    """
    listed, there = _read(), filter(os.path.isfile, plan)
    return [name for name in there if listed.get(name) != (plan[name], fingerprint(name))]


def say_why(others: Collection[str]) -> str:
    """Say in one line that others than a study's files are to be made again, and why."""
    listed, why = _read(), "made for another config or by other code"
    if any(name not in listed for name in others):
        why = f"unknown to {FOLDER}/{LIST}"
    elif any(listed[name][1] != fingerprint(name) for name in others):
        why = "changed since"
    return f"{_names(others)}: to be made again, as not of this study and code ({why})"


def hold_to_list(files: Iterable[str]) -> None:
    """Raise ValueError, one line, if a file has changed since a run has made and listed it."""
    listed = _read()
    for name in files:
        if name in listed and listed[name][1] != fingerprint(name):
            raise ValueError(f"{name}: has changed since it was made; run again to make it anew")


def mend_times(sources: Mapping[str, Collection[str]]) -> None:
    """Set back the times of files that lie ahead, or after those of files made from them.

    A copy may have any times. sources: of each right file what it was made from, which comes before
    """
    latest = dict.fromkeys(sources, time.time_ns())
    for name in reversed(sources):
        with suppress(OSError):  # it may be another user's
            at = os.stat(name).st_mtime_ns
            latest[name] = min(at, latest[name])
            if at > latest[name]:
                os.utime(name, ns=(latest[name], latest[name]))
        for source in sources[name]:
            latest[source] = min(latest.get(source, latest[name]), latest[name])


def remove_others(kept: Collection[str]) -> list[str]:
    """Remove the files that the list names, but for those in `kept`.

    No other file is touched. Returns lines on files that were removed, or cannot be removed.
    """
    listed = _read()
    kept = {*kept, *(name for name in listed if name.startswith(SLABS))}
    others = [name for name in sorted(listed) if name not in kept and os.path.lexists(name)]
    for name in others:
        with suppress(OSError):
            Path(name).unlink()
    left = [name for name in others if os.path.lexists(name)]
    if listed.keys() - {*kept, *left}:
        _write({name: listed[name] for name in listed if name in {*kept, *left}})
    lines = {
        "removed, as the config no longer asks for them": sorted({*others} - {*left}),
        "from an older config, and cannot be removed": left,
    }
    return [f"{_names(files)}: {words}" for words, files in lines.items() if files]


def _read():
    try:
        text = Path(FOLDER, LIST).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    head, *lines = text.splitlines() or [""]
    listed = {name: (*hashes,) for name, *hashes in (line.split("\t") for line in lines)}
    listed = {name: hashes if len(hashes) == 2 else ("", "") for name, hashes in listed.items()}
    return {name: listed[name] for name in listed if head == HEAD and _is_below(name)}


def _write(listed):
    lines = ("\t".join([name, *listed[name]]).rstrip() for name in sorted(listed))
    with suppress(OSError):  # a file that a full disk keeps off the list is only made again
        Path(FOLDER).mkdir(exist_ok=True)
        write_text("\n".join([HEAD, *lines, ""]), Path(FOLDER, LIST))


def _is_below(name):
    """Tell whether a name is a file of the folder that no link within it leads out of."""
    path = Path(name)
    if not name.isprintable() or path.parts[:1] != (FOLDER,) or ".." in path.parts:
        return False
    real = Path(os.path.realpath(path.parent))
    return path != Path(FOLDER, LIST) and real.is_relative_to(os.path.realpath(FOLDER))


def _names(files):
    names = ", ".join(files[:SHOWN])
    return f"{names}, {len(files) - SHOWN} others" if len(files) > SHOWN else names
