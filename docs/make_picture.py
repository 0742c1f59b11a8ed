"""Draws docs/map.png: which shocks snap the handout's device, and speed against error.

./run python docs/make_picture.py results/accuracy.csv

accuracy.csv: of `./run python -m studies accuracy`
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

import snapmap
from snapmap.config.study import load_config
from snapmap.config.yaml_file import read_document
from snapmap.figures import maps, style
from studies.accuracy import draw_speed  # the command runs in the folder of the clone

ROOT = Path(__file__).resolve().parents[1]
C = 25.0


def main():
    points = pd.read_csv(sys.argv[1])
    with style.paper():
        figure = style.double_column(height=4)
        left, right = figure.subfigures(1, 2)
        maps.draw_map(left.subplots(), *snaps())
        ax = right.subplots()
        draw_speed(ax, points[points.pulses == "fast"])
        ax.set_title("Speed against error, fast pulses")
        style.legend(ax, ax.get_legend_handles_labels()[0], ncols=3)
        figure.savefig(ROOT / "docs" / "map.png", dpi=200)


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


if __name__ == "__main__":
    main()
