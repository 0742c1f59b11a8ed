"""Thresholds over the velocity change of the pulse, as a damage boundary."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from ...figures import curves, plane, scales, style
from ...figures.thresholds import NONE_KNOWN, draw_statics, title

DURATION = {"color": "0.6", "linewidth": 0.5, "linestyle": ":", "zorder": 1}
SHADE = {"alpha": 0.12, "linewidth": 0, "zorder": 0}
APART = 1.7
"""Least ratio of durations whose names do not meet."""
FAR = 1e9
"""Factor that leads from any point in the axes beyond their edges."""


def draw(figure: Figure, thresholds: xr.Dataset, lines: str, at: Mapping[str, int]) -> None:
    """Draw the damage boundary at a place on all axes but those of f0 and lines."""
    draw_damage_boundary(figure.subplots(), thresholds.isel(at), lines)


def draw_damage_boundary(ax: Axes, thresholds: xr.Dataset, lines: str = "C") -> Axes:
    """Draw N_first over the velocity change (m/s) for each line, and shade the region that snaps.

    thresholds: over f0 and the axis `lines`; only some of many lines are drawn
    The duration of the pulse is constant along a dotted line. The region above each curve is
    shaded in its colour, from the shortest to the longest simulated pulse.
    """
    thresholds = curves.some_lines(thresholds, "f0", lines)
    ax.set(xscale="log", xlabel="velocity change of the pulse (m/s)")
    ax.set(yscale="log", ylabel=scales.label_in(ax, "N", thresholds.attrs))
    drawn = list(curves.each_line(thresholds, lines))
    for place, (curve, colour, marker) in enumerate(drawn):
        curves.draw_curve(ax, curves.velocity_change(curve).values, curve, colour, marker)
        if np.isfinite(curve.velocity_change):
            look = curves.limit_look(curves.SHORT, colour, place) | {"label": curves.SHORT}
            ax.axvline(curve.velocity_change.item(), **look)
    draw_statics(ax, drawn, "velocity change")
    scales.tick(ax.xaxis, *ax.get_xlim())
    scales.tick(ax.yaxis, *ax.get_ylim())
    plane.freeze(ax)
    for curve, colour, _ in drawn:
        _draw_region(ax, curve, colour)
    _draw_durations(ax, thresholds.isel({lines: 0}))
    words = "snaps, in the colour of its line" if drawn[1:] else "snaps"
    shade = Patch(**SHADE | {"alpha": 0.3}, color="0.4" if drawn[1:] else drawn[0][1], label=words)
    keys = [*curves.line_keys(thresholds, lines), *style.labelled([ax]), shade]
    style.note_missing(ax, thresholds.N_first, NONE_KNOWN)
    heads = title(thresholds, style.signs(ax.get_figure())), curves.no_threshold(thresholds, lines)
    # The curves bend to the lower left.
    corner = {} if style.is_ours(ax) else {"loc": "upper right"}
    style.legend(ax, keys, "\n".join(filter(None, heads)), 2, **corner)
    return ax


def _draw_region(ax, thresholds, colour):
    """Shade the region above each stretch of a curve between its holes."""
    thresholds = thresholds.sortby("f0")
    N, v = thresholds.N_first.values, curves.velocity_change(thresholds).values
    known = np.flatnonzero(np.isfinite(N))
    for run in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
        if run.size > 1:
            ends = run[[0, -1]]
            corners = [np.stack([v, N])[:, run], FAR * np.stack([v, N])[:, ends[::-1]]]
            ax.fill(*np.concatenate(corners, axis=1), color=colour, **SHADE)


def _draw_durations(ax, thresholds):
    """Draw a line of constant pulse duration at both ends and for each decade between.

    Each is named where it leaves the axes.
    """
    first, last = thresholds.f0.values[[0, -1]]
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    decades = 10.0 ** np.arange(np.ceil(np.log10(first)), np.log10(last))
    apart = decades[(decades > APART * first) & (decades < last / APART)]
    for f0 in dict.fromkeys([first, *apart, last]):
        v = thresholds.gravity * thresholds.area.item() / (1e-6 * f0)
        ax.plot([v / FAR, v * FAR], [1 / FAR, FAR], **DURATION)
        note = {"text": f"{scales.number(1e3 / f0, 3)} ms", "textcoords": "offset points"}
        note |= {"fontsize": 6, "color": "0.4"}
        if left < v * high < right:
            ax.annotate(xy=(v * high, high), xytext=(0, 2), ha="center", **note)
        elif low < right / v < high:
            ax.annotate(xy=(right, right / v), xytext=(2, 0), va="center", **note)
