"""How the error falls with the number of elements or cosines, and the step.

The error is that of the threshold or, where no threshold is well posed, that of the labels.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from .accuracy import (
    JUDGED,
    LEAST,
    LINES,
    begin_at_zero,
    error_of,
    of_family,
    own_error,
    scale_error,
)

ORDERS = {"elements_consistent": -4, "cosines_uncorrected": -3}
"""Of Hermite elements, and of the flexibility that the cosines left out would have added."""
STEP_ORDER = 2
SLOPE = {"color": "0.5", "linewidth": 0.6, "linestyle": ":"}
OWN = {"color": "0.93", "linewidth": 0, "zorder": 0, "label": "below the converged run's own error"}
APART = 2.0
"""Above the points that they stand beside lie the lines of slope, as a factor."""


def draw_convergence(axes: Sequence[Axes], found: xr.Dataset) -> Sequence[Axes]:
    """Draw the error over number and step on two axes."""
    number, step = axes
    for ax in axes:
        ax.set_xscale("log")
        scale_error(ax, found)
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
    for ax in axes:
        begin_at_zero(ax, found)
    _label(axes, JUDGED[found.judged_by])
    return axes


def _draw_family(ax, cases, word, look):
    x, error = _points(cases, word)
    if x.size:
        ax.plot(x, error, **look)


def _points(cases, word):
    """Number or step, a word of the name, and error of the cases.

    Of thresholds only what errs by more than LEAST.
    """
    x = np.array([float(str(name).split()[word]) for name in cases.model.values])
    error = error_of(cases).values
    drawn = (error > LEAST) | (cases.judged_by == "label_error")
    return x[drawn], error[drawn]


def _draw_slope(ax, cases, word, order):
    """Draw a power of that order beside the points, from the largest error on."""
    x, error = _points(cases, word)
    if x.size < 2 or cases.judged_by == "label_error":
        return
    worst = x[np.argmax(error)]
    ax.plot(x, line := APART * error.max() * (x / worst) ** float(order), **SLOPE)
    symbol, side = ("n", "left") if order < 0 else (r"\Delta t", "right")
    words = rf"$\propto {symbol}^{{{order}}}$"
    place = {"xytext": (4 if side == "left" else -4, 1), "textcoords": "offset points", "ha": side}
    ax.annotate(words, (worst, line.max()), va="bottom", fontsize=6, color="0.35", **place)


def _draw_own_error(ax, found):
    if own := own_error(found):
        log = found.judged_by == "threshold_worst"
        low = min(ax.get_ylim()[0], own / 2) if log else 0.0
        ax.axhspan(low, own, **OWN)
        ax.set_ylim(bottom=low if log else None)


def _label(axes, of_error):
    number, step = axes
    number.set_xlabel("number $n$ of elements or cosines")
    step.set_xlabel("time step over its stability limit")
    number.set_ylabel(of_error)
    for ax in axes:
        ticks = sorted({x for line in ax.lines for x in line.get_xdata()})
        ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        ax.set_xticks([], minor=True)
        keys, _ = ax.get_legend_handles_labels()
        ax.legend(handles=keys, loc="lower left", bbox_to_anchor=(0, 1.03), ncols=2)
