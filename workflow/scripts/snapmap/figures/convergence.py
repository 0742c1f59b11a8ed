"""How the error of the threshold falls with the number of elements or cosines, and the step."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from .accuracy import LEAST, LINES, of_family

ORDERS = {"elements_consistent": -4, "cosines_uncorrected": -3}
"""Of Hermite elements, and of the flexibility that the cosines left out would have added."""
STEP_ORDER = 2
SLOPE = {"color": "0.5", "linewidth": 0.6, "linestyle": ":"}
OWN = {"color": "0.93", "linewidth": 0, "zorder": 0, "label": "below the converged run's own error"}
APART = 2.0
"""Above the points that they stand beside lie the lines of slope, as a factor."""


def draw_convergence(axes: Sequence[Axes], found: xr.Dataset) -> Sequence[Axes]:
    """Draw the largest relative error of the threshold over number and step on two axes."""
    number, step = axes
    for ax in axes:
        ax.set(xscale="log", yscale="log")
    for family, (label, colour, marker, filled, _) in LINES.items():
        look = {"label": label, "color": colour, "marker": marker}
        look |= {"linestyle": "-"} if filled else {"linestyle": "--", "markerfacecolor": "white"}
        _draw_family(number, of_family(found, family), 0, look)
    for family, order in ORDERS.items():
        _draw_slope(number, of_family(found, family), 0, order)
    look = {"label": "time step, 5 elements", "color": "C0", "marker": "s"}
    _draw_family(step, of_family(found, "step"), 1, look)
    _draw_slope(step, of_family(found, "step"), 1, STEP_ORDER)
    _draw_own_error(number, found)
    _label(axes)
    return axes


def _draw_family(ax, cases, word, look):
    x, error = _points(cases, word)
    if x.size:
        ax.plot(x, error, **look)


def _points(cases, word):
    """Number or step, a word of the name, and error of the cases that err by more than LEAST."""
    x = np.array([float(str(name).split()[word]) for name in cases.model.values])
    error = cases.threshold_worst.values
    drawn = error > LEAST
    return x[drawn], error[drawn]


def _draw_slope(ax, cases, word, order):
    """Draw a power of that order beside the points, from the largest error on."""
    x, error = _points(cases, word)
    if x.size < 2:
        return
    worst = x[np.argmax(error)]
    ax.plot(x, line := APART * error.max() * (x / worst) ** float(order), **SLOPE)
    symbol, side = ("n", "left") if order < 0 else (r"\Delta t", "right")
    words = rf"$\propto {symbol}^{{{order}}}$"
    place = {"xytext": (4 if side == "left" else -4, 1), "textcoords": "offset points", "ha": side}
    ax.annotate(words, (worst, line.max()), va="bottom", fontsize=6, color="0.35", **place)


def _draw_own_error(ax, found):
    """Shade what lies below the own error of the converged thresholds."""
    run = found.isel(reference=0)
    own = (run.converged_threshold_error / run.converged_threshold).where(run.threshold_decided)
    if own.notnull().any():
        low = min(ax.get_ylim()[0], own.max().item() / 2)
        ax.axhspan(low, own.max().item(), **OWN)
        ax.set_ylim(bottom=low)


def _label(axes):
    number, step = axes
    number.set_xlabel("number $n$ of elements or cosines")
    step.set_xlabel("time step over its stability limit")
    number.set_ylabel("largest relative error of the threshold")
    for ax in axes:
        ticks = sorted({x for line in ax.lines for x in line.get_xdata()})
        ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        ax.set_xticks([], minor=True)
        ax.yaxis.set_major_formatter(lambda error, _: f"{100 * error:.6g} %")
        keys, _ = ax.get_legend_handles_labels()
        ax.legend(handles=keys, loc="lower left", bbox_to_anchor=(0, 1.03), ncols=2)
