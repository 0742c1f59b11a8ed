"""Makes docs/pictures: the map of the first page beside speed against error, laws, some figures.

./run python docs/make_pictures.py build/tutorial/results/figures

The figures are those of a run of config/sensor.yaml, in few colours.  Speeds and errors are those
of docs/tables/peers_map.csv.
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

import snapmap
from snapmap.applications.whole import load_config
from snapmap.config.yaml_file import read_document
from snapmap.figures import maps, scales, style
from snapmap.solver.laws import load_laws

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from studies.tables import read, reduce_colours  # noqa: E402, as only the clone has the studies

PICTURES = ROOT / "docs" / "pictures"
GALLERY = "snap_maps", "thresholds", "requirements", "probability"
C = 25.0
SHOWN = {
    "snapmap": ("snapmap", "C5", "o", (-8, 9)),
    "snapmap, no proofs": ("without proofs", "C5", ".", (-26, -14)),
    "numba loop": ("numba loop", "C1", "s", (5, -9)),
    "heyoka": ("heyoka", "C0", "D", (-9, 8)),
    "handout's plain loop": ("handout's plain loop", "0.4", "v", (0, 8)),
    "diffrax": ("diffrax", "0.4", "P", (-9, 8)),
    "SciPy": ("SciPy", "0.4", "X", (-9, 8)),
}
"""Solvers of the table, their words, colours, markers, and places of the words from the fastest."""
RESOLVED = 1e-4
"""Error, %, below which the study resolves none."""
LAWS = {
    "squeeze_film": (2500.0, 200.0),
    "hertzian_contact": (1500.0, 25.0),
    "fixed_mass": (1500.0, 25.0),
    "double_well": (700.0, 25.0),
}
"""Examples of a user's own laws, with N and C (uN us/um) of a shock of 1.5 kHz."""


def main(figures):
    with style.paper():
        figure = style.double_column(height=4)
        left, right = figure.subfigures(1, 2)
        maps.draw_map(left.subplots(), *snaps())
        draw_speeds(right.subplots())
        figure.savefig(PICTURES / "map.png", dpi=200)
        figure = style.double_column(height=3.2)
        for ax, (law, cell) in zip(figure.subplots(1, 4, sharey=True), LAWS.items(), strict=True):
            draw_law(ax, law, *cell)
        style.legend(figure, style.labelled(figure.axes[:1]), ncols=2)
        figure.savefig(PICTURES / "laws.png", dpi=200)
    for name in ("map", "laws"):
        reduce_colours(PICTURES / f"{name}.png", PICTURES / f"{name}.png")
    for name in GALLERY:
        reduce_colours(Path(figures) / f"{name}.png", PICTURES / f"{name}.png")


def snaps():
    """The cells of config.yaml at one C, and the thresholds over them."""
    study = load_config(read_document(ROOT / "config" / "config.yaml"))
    asked = snapmap.Study(study.device, **vars(study.run.but(threads=2)))
    cells = snapmap.sweep(asked, study.axes["N"], study.axes["f0"], [C])
    fine = np.geomspace(*study.axes["f0"][[0, -1]], 121)
    edges = snapmap.threshold(asked, fine, [C])
    return cells.squeeze("C"), edges.squeeze("C")


def draw_law(ax: Axes, law: str, N: float, C: float) -> None:
    """Draw the midpoint over time, with an example of a law and without."""
    device = snapmap.load_device(ROOT / "config" / "config.yaml")
    path = ROOT / "examples" / "laws" / f"{law}.py"
    lawful = load_laws(str(path))
    for model, colour, words in (("reference", "0.6", "without"), (lawful, "C5", "with the law")):
        run = snapmap.simulate(snapmap.Study(device, model, horizon=0), N, 1500.0, C)
        ax.plot(run.time, run.w_mid, color=colour, label=words)
    ax.set(title=f"{law.replace('_', ' ')}, N = {N:g}", xlabel="time (µs)", xlim=(0, 667))
    ax.set_ylabel("midpoint (µm)")
    ax.label_outer()


def draw_speeds(ax: Axes) -> None:
    """Draw speed over median errors, with bars to the largest, of the solvers of `peers`."""
    (_, *rows), _ = read(ROOT / "docs" / "tables" / "peers_map.csv")
    for solver, (words, colour, marker, place) in SHOWN.items():
        found = [row for row in rows if row[0] == solver]
        alike = [row[3:6] for row in found if row[2] == found[0][2]]
        speed, *errors = np.array(alike, float).T
        median, largest = np.maximum(100 * np.array(errors), RESOLVED)
        ax.plot(median, speed, color=colour, marker=marker)
        ax.hlines(speed, median, largest, color=colour, alpha=0.3)
        near = {"xy": (median[0], speed[0]), "xytext": place, "textcoords": "offset points"}
        ax.annotate(words, **near, color=colour, va="center")
    ax.set(xscale="log", yscale="log", xlim=(0.6 * RESOLVED, 0.2), ylim=(1, 4e5))
    ax.set(xlabel="error of the threshold (%): median, and up to the largest")
    ax.set(ylabel="simulated shocks per second, one thread", title="Speed against error")
    for axis, ends in ((ax.xaxis, ax.get_xlim()), (ax.yaxis, ax.get_ylim())):
        scales.tick(axis, *ends)
    ax.text(0.97, 0.04, "better: up and to the left", transform=ax.transAxes, ha="right")


if __name__ == "__main__":
    main(sys.argv[1])
