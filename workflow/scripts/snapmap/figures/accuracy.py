"""Error of the threshold against time per simulation, for every model; other sources beside it."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from .scales import value_text

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


def draw_accuracy(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the largest relative error of the threshold over the time per simulation, us."""
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.margins(x=0.08)
    _draw_front(ax, found)
    for family, style in LINES.items():
        _draw_family(ax, of_family(found, family), *style)
    _draw_handout(ax, found)
    sources = other_sources(found)
    _draw_sources(ax, sources)
    _draw_own_error(ax, found)
    ax.set_xlabel("time per simulation (µs)")
    ax.set_ylabel("largest relative error of the threshold")
    ax.yaxis.set_major_formatter(lambda error, _: f"{100 * error:.6g} %")
    place = {"loc": "lower left", "bbox_to_anchor": (0, 1.03), "ncols": 3}
    ax.legend(title=_caption(found), alignment="left", **place)
    return ax


def of_family(found: xr.Dataset, family: str) -> xr.Dataset:
    """The cases of one family."""
    names = found.family.attrs["flag_meanings"].split()
    return found.isel(model=np.flatnonzero(found.family == names.index(family)))


def other_sources(found: xr.Dataset) -> dict[str, float]:
    """Error of each penalty against hard contact, and of the handout's step, by label."""
    penalties = of_family(found, "penalty")
    cases = zip(penalties.contact.values, penalties.threshold_worst.values, strict=True)
    soft = [(contact, worst) for contact, worst in cases if contact < np.inf]
    sources = {f"contact {contact:g} N/m, not hard": worst for contact, worst in soft}
    step = found.threshold_worst.sel(model=HANDOUT_STEP).item()
    sources["time step, 0.8 of its limit"] = step
    return {label: float(worst) for label, worst in sources.items() if worst > LEAST}


def _draw_front(ax, found):
    front = found.isel(model=np.flatnonzero(found.on_front)).sortby("time_per_simulation")
    path = {"color": "0.8", "linewidth": 4, "solid_capstyle": "round", "zorder": 1}
    label = "Pareto front: none is faster and better"
    ax.step(front.time_per_simulation, front.threshold_worst, where="post", label=label, **path)


def _draw_family(ax, cases, label, colour, marker, filled, offset):
    if cases.sizes["model"] == 0:
        return
    look = {"color": colour, "marker": marker, "linestyle": "-" if filled else "--"}
    look["markerfacecolor"] = colour if filled else "white"
    ax.plot(cases.time_per_simulation, cases.threshold_worst, label=label, **look)
    text = {"textcoords": "offset points", "xytext": offset, "color": colour, "fontsize": 6}
    text["path_effects"] = [withStroke(linewidth=1.5, foreground="white")]
    points = zip(cases.time_per_simulation.values, cases.threshold_worst.values, strict=True)
    for name, point in zip(cases.model.values, points, strict=True):
        if np.isfinite(point).all():
            ax.annotate(_number(str(name)), point, **text)


def _number(name):
    """20* of `20 elements, hrz, 19 modes`: a star where not all modes are kept."""
    return name.split()[0] + "*" * name.endswith(" modes")


def _draw_handout(ax, found):
    case = found.sel(model=HANDOUT)
    ring = {"marker": "o", "markersize": 8, "fillstyle": "none", "color": "black"}
    label = {"label": "the handout's setting", "linestyle": ""}
    ax.plot(case.time_per_simulation, case.threshold_worst, **label, **ring)


def _reach(ax, values):
    """Widen the limits of y, where they do not, to show every value."""
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, *(value / 1.3 for value in values)), max(high, *(1.3 * v for v in values)))


def _draw_sources(ax, sources):
    """Tick the errors of other sources on the right."""
    if not sources:
        return
    _reach(ax, sources.values())
    right = ax.secondary_yaxis("right")
    right.set_yticks(list(sources.values()), list(sources))
    right.set_yticks([], minor=True)
    right.set_ylabel("other sources, each alone")


def _draw_own_error(ax, found):
    """Shade what lies below the own error of the converged thresholds."""
    run = found.isel(reference=0)
    own = (run.converged_threshold_error / run.converged_threshold).where(run.threshold_decided)
    if own.isnull().all():
        return
    highest = own.max().item()
    _reach(ax, [highest / 2])
    ax.axhspan(0, highest, color="0.93", zorder=0)
    text = {"fontsize": 6, "color": "0.35", "va": "top", "xytext": (3, -2)}
    place = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    ax.annotate("below the converged run's own error", (0, highest), **text, **place)


def _caption(found):
    """Which thresholds are meant, and what a star does."""
    known = found.threshold_decided.isel(reference=0)
    f0 = ", ".join(f"{value:.4g}" for value in found.f0.values)
    C = " or ".join(value_text("C", value) for value in found.C.values)
    caption = f"thresholds at $f_0$ = {f0} Hz, {C}; {int(known.sum())} of {known.size} well posed"
    starred = [str(name) for name in found.model.values if str(name).endswith(" modes")]
    return "; *".join([caption, *{name.split(", ")[-1] + " kept" for name in starred}])
