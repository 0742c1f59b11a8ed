"""Draws docs/map.png: which shocks snap the handout's device, and speed against error.

./run python docs/make_picture.py

Speeds and errors are those of fast pulses in the table of docs/accuracy.md.
"""

import re
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from PIL import Image

import snapmap
from snapmap.config.study import load_config
from snapmap.config.yaml_file import read_document
from snapmap.figures import maps, scales, style

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "map.png"
C = 25.0
SHOWN = {
    "`auto`": ("snapmap", "C5"),
    "5 elements, the handout's": ("snapmap, the handout's elements", "C5"),
    "plain loop, 5 elements": ("the handout's plain loop", "0.4"),
    "SciPy DOP853, 1e-6": ("SciPy's DOP853", "0.4"),
}
"""Rows of the table, their words and colours."""


def main():
    with style.paper():
        figure = style.double_column(height=4)
        left, right = figure.subfigures(1, 2)
        maps.draw_map(left.subplots(), *snaps())
        draw_speeds(right.subplots())
        figure.savefig(PICTURE, dpi=200)
    with Image.open(PICTURE) as image:
        few = image.convert("RGB").quantize(64, dither=Image.Dither.NONE)
    few.save(PICTURE, optimize=True)  # a third of the size


def snaps():
    """The cells of config.yaml at one C, and the thresholds over them."""
    study = load_config(read_document(ROOT / "config" / "config.yaml"))
    asked = {"C": [C], "horizon": study.settings.horizon, "threads": 2}
    cells = snapmap.sweep(
        study.device, study.axes["N"], study.axes["f0"], model="auto", until="snap", **asked
    )
    fine = np.geomspace(*study.axes["f0"][[0, -1]], 121)
    found = snapmap.threshold(study.device, fine, **asked)
    return cells.squeeze("C"), found.squeeze("C")


def draw_speeds(ax: Axes) -> None:
    """Draw a point with its name for each row of the table: median error, and up to 90 %."""
    text = (ROOT / "docs" / "accuracy.md").read_text(encoding="utf-8")
    for row, (words, colour) in SHOWN.items():
        *_, errors, speed = re.search(rf"^\| {re.escape(row)} \|(.*)\|$", text, re.M)[1].split("|")
        median, most = (float(error) for error in errors.strip(" %").split("/"))
        speed = float(speed.replace(" ", ""))
        ax.plot(median, speed, "o", color=colour)
        ax.hlines(speed, median, most, color=colour)
        note = {"xytext": (0, -12), "textcoords": "offset points", "ha": "center"}
        ax.annotate(words, (median, speed), color=colour, **note)
    ax.set(xscale="log", yscale="log", xlim=(0.003, 0.3), ylim=(0.4, 4e5))
    ax.set(xlabel="error of the threshold (%): median, and up to 90 %")
    ax.set(ylabel="simulated shocks per second, one thread", title="Speed against error")
    for axis, ends in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
        scales.tick(axis, *ends)
    ax.text(0.03, 0.04, "better: up and to the left", transform=ax.transAxes, color="0.4")


if __name__ == "__main__":
    main()
