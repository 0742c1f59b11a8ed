"""The list of files that runs have made, by which results of older configs are removed."""

import os
from collections.abc import Collection, Iterable
from contextlib import suppress
from pathlib import Path

from ..files.atomic import replacing

LIST = "made.txt"
"""Name of the list in the folder of results: HEAD, then a path in each line."""
HEAD = "# What runs have made here: of this, and no more, goes what a config no longer asks for."
SHOWN = 4
"""Most files that a line names."""


def list_made(folder: str, files: Iterable[str]) -> None:
    """Add files that a job has made below a folder to the folder's list."""
    _write(folder, {*_read(folder), *files})


def remove_others(folder: str, kept: Collection[str]) -> list[str]:
    """Remove the files that the list of a folder names, but for those in `kept`.

    No other file is touched. Returns lines on files that were removed, or cannot be removed.
    """
    listed = _read(folder)
    others = [name for name in sorted(listed) if name not in kept and os.path.lexists(name)]
    for name in others:
        with suppress(OSError):
            Path(name).unlink()
    left = [name for name in others if os.path.lexists(name)]
    if listed - {*kept, *left}:
        _write(folder, (listed & {*kept}).union(left))
    lines = {
        "removed, as the config no longer asks for them": sorted({*others} - {*left}),
        "from an older config, and cannot be removed": left,
    }
    return [f"{_names(files)}: {words}" for words, files in lines.items() if files]


def _read(folder):
    try:
        text = Path(folder, LIST).read_text(encoding="utf-8", errors="replace")
    except OSError:
        return set()
    head, *names = text.splitlines() or [""]
    return {name for name in names if head == HEAD and _is_below(folder, name)}


def _write(folder, names):
    # A file that a full disk keeps off the list only stays longer.
    with suppress(OSError), replacing(Path(folder, LIST)) as temporary:
        text = "\n".join([HEAD, *sorted(names), ""])
        Path(temporary).write_text(text, encoding="utf-8")


def _is_below(folder, name):
    """Tell whether a name is a file of the folder that no link within it leads out of."""
    path = Path(name)
    if not name.isprintable() or path.parts[:1] != (folder,) or ".." in path.parts:
        return False
    real = Path(os.path.realpath(path.parent))
    return path != Path(folder, LIST) and real.is_relative_to(os.path.realpath(folder))


def _names(files):
    names = ", ".join(files[:SHOWN])
    return f"{names}, {len(files) - SHOWN} others" if len(files) > SHOWN else names
