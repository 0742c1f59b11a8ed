"""The lowest N that snaps: over one axis or two, of several studies, as damage boundary."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import curves, plane, scales, style

DOUBTFUL = 0.01
"""Error bars above this share of the threshold are marked."""
BOUND = {"color": "0.4", "linewidth": 0.6, "linestyle": ":", "zorder": 1.5}
BOUND["label"] = "below it nothing snaps, by energy"
STAYS = curves.STAYS | {"label": "above it every $N$ seen stays snapped"}


def draw_thresholds(ax: Axes, found: xr.Dataset, x: str = "f0", lines: str = "C") -> Axes:
    """Draw N_first over one axis, a line for each value of another; what snaps below N_always.

    found: thresholds over these two axes; of many lines some are drawn, evenly chosen
    """
    found = curves.some_lines(found, x, lines)
    scales.study_axis(ax, scale := scales.scale_of(x, found[x].values))
    # As with a run-up, or where long pulses have no limit: some pulse snaps below it.
    if (found.N_first.notnull() & ~(found.N_first >= found.N_static)).any():
        bound = np.unique(found.N_bound.transpose(x, lines).values, axis=1)
        ax.plot(scale.places, bound, **BOUND)
    _draw_lines(ax, list(curves.each_line(found, lines)), x)
    keys = [*curves.line_keys(found, lines), *style.labelled([ax])]
    if found.islands.any():
        keys.append(Patch(color="0.5", alpha=0.3, linewidth=0, label="some $N$ here do not snap"))
        keys.append(Line2D([], [], color="0.5", linewidth=2.2, label="island of $N$ that snap"))
    style.legend(ax, keys, title(found, style.PAGE))
    return ax


def _draw_lines(ax, lines, x):
    """Draw thresholds over x, each with a colour and a marker, with their gaps and limits."""
    ax.set(yscale="log", ylabel=scales.axis_label("N", lines[0][0].attrs))
    for place, (found, colour, marker) in enumerate(lines):
        scale = scales.scale_of(x, found[x].values)
        _draw_gap(ax, found, scale, colour)
        curves.draw_curve(ax, scale.places, found, colour, marker)
        curves.mark_missing(ax, scale.places, found, colour, place)
        if found.N_latched.notnull().any():
            ax.plot(scale.places, found.N_latched.values, color=colour, **STAYS)
    draw_statics(ax, lines, x)
    scales.tick(ax.yaxis, *ax.get_ylim())
    for place, (found, colour, _) in enumerate(lines if x == "f0" else ()):
        curves.draw_impulsive(ax, found, colour, place)


def draw_statics(ax, lines, x):
    """Draw the limit of long pulses of every line, in grey what all have in common."""
    if len({found.N_static.values.tobytes() for found, *_ in lines}) == 1:
        curves.draw_static(ax, lines[0][0], x)
        return
    for place, (found, colour, _) in enumerate(lines):
        curves.draw_static(ax, found, x, colour, place)


def _draw_gap(ax, found, scale, colour):
    """Shade what lies between N_first and N_always of one line, and stroke the islands in it."""
    if not found.islands.any():
        return
    shade = {"color": colour, "alpha": 0.3, "linewidth": 0}
    ax.fill_between(scale.places, found.N_first.values, found.N_always.values, **shade)
    low, high = (
        ends.transpose(scale.key, "island").values for ends in (found.island_from, found.island_to)
    )
    places = np.repeat(scale.places, low.shape[1])
    ax.vlines(places, low.ravel(), high.ravel(), color=colour, linewidth=2.2, alpha=0.5)


def title(found, width):
    """What every curve has in common, in lines of so many signs."""
    symbols = [f"$C$ in {scales.WORDS['C'][1]}"] * ("C" in found.dims)
    v = found.velocity_change
    if v.ndim < 2 and v.notnull().any():  # as it stands in the keys
        symbols.append("$\\Delta v$: velocity change, limit of short pulses")
    words = [style.case(found.attrs, width), scales.place_text(found, width), "; ".join(symbols)]
    return "\n".join(filter(None, words))


def draw_threshold_map(ax: Axes, found: xr.Dataset, x: str, y: str) -> Axes:
    """Draw N_first over two axes as a field of colour with level lines.

    found: thresholds over these two axes; crossed where the error bar exceeds DOUBTFUL of N_first
    """
    found = found.sortby([key for key in (x, y) if found[key].dtype.kind in "fiu"])
    across = plane.open_plane(ax, found, x, y)
    N = found.N_first.transpose(y, x).values
    field = plane.fill_field(ax, found.N_first, *across, cmap="cividis")
    counted = any(scale.is_counted for scale in across)
    if min(N.shape) > 1 and np.isfinite(N).all() and not counted:
        levels = ax.contour(across[0].places, across[1].places, N, colors="white", linewidths=0.7)
        ax.clabel(levels, fmt=scales.number, fontsize=6)
    relative = (found.N_error / found.N_first).transpose(y, x).values
    j, i = np.nonzero(np.isfinite(N) & ~(relative <= DOUBTFUL))
    crosses = {"linestyle": "", "marker": "x", "markersize": 3, "color": "#d55e00"}
    crosses["label"] = f"error bar above {100 * DOUBTFUL:g} %"
    keys = ax.plot(across[0].places[i], across[1].places[j], **crosses) if i.size else []
    ax.settitle(scales.place_text(found))
    words, known = [style.case(found.attrs, style.COLUMN)], 100 * relative[np.isfinite(relative)]
    if known.size:
        middle, most = (scales.number(error, 2) for error in (np.median(known), known.max()))
        words.append(f"error bars: median {middle} %, largest {most} %")
    style.legend(ax, keys, "\n".join(filter(None, words)), 2)
    counted = style.multiples(found.attrs)
    plane.colour_bar(ax, field, f"threshold: lowest $N$ that snaps ({counted})")
    return ax
