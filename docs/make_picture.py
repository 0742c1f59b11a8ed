"""Draws docs/map.png: which shocks snap the handout's device, and speed against error.

PYTHONPATH=workflow/scripts ./run python docs/make_picture.py [accuracy.nc [earlier.nc]]

accuracy.nc: of `./run snakemake accuracy --cores 2`; earlier.nc: of another version, for its front
"""

import sys
from pathlib import Path

import numpy as np
import xarray as xr

import snapmap
from snapmap.config.study import load_config
from snapmap.config.yaml_file import read_document
from snapmap.figures import maps, style
from studies.accuracy.figures import HANDOUT, of_family

ROOT = Path(__file__).parents[1]
C = 25.0


def main():
    measured = [xr.load_dataset(path) for path in sys.argv[1:] or ["results/accuracy.nc"]]
    with style.paper():
        figure = style.double_column(height=4)
        left, right = figure.subfigures(1, 2)
        maps.draw_map(left.subplots(), *snaps())
        draw_fronts(right.subplots(), *measured)
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


def draw_fronts(ax, found, earlier=None):
    """Largest error of a threshold over the time of a simulation, and what no case beats."""
    ax.set(xscale="log", yscale="log")
    ax.set(xlabel="time per simulation (µs)", ylabel="largest error of the threshold")
    ax.yaxis.set_major_formatter(lambda error, _: f"{100 * error:g} %")
    for one, label, look in (
        (found, "this version", {"color": "0.3"}),
        (earlier, "before steps followed the question", {"color": "0.7", "linestyle": "--"}),
    ):
        if one is not None:
            front = one.isel(model=np.flatnonzero(one.on_front)).sortby("time_per_simulation")
            ax.step(
                front.time_per_simulation, front.threshold_worst, where="post", label=label, **look
            )
    for family, words, marker in (
        ("cosines", "$n$ cosines", "D"),
        ("elements_consistent", "$n$ elements", "o"),
    ):
        cases = of_family(found, family)
        ax.plot(cases.time_per_simulation, cases.threshold_worst, marker, markersize=4, label=words)
        for name, x, y in zip(
            cases.model.values, cases.time_per_simulation, cases.threshold_worst, strict=True
        ):
            number = str(name).split()[0]
            ax.annotate(number, (x, y), (3, 3), textcoords="offset points", fontsize=6)
    case = found.sel(model=HANDOUT)
    ring = {"markersize": 9, "fillstyle": "none", "color": "black"}
    ring["label"] = "the handout's setting"
    ax.plot(case.time_per_simulation, case.threshold_worst, "o", **ring)
    ax.set_title("Speed against error\none thread, against a converged run")
    style.legend(ax, ax.get_legend_handles_labels()[0], ncols=2)


if __name__ == "__main__":
    main()
