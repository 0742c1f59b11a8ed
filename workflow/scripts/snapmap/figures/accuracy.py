"""Error against time per simulation, for every model; other sources beside it.

The error is that of the threshold or, where no threshold is well posed, that of the labels.
"""

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
JUDGED = {
    "threshold_worst": "largest relative error of the threshold",
    "label_error": "share of cells with another label",
}
"""Words for the errors by which models may be ranked."""


def draw_accuracy(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the error over the time per simulation, us."""
    ax.set_xscale("log")
    scale_error(ax, found)
    ax.margins(x=0.08)
    _draw_front(ax, found)
    for family, style in LINES.items():
        _draw_family(ax, of_family(found, family), *style)
    _draw_handout(ax, found)
    sources = other_sources(found)
    _draw_sources(ax, sources)
    _draw_own_error(ax, found)
    begin_at_zero(ax, found)
    ax.set_xlabel("time per simulation (µs)")
    ax.set_ylabel(JUDGED[found.judged_by])
    place = {"loc": "lower left", "bbox_to_anchor": (0, 1.03), "ncols": 3}
    ax.legend(title=_caption(found), alignment="left", **place)
    return ax


def error_of(cases: xr.Dataset) -> xr.DataArray:
    """The error by which cases are ranked."""
    return cases[cases.judged_by]


def scale_error(ax: Axes, found: xr.Dataset) -> None:
    """Scale y for errors in percent: by ratio for thresholds; those of labels may be 0."""
    ax.set_yscale("log" if found.judged_by == "threshold_worst" else "linear")
    ax.yaxis.set_major_formatter(lambda error, _: f"{100 * error:.6g} %")


def begin_at_zero(ax: Axes, found: xr.Dataset) -> None:
    """Let y begin at errors of 0 where they are those of labels, with room for their markers."""
    if found.judged_by == "label_error":
        top = ax.get_ylim()[1]
        ax.set_ylim(-0.05 * top, top)


def of_family(found: xr.Dataset, family: str) -> xr.Dataset:
    """The cases of one family."""
    names = found.family.attrs["flag_meanings"].split()
    return found.isel(model=np.flatnonzero(found.family == names.index(family)))


def other_sources(found: xr.Dataset) -> dict[str, float]:
    """Error of each penalty against hard contact, and of the handout's step, by label."""
    penalties = of_family(found, "penalty")
    cases = zip(penalties.contact.values, error_of(penalties).values, strict=True)
    soft = [(contact, worst) for contact, worst in cases if contact < np.inf]
    sources = {f"contact {contact:g} N/m, not hard": worst for contact, worst in soft}
    step = error_of(found).sel(model=HANDOUT_STEP).item()
    sources["time step, 0.8 of its limit"] = step
    return {label: float(worst) for label, worst in sources.items() if worst > LEAST}


def _draw_front(ax, found):
    front = found.isel(model=np.flatnonzero(found.on_front)).sortby("time_per_simulation")
    path = {"color": "0.8", "linewidth": 4, "solid_capstyle": "round", "zorder": 1}
    label = "Pareto front: none is faster and better"
    ax.step(front.time_per_simulation, error_of(front), where="post", label=label, **path)


def _draw_family(ax, cases, label, colour, marker, filled, offset):
    if cases.sizes["model"] == 0:
        return
    look = {"color": colour, "marker": marker, "linestyle": "-" if filled else "--"}
    look["markerfacecolor"] = colour if filled else "white"
    ax.plot(cases.time_per_simulation, error_of(cases), label=label, **look)
    text = {"textcoords": "offset points", "xytext": offset, "color": colour, "fontsize": 6}
    text["path_effects"] = [withStroke(linewidth=1.5, foreground="white")]
    points = zip(cases.time_per_simulation.values, error_of(cases).values, strict=True)
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
    ax.plot(case.time_per_simulation, error_of(case), **label, **ring)


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


def own_error(found: xr.Dataset) -> float:
    """Of the converged run: its largest, of well-posed thresholds, or that of its labels."""
    run = found.isel(reference=0)
    if found.judged_by == "label_error":
        return run.converged_label_error.item()
    own = run.converged_threshold_error / run.converged_threshold
    return own.where(run.threshold_decided).max().item()


def _draw_own_error(ax, found):
    """Shade what lies below the own error of the converged run."""
    if not (highest := own_error(found)):
        return
    if found.judged_by == "threshold_worst":
        _reach(ax, [highest / 2])
    ax.axhspan(0, highest, color="0.93", zorder=0)
    text = {"fontsize": 6, "color": "0.35", "va": "top", "xytext": (3, -2)}
    place = {"xycoords": ("axes fraction", "data"), "textcoords": "offset points"}
    ax.annotate("below the converged run's own error", (0, highest), **text, **place)


def _caption(found):
    """Which errors are meant, what a star does, and what was cut down."""
    lines = [_of_thresholds(found) if found.judged_by == "threshold_worst" else _of_labels(found)]
    starred = [str(name) for name in found.model.values if str(name).endswith(" modes")]
    lines[0] = "; *".join([lines[0], *{name.split(", ")[-1] + " kept" for name in starred}])
    return "\n".join([*lines, *(f"only {line}" for line in [found.left_out] if line)])


def _of_thresholds(found):
    known = found.threshold_decided.isel(reference=0)
    f0 = ", ".join(f"{value:.4g}" for value in np.unique(found.f0))
    C = " or ".join(value_text("C", value) for value in np.unique(found.C))
    return f"thresholds at $f_0$ = {f0} Hz, {C}; {int(known.sum())} of {known.size} well posed"


def _of_labels(found):
    snapped = found.share_snapped.values[0]
    return f"labels of a map of which {snapped:.0%} snaps, as no threshold is well posed"
