"""Error of every model: against the time of a simulation, over number and step; other sources.

The error is that of the threshold or, where no threshold is well posed, that of the labels.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from snapmap.figures import style
from snapmap.figures.scales import tick_values, value_text

LINES = {
    "elements_consistent": ("$n$ elements, consistent mass", "C5", "o", True, (4, 2)),
    "elements_hrz": ("$n$ elements, lumped mass (HRZ)", "C5", "o", False, (-4, -7)),
    "cosines": ("$n$ cosines, statically corrected", "C6", "D", True, (-7, 3)),
    "cosines_uncorrected": ("$n$ cosines, not corrected", "C6", "D", False, (4, 2)),
}
"""Label, colour, marker, whether it is filled, and where its number stands, in points."""
HANDOUT, HANDOUT_STEP = "5 elements, consistent", "step 0.8"
LEAST = 1e-6
"""Errors below this, the tolerance of the thresholds, are not drawn."""
JUDGED = {
    "threshold_worst": "largest relative error of the threshold",
    "label_error": "share of cells with another label",
}
"""Words for the errors by which models may be ranked."""
ORDERS = {"elements_consistent": -4, "cosines_uncorrected": -3}
"""Of Hermite elements, and of the flexibility that the cosines left out would have added."""
STEP_ORDER = 2
SLOPE = {"color": "0.5", "linewidth": 0.6, "linestyle": ":"}
OWN = {"color": "0.93", "linewidth": 0, "zorder": 0, "label": "below the converged run's own error"}
APART = 2.0
"""Above the points that they stand beside lie the lines of slope, as a factor."""


def draw_accuracy(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the error over the time per simulation, us."""
    ax.set(xscale="log", xlabel="time per simulation (µs)", ylabel=JUDGED[found.judged_by])
    ax.margins(x=0.08)
    _scale_errors(ax, found)
    front = found.isel(model=np.flatnonzero(found.on_front)).sortby("time_per_simulation")
    path = {"color": "0.8", "linewidth": 4, "solid_capstyle": "round", "zorder": 1}
    label = "Pareto front: none is faster and better"
    ax.step(front.time_per_simulation, _errors(front), where="post", label=label, **path)
    for family, (*_, offset) in LINES.items():
        cases = of_family(found, family)
        _draw_cases(ax, family, cases.time_per_simulation.values, _errors(cases))
        text = {"textcoords": "offset points", "color": LINES[family][1], "fontsize": 6}
        text["path_effects"] = [withStroke(linewidth=1.5, foreground="white")]
        points = zip(cases.time_per_simulation.values, _errors(cases), strict=True)
        for name, point in zip(cases.model.values.tolist(), points, strict=True):
            if np.isfinite(point).all():
                # A star where not all modes are kept.
                number = name.split()[0] + "*" * name.endswith(" modes")
                ax.annotate(number, point, offset, **text)
    case = found.sel(model=HANDOUT)
    ring = {"marker": "o", "markersize": 8, "fillstyle": "none", "color": "black", "linestyle": ""}
    ax.plot(case.time_per_simulation, _errors(case), label="the handout's setting", **ring)
    if sources := other_sources(found):
        low, high = ax.get_ylim()
        ax.set_ylim(min(low, *sources.values()) / 1.3, 1.3 * max(high / 1.3, *sources.values()))
        right = ax.secondary_yaxis("right")
        right.set_yticks(list(sources.values()), list(sources))
        right.set_yticks([], minor=True)
        right.set_ylabel("other sources, each alone")
    _draw_own_error(ax, found)
    style.legend(ax, ax.get_legend_handles_labels()[0], _caption(found), 3)
    return ax


def draw_convergence(axes: Sequence[Axes], found: xr.Dataset) -> Sequence[Axes]:
    """Draw the error over number and step on two axes."""
    number, step = axes
    for ax in axes:
        ax.set_xscale("log")
        _scale_errors(ax, found)
    for family in LINES:
        _draw_cases(number, family, *_over(of_family(found, family), 0))
    for family, order in ORDERS.items():
        _draw_slope(number, *_over(of_family(found, family), 0), order, found)
    steps = _over(of_family(found, "step"), 1)
    step.plot(*steps, color="C0", marker="s", label="time step, 5 elements")
    _draw_slope(step, *steps, STEP_ORDER, found)
    number.set(xlabel="number $n$ of elements or cosines", ylabel=JUDGED[found.judged_by])
    step.set_xlabel("time step over its stability limit")
    for ax in axes:
        ticks = np.unique([x for line in ax.lines for x in line.get_xdata()])
        tick_values(ax.xaxis, ticks, ticks)
    for ax in axes:
        _draw_own_error(ax, found)
    keys = [key for ax in axes for key in ax.get_legend_handles_labels()[0]]
    style.legend(number.figure, keys, ncols=3)
    return axes


def of_family(found: xr.Dataset, family: str) -> xr.Dataset:
    """The cases of one family."""
    names = found.family.attrs["flag_meanings"].split()
    return found.isel(model=np.flatnonzero(found.family == names.index(family)))


def other_sources(found: xr.Dataset) -> dict[str, float]:
    """Error of each penalty against hard contact, and of the handout's step, by label."""
    penalties = of_family(found, "penalty")
    sources = {
        f"contact {contact:g} N/m, not hard": error
        for contact, error in zip(penalties.contact.values, _errors(penalties), strict=True)
        if contact < np.inf
    }
    sources["time step, 0.8 of its limit"] = _errors(found.sel(model=HANDOUT_STEP)).item()
    return {label: float(worst) for label, worst in sources.items() if worst > LEAST}


def own_error(found: xr.Dataset) -> float:
    """Of the converged run: its largest, of well-posed thresholds, or that of its labels."""
    run = found.isel(reference=0)
    if found.judged_by == "label_error":
        return run.converged_label_error.item()
    own = run.converged_threshold_error / run.converged_threshold
    return own.where(run.threshold_decided).max().item()


def _errors(cases):
    """The errors by which cases are ranked."""
    return cases[cases.judged_by].values


def _over(cases, word):
    """Number or step, a word of the name, and error of the cases; of thresholds above LEAST."""
    x = np.array([float(name.split()[word]) for name in cases.model.values.tolist()])
    drawn = (_errors(cases) > LEAST) | (cases.judged_by == "label_error")
    return x[drawn], _errors(cases)[drawn]


def _draw_cases(ax, family, x, errors):
    label, colour, marker, filled, _ = LINES[family]
    look = {"color": colour, "marker": marker, "linestyle": "-" if filled else "--"}
    if x.size:
        ax.plot(x, errors, label=label, markerfacecolor=colour if filled else "white", **look)


def _draw_slope(ax, x, errors, order, found):
    """Draw a power of that order beside the points, from the largest error on."""
    if x.size < 2 or found.judged_by == "label_error":
        return
    worst = x[np.argmax(errors)]
    ax.plot(x, line := APART * errors.max() * (x / worst) ** float(order), **SLOPE)
    symbol, side, aside = ("n", "left", 4) if order < 0 else (r"\Delta t", "right", -4)
    place = {"textcoords": "offset points", "ha": side, "va": "bottom", "fontsize": 6}
    words = rf"$\propto {symbol}^{{{order}}}$"
    ax.annotate(words, (worst, line.max()), (aside, 1), color="0.35", **place)


def _scale_errors(ax, found):
    """Scale y for errors in percent: by ratio for thresholds; those of labels may be 0."""
    ax.set_yscale("log" if found.judged_by == "threshold_worst" else "linear")
    ax.yaxis.set_major_formatter(lambda error, _: f"{100 * error:.6g} %")


def _draw_own_error(ax, found):
    """Shade what the converged run does not know, and begin there; of labels at errors of 0."""
    own, (low, high) = own_error(found), ax.get_ylim()
    if own:
        ax.axhspan(0, own, **OWN)
    ax.set_ylim(min(low, own / 2 or low) if ax.get_yscale() == "log" else -0.05 * high, high)


def _caption(found):
    """Which errors are meant, what a star does, and what was cut down."""
    if found.judged_by == "threshold_worst":
        known = found.threshold_decided.isel(reference=0)
        f0 = ", ".join(f"{value:.4g}" for value in np.unique(found.f0))
        C = " or ".join(value_text("C", value) for value in np.unique(found.C))
        words = f"thresholds at $f_0$ = {f0} Hz, {C}; {int(known.sum())} of {known.size} well posed"
    else:
        snapped = found.share_snapped.values[0]
        words = f"labels of a map of which {snapped:.0%} snaps, as no threshold is well posed"
    starred = [name for name in found.model.values.tolist() if name.endswith(" modes")]
    words = "; *".join([words, *{name.split(", ")[-1] + " kept" for name in starred}])
    return "\n".join([words, *(f"only {line}" for line in [found.left_out] if line)])
