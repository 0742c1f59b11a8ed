"""Figures of thresholds: curves over an axis, and maps over two."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from . import captions, curves, plane, scales, style

DOUBTFUL = 0.01
"""Share of the threshold above which error bars are marked."""
BOUND = {"color": "0.4", "linewidth": 0.6, "linestyle": ":", "zorder": 1.5}
BOUND["label"] = "below it nothing snaps, by energy"
BEYOND = 1.06
"""Factor beyond the lowest and the highest threshold up to which an axis goes."""
VALUE = {"ha": "center", "va": "center", "fontsize": 6, "color": "white"}
VALUE |= {"path_effects": [withStroke(linewidth=1.2, foreground="0.2")]}
NAME_ABOVE = 0.2
"""Height of a value above the middle of its tile, which may have a cross."""
NONE_KNOWN = "no threshold is known"
STAYS = curves.STAYS | {"label": "latched at all tested $N$ above"}


def draw_thresholds(ax: Axes, surface: xr.Dataset, x: str = "f0", lines: str = "C") -> Axes:
    """Draw N_first over an axis, with a line for each value of another, and islands below N_always.

    surface: thresholds over these two axes; of many lines some are drawn, evenly chosen
    """
    surface = curves.some_lines(surface, x, lines)
    scales.study_axis(ax, scale := scales.scale_of(x, surface[x].values, surface[x].attrs))
    scales.leave_space(ax, scale)
    _set_ends(ax, surface)
    # The limit of long pulses is no bound if a mass has a run-up, or if there is no such limit.
    if (surface.N_first.notnull() & ~(surface.N_first >= surface.N_static)).any():
        bound = np.unique(surface.N_bound.transpose(x, lines).values, axis=1)
        ax.plot(scale.places, bound, **BOUND)
    _draw_lines(ax, list(curves.each_line(surface, lines)), x)
    keys = [*curves.line_keys(surface, lines), *style.labelled([ax])]
    if curves.is_seen(ax, surface.N_first.values.ravel(), surface.N_always.values.ravel()):
        keys.append(Patch(color="0.5", alpha=0.3, linewidth=0, label="some $N$ here do not snap"))
    if curves.is_seen(ax, surface.island_from.values.ravel(), surface.island_to.values.ravel()):
        keys.append(Line2D([], [], color="0.5", linewidth=2.2, label="island of $N$ that snap"))
    style.note_missing(ax, surface.N_first, NONE_KNOWN)
    words = title(surface, style.signs(ax.get_figure())), curves.no_threshold(surface, lines)
    style.legend(ax, keys, "\n".join(filter(None, words)))
    return ax


def _set_ends(ax, surface):
    """Let the axis of N go as far as thresholds vary, whatever their limits are."""
    ax.set(yscale="log", ylabel=scales.label_in(ax, "N", surface.attrs))
    error = surface.N_error.where(np.isfinite(surface.N_error), 0)
    N = xr.concat([surface.N_first - error, surface.N_first + error], "end")
    known = np.concatenate([np.ravel(ends) for ends in (N, surface.N_always, surface.N_latched)])
    known = known[np.isfinite(known) & (known > 0)]
    if known.size:
        ax.set_ylim(known.min() / BEYOND, known.max() * BEYOND)


def _draw_lines(ax, lines, x):
    """Draw lines of thresholds over x, with gaps and limits; lines: data, colour and marker."""
    for place, (curve, colour, marker) in enumerate(lines):
        scale = scales.scale_of(x, curve[x].values)
        _draw_gap(ax, curve, scale, colour)
        curves.draw_curve(ax, scale.places, curve, colour, marker)
        curves.mark_missing(ax, scale.places, curve, colour, place)
        if curve.N_latched.notnull().any():
            ax.plot(scale.places, curve.N_latched.values, color=colour, **STAYS)
    draw_statics(ax, lines, x)
    scales.tick(ax.yaxis, *ax.get_ylim())
    for place, (curve, colour, _) in enumerate(lines if x == "f0" else ()):
        curves.draw_impulsive(ax, curve, colour, place)


def draw_statics(ax: Axes, lines: list[tuple], x: str) -> None:
    """Draw the limit of long pulses of every line, or one in grey if all have the same."""
    if len({curve.N_static.values.tobytes() for curve, *_ in lines}) == 1:
        curves.draw_static(ax, lines[0][0], x)
        return
    for place, (curve, colour, _) in enumerate(lines):
        curves.draw_static(ax, curve, x, colour, place)


def _draw_gap(ax, curve, scale, colour):
    """Shade a line between N_first and N_always, and stroke the islands in between."""
    if not curve.islands.any():
        return
    shade = {"color": colour, "alpha": 0.3, "linewidth": 0}
    ax.fill_between(scale.places, curve.N_first.values, curve.N_always.values, **shade)
    low, high = (
        ends.transpose(scale.key, "island").values for ends in (curve.island_from, curve.island_to)
    )
    places = np.repeat(scale.places, low.shape[1])
    ax.vlines(places, low.ravel(), high.ravel(), color=colour, linewidth=2.2, alpha=0.5)


def title(surface: xr.Dataset, width: int) -> str:
    """Write what all curves have in common, in lines of at most `width` signs."""
    v = surface.velocity_change
    symbols = [f"$C$ in {scales.unit_of('C', surface.C.attrs)}"] if "C" in surface.dims else []
    if v.ndim < 2 and v.notnull().any():  # as it stands in the keys
        symbols.append("$\\Delta v$: velocity change, limit of short pulses")
    words = [captions.case(surface.attrs, width), scales.place_text(surface, width)]
    return "\n".join(filter(None, [*words, "; ".join(symbols)]))


def draw_threshold_map(ax: Axes, surface: xr.Dataset, x: str, y: str) -> Axes:
    """Draw N_first over two axes as a field of colour with level lines.

    surface: thresholds over these two axes; a cross marks an error above DOUBTFUL of N_first
    """
    surface = surface.sortby([key for key in (x, y) if surface[key].dtype.kind in "fiu"])
    across = plane.open_plane(ax, surface, x, y)
    N = surface.N_first.transpose(y, x).values
    style.note_missing(ax, N, NONE_KNOWN)
    field = plane.fill_field(ax, surface.N_first, *across, cmap="viridis")
    counted = any(scale.is_counted for scale in across)
    if min(N.shape) > 1 and np.isfinite(N).all() and not counted:
        levels = ax.contour(across[0].places, across[1].places, N, colors="white", linewidths=0.7)
        ax.clabel(levels, fmt=scales.number, fontsize=6)
    if all(scale.is_counted for scale in across):
        for j, i in np.argwhere(np.isfinite(N)):
            at = across[0].places[i], across[1].places[j] + NAME_ABOVE
            ax.annotate(scales.number(N[j, i]), at, **VALUE)
    relative = (surface.N_error / surface.N_first).transpose(y, x).values
    j, i = np.nonzero(np.isfinite(N) & ~(relative <= DOUBTFUL))
    crosses = {"linestyle": "", "marker": "x", "markersize": 3, "color": "#d55e00"}
    crosses["label"] = f"error bar above {100 * DOUBTFUL:g} %"
    keys = ax.plot(across[0].places[i], across[1].places[j], **crosses) if i.size else []
    ax.set_title(scales.place_text(surface))
    words = [captions.case(surface.attrs, style.signs(ax.get_figure()))]
    known = 100 * relative[np.isfinite(relative)]
    if known.size:
        middle, most = (scales.number(error, 2) for error in (np.median(known), known.max()))
        words.append(f"error bars: median {middle} %, largest {most} %")
    counted = captions.multiples(surface.attrs)
    plane.colour_bar(ax, field, f"threshold: lowest $N$ that snaps ({counted})")
    style.legend(ax, keys, "\n".join(filter(None, words)), 2)
    return ax
