"""The error of a threshold over the step, elements and cosines, for docs/accuracy.md.

./run python -m studies convergence [--small]

Thresholds in several steps are compared with that in the finest step, those of elements and of
cosines with that of many cosines. Also draws the picture of the page.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes

from snapmap import threshold
from snapmap.device.device import Device
from snapmap.figures import style
from snapmap.solver.cells import to_rows
from snapmap.solver.models import build_model
from snapmap.solver.options import Cosines, Elements
from snapmap.solver.settings import Run
from snapmap.thresholds.probe import Probe, lowest_snap

from .common import command_device, few, number
from .tables import Table, save_picture, write

ROWS = {"clean": (1500.0, 25.0), "ragged": (5800.0, 0.025)}
"""Rows of the handout's device: f0, Hz, and C, uN us/um."""
FINE = 0.125
BEST = Cosines(modes=31), FINE
"""Model and step, over the default one, with which elements and cosines are compared."""
STEP = "step, over the default"
FAMILIES = {
    STEP: {2.0**k: (Cosines(modes=5), 2.0**k) for k in range(2, -6, -1)},
    "elements": {n: (Elements(elements=n), FINE) for n in (2, 3, 4, 5, 6, 7, 9, 11)},
    "cosines": {n: (Cosines(modes=n), FINE) for n in (3, 5, 7, 9, 11, 13, 17, 21)},
}
"""Models and their steps over the default ones, by what refines them."""
REFERENCES = {STEP: (Cosines(modes=5), 2.0**-6), "elements": BEST, "cosines": BEST}
ORDERS = {STEP: 2, "elements": -4, "cosines": -3}
NEAR, SCAN, TOLERANCE = 0.12, 5e-4, 1e-9
"""Relative distance from a first threshold within which all are sought, in which steps, how
closely."""
HALVED = Cosines(modes=11), 0.5
SOURCES = {
    "contact of 40 N/m": ({"contact": 40.0}, HALVED),
    "contact of 4000 N/m": ({"contact": 4000.0}, HALVED),
    "5 elements": ({}, (Elements(), 0.5)),
    "10 elements": ({}, (Elements(elements=10), 0.5)),
    "3 cosines": ({}, (Cosines(modes=3), 0.5)),
    "5 cosines": ({}, (Cosines(modes=5), 0.5)),
    "11 cosines": ({}, HALVED),
    "11 cosines, default steps": ({}, (Cosines(modes=11), 1.0)),
}
"""Changes of the device, and models with their steps, whose thresholds are compared."""
F0, C = (458.0, 1732.0, 6555.0), (25.0, 200.0)
HEAD = ["row", "family", "value", "N", "error"]


def main():
    device = command_device()
    errors = {
        (name, family): errors_of(device, row, few(models, 3), REFERENCES[family])
        for name, row in few(ROWS, 2).items()
        for family, models in few(FAMILIES, 1).items()
    }
    rows = [
        [name, family, f"{value:g}", f"{N:.10g}", number(error)]
        for (name, family), points in errors.items()
        for value, N, error in points
    ]
    with style.paper():
        figure = style.double_column(height=3.2)
        for ax, family in zip(figure.subplots(1, 3, sharey=True), FAMILIES, strict=True):
            draw(ax, family, {name: errors.get((name, family), []) for name in ROWS})
        style.legend(figure, style.labelled(figure.axes[:1]), ncols=3)
        save_picture("convergence", figure)
    head = ["source", "least, %", "largest, %"]
    sources = Table("convergence_sources", head, [*sources_of(device)])
    write("convergence", Table("convergence", HEAD, rows), sources)


def errors_of(device: Device, row: tuple, models: dict, reference: tuple) -> list[tuple]:
    """Find value, threshold, and its relative error of each model of a family, in a row."""
    about = threshold(device, [row[0]], [row[1]]).N_first.item()
    *found, best = (seek(device, [row], run, about).item() for run in (*models.values(), reference))
    return [(key, N, abs(N / best - 1)) for key, N in zip(models, found, strict=True)]


def seek(device: Device, rows: Sequence[tuple], run: tuple, about: np.ndarray) -> np.ndarray:
    """Find the lowest N that snaps near others, (rows,).

    run: model, and its step over the default one; about: where to seek, (rows,) or one number
    """
    f0, damping = np.transpose(rows)
    model = build_model(device, run[0]).with_step(run[1])
    probe = Probe(model, to_rows(0, f0, damping), Run())
    return lowest_snap(probe, (about * (1 - NEAR), about * (1 + NEAR)), TOLERANCE, SCAN)


def sources_of(device: Device):
    """Yield the least and the largest difference of thresholds, for each source."""
    rows = [(f0, damping) for damping in few(C) for f0 in few(F0)]
    about = threshold(device, few(F0), few(C)).N_first.values.ravel()

    def find(change, run):
        return seek(replace(device, **change), rows, run, about)

    hard, best = find({"contact": np.inf}, HALVED), find({}, BEST)
    for name, source in few(SOURCES, 3).items():
        off = 100 * abs(find(*source) / (hard if "contact" in name else best) - 1)
        yield [name, number(off.min()), number(off.max())]


def draw(ax: Axes, family: str, points: dict) -> None:
    """Draw the errors of both thresholds over what refines them, and a line of the order."""
    for (name, of_row), marker in zip(points.items(), "os", strict=True):
        value, _, error = np.reshape(of_row, (-1, 3)).T
        ax.plot(value, error, marker=marker, label=f"{name} threshold")
        if name == "clean" and value.size:
            order = ORDERS[family]
            line = error[-1] * (value / value[-1]) ** order
            ax.plot(value, line, color="0.5", linestyle="--", label="the order")
            ax.set_title(f"order {abs(order)}")
    ax.set(xscale="log", yscale="log", xlabel=family, ylabel="relative error of N")
    ax.label_outer()
