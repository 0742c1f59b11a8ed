"""Makes docs/pictures: the first page's sensor and map, and its badges; speeds, laws, some figures.

./run python docs/make_pictures.py build/tutorial/results/figures

The figures are those of a run of config/sensor.yaml, in few colours.  Speeds and errors are those
of docs/tables/peers_map.csv.
"""

import sys
import tomllib
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

import snapmap
from snapmap.applications.whole import load_config
from snapmap.config.yaml_file import read_document
from snapmap.figures import scales, style
from snapmap.solver.laws import load_laws

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
from studies.tables import read, reduce_colours  # noqa: E402, as only the clone has the studies

PICTURES = ROOT / "docs" / "pictures"
GALLERY = "snap_maps", "thresholds", "requirements", "probability"
C = 25.0
SHOWN = {
    "snapmap": ("snapmap", "C5", "o", (-8, 9)),
    "snapmap, to the end": ("runs to the end", "C5", ".", (-8, -15)),
    "numba loop": ("numba loop", "C1", "s", (-78, 8)),
    "heyoka": ("heyoka", "C0", "D", (-9, -28)),
    "plain loop": ("plain loop", "0.4", "v", (0, 8)),
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


BADGE = """\
<svg xmlns="http://www.w3.org/2000/svg" width="{all}" height="20" role="img">
<title>{what}: {is_}</title>
<rect width="{all}" height="20" fill="#555"/>
<rect x="{left}" width="{right}" height="20" fill="#2a6f97"/>
<g fill="#fff" font-family="Verdana,sans-serif" font-size="11" text-anchor="middle">
<text x="{half}" y="14">{what}</text><text x="{other}" y="14">{is_}</text></g></svg>
"""


def main(figures):
    draw_badges(PICTURES)
    with style.paper():
        figure = style.double_column(height=2.9)
        left, right = figure.subplots(1, 2, width_ratios=(2, 3))
        draw_sensor(left)
        draw_shocks(right, *snaps())
        figure.savefig(PICTURES / "map.png", dpi=200)
        figure = style.single_column(height=4)
        draw_speeds(figure.subplots())
        figure.savefig(PICTURES / "speed.png", dpi=200)
        figure = style.double_column(height=3.2)
        for ax, (law, cell) in zip(figure.subplots(1, 4, sharey=True), LAWS.items(), strict=True):
            draw_law(ax, law, *cell)
        style.legend(figure, style.labelled(figure.axes[:1]), ncols=2)
        figure.savefig(PICTURES / "laws.png", dpi=200)
    for name in ("map", "speed", "laws"):
        reduce_colours(PICTURES / f"{name}.png", PICTURES / f"{name}.png")
    for name in GALLERY:
        reduce_colours(Path(figures) / f"{name}.png", PICTURES / f"{name}.png")


def draw_badges(folder: Path) -> None:
    """Write what pyproject.toml says of Python and licence as small pictures."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    versions = [words.rpartition(" ")[2] for words in project["classifiers"] if ":: 3." in words]
    says = {"python": f"{versions[0]} to {versions[-1]}", "licence": project["license"]}
    for what, is_ in says.items():
        left, right = 7 * len(what) + 10, 7 * len(is_) + 10
        sizes = {"all": left + right, "left": left, "right": right}
        sizes |= {"half": left // 2, "other": left + right // 2}
        text = BADGE.format(what=what, is_=is_, **sizes)
        (folder / f"{what}.svg").write_text(text, encoding="utf-8")


def draw_sensor(ax: Axes) -> None:
    """Draw the beam in both shapes, and the mass on its spring."""
    x = np.linspace(0, 1, 101)
    shape = 0.5 * (1 - np.cos(2 * np.pi * x))
    ax.plot(x, shape, color="C5", linewidth=3)
    ax.plot(x, -0.94 * shape, color="C5", linewidth=2, linestyle="--")
    for end in (-0.08, 1.0):
        ax.fill_between([end, end + 0.08], -0.45, 0.45, color="0.7")
    ax.fill_between([0.32, 0.68], 1.05, 1.65, color="0.35")
    turns = np.linspace(1.65, 2.35, 9)
    ax.plot(0.5 + 0.04 * np.array([0, 0, 1, -1, 1, -1, 1, 0, 0]), turns, color="0.35")
    ax.fill_between([0.2, 0.8], 2.35, 2.5, color="0.7")
    ax.text(0.5, 1.33, "mass", color="white", ha="center", va="center")
    ax.text(0.5, 0.6, "curved beam", ha="center")
    ax.text(0.5, -1.2, "its second shape", ha="center")
    arrow = {"arrowstyle": "-|>", "color": "C1", "linewidth": 2}
    ax.annotate("", (0.9, 0.95), (0.9, 1.75), arrowprops=arrow)
    ax.text(0.9, 1.85, "shock", ha="center")
    ax.set(xlim=(-0.1, 1.1), ylim=(-1.25, 2.6), title="A shock drives the mass onto the beam.")
    ax.set_axis_off()


def draw_shocks(ax: Axes, cells: xr.Dataset, edges: xr.Dataset) -> None:
    """Draw which shocks snap the beam, over duration and peak, and the threshold."""
    snapped = cells.t_snap.notnull().transpose("N", "f0")
    lasts = 1e3 / cells.f0
    ax.contourf(lasts, cells.N, snapped, levels=(-1, 0.5, 2), colors=("#d3dde6", "#6fac9c"))
    ax.plot(1e3 / edges.f0, edges.N_first, color="black")
    ax.set(xscale="log", xlim=(lasts.max(), lasts.min()), ylim=(600, 2400))
    scales.tick(ax.xaxis, lasts.min(), lasts.max())
    ax.text(2, 1700, "The beam snaps.", ha="center")
    ax.text(2, 750, "The beam does not snap.", ha="center")
    one = edges.sel(f0=1e3, method="nearest")
    at, words = (1e3 / one.f0, one.N_first), f"threshold at 1 ms: {one.N_first:.0f} g"
    arrow = {"arrowstyle": "-", "color": "black"}
    ax.annotate(words, at, (0.8, 1250), ha="center", arrowprops=arrow)
    ax.set(xlabel="duration of the shock (ms)", ylabel="peak of the shock (g)")
    ax.set_title("Which shocks snap it?")


def snaps():
    """The cells of config.yaml at one C, and the thresholds over them."""
    study = load_config(read_document(ROOT / "config" / "config.yaml"))
    asked = snapmap.Study(study.device, **vars(study.run.but(threads=2)))
    cells = snapmap.sweep(asked, study.axes["N"], study.axes["f0"], [C])
    fine = np.sort([*np.geomspace(*study.axes["f0"][[0, -1]], 121), 1e3])
    edges = snapmap.threshold(asked, fine, [C])
    return cells.squeeze("C"), edges.squeeze("C")


def draw_law(ax: Axes, law: str, N: float, C: float) -> None:
    """Draw the midpoint over time, with an example of a law and without."""
    device = snapmap.load_device(ROOT / "config" / "config.yaml")
    path = ROOT / "examples" / "laws" / f"{law}.py"
    plain, lawful = snapmap.Cosines(), snapmap.Cosines(laws=load_laws(str(path)))
    for model, colour, words in ((plain, "0.6", "without"), (lawful, "C5", "with the law")):
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
