"""Tables of numbers as files: a study writes them as CSV, and a page shows them in Markdown."""

import csv
import os
import platform
import re
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure
from PIL import Image

from snapmap.files import text
from snapmap.study.provenance import code_version

from .common import machine, results

FOOT = re.compile(
    r"# (snapmap .+), (Python .+), (\d+ s) of (.+): \./run (python -m studies (\w+).*)"
)
"""The last line of a file: code, Python, processor time, processor, command and study."""
WIDTH = 1200
"""Most pixels of a picture from left to right."""


class Table(NamedTuple):
    """A table by the name of its file, with the heads of its columns, and its cells as text."""

    name: str
    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def write(study: str, *tables: Table) -> None:
    """Write tables of a study to results/studies, with a foot that says what made them; print them.

    Call it once, at the end of the study, as the foot has the processor time so far.
    """
    command = " ".join(["./run python -m studies", study, *sys.argv[1:]])
    code, seconds = code_version().partition(" ")[0], sum(os.times()[:4])
    python = f"Python {platform.python_version()}"
    foot = f"# snapmap {code}, {python}, {seconds:.0f} s of {machine()}: {command}\n"
    for table in tables:
        path = results(f"studies/{table.name}.csv")
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows([table.head, *table.rows])
            file.write(foot)
        print(f"{table.name}\n\n{markdown(path)}")


def read(path: Path) -> tuple[list[list[str]], re.Match]:
    """Read a table: its head and rows, and its foot, whose groups are those of FOOT."""
    *lines, foot = path.read_text(encoding="utf-8").splitlines()
    return list(csv.reader(lines)), FOOT.fullmatch(foot)


def markdown(path: Path) -> str:
    """Write the table of a file in Markdown, with a short foot."""
    (head, *rows), foot = read(path)
    made = f"<sub>{foot[1]}, {foot[3]} of {foot[4]}: `{foot[5]}`</sub>"
    return f"{text.table(head, rows)}\n{made}\n"


def save_picture(name: str, figure: Figure) -> None:
    """Save the figure of a table in results/studies."""
    path = results(f"studies/{name}.png")
    figure.savefig(path, dpi=200)
    reduce_colours(path, path)


def reduce_colours(source: Path, target: Path) -> None:
    """Save a picture in 64 colours, at most WIDTH pixels wide: a third of its size."""
    with Image.open(source) as image:
        image.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
        few = image.convert("RGB").quantize(64, dither=Image.Dither.NONE)
    few.save(target, optimize=True)
