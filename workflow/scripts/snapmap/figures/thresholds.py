"""The lowest N that snaps: over any axis, over two of them, and as a damage boundary."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import style
from .curves import (
    STAYS,
    bound_key,
    curve_keys,
    draw_bound,
    draw_curve,
    draw_impulsive,
    draw_static,
    each_line,
    freeze,
    limit_key,
    limit_look,
    line_keys,
    mark_missing,
    missing_keys,
    some_lines,
    undercuts,
    velocity_change,
)
from .plane import BELOW_BAR, colour_bar, fill_field, open_plane
from .scales import (
    WORDS,
    amplitude_axis,
    end_at_ticks,
    frequency_axis,
    number,
    place_text,
    scale_of,
    set_scale,
    value_text,
    velocity_axis,
)

DOUBTFUL = 0.01
"""Error bars above this share of the threshold are marked."""
DURATION = {"color": "0.6", "linewidth": 0.5, "linestyle": ":", "zorder": 1}
SHADE = {"color": "0.9", "linewidth": 0, "zorder": 0}
NOTE = {"fontsize": 6, "textcoords": "offset points"}
SYMBOLS = r"$\Delta v$: velocity change, limit of short pulses"
ROOM = 0.15
"""For words below the lowest threshold, as a share of the height."""
WHOLE = 58
"""Signs in a line over the whole width of a column."""
MANY_KEYS = 9
"""In a legend, which are then set in fewer columns."""
FAR = 1e9
"""Beyond the edges of any axes, as a factor."""


def draw_thresholds(ax: Axes, found: xr.Dataset, x: str = "f0", lines: str = "C") -> Axes:
    """Draw N_first over one axis, a line for each value of another; what snaps below N_always.

    found: thresholds over these two axes; of many lines some are drawn, evenly chosen
    """
    found = some_lines(found, x, lines)
    scale = scale_of(x, found[x].values)
    if x == "f0":
        frequency_axis(ax, found.f0.values)
    else:
        set_scale(ax, "x", scale)
    amplitude_axis(ax)
    for place, (one, colour, marker) in enumerate(each_line(found, lines)):
        _draw_gap(ax, one, scale, colour)
        draw_curve(ax, scale.places, one, colour, marker)
        mark_missing(ax, scale.places, one, colour, place)
        if one.N_latched.notnull().any():
            ax.plot(scale.places, one.N_latched.values, color=colour, **STAYS)
    _draw_limits(ax, found, x, lines)
    if x == "f0":
        _label_limits(ax, found)
    keys = [*line_keys(found, lines), *curve_keys(found, "0.4", "o"), *_gap_keys(found)]
    if found.N_latched.notnull().any():
        keys.append(Line2D([], [], color="0.4", **STAYS, label="above it, all looked at latch"))
    keys += [] if x == "f0" else [limit_key("threshold of long pulses")]
    keys += [*missing_keys(found), *[bound_key()] * undercuts(found)]
    style.legend_below(ax, keys, _title(found, style.PAGE), ncols=4 if len(keys) < MANY_KEYS else 3)
    return ax


def draw_threshold_map(ax: Axes, found: xr.Dataset, x: str, y: str) -> Axes:
    """Draw N_first over two axes as a field of colour with level lines.

    found: thresholds over these two axes; crossed where the error bar exceeds DOUBTFUL of N_first
    """
    found = found.sortby([key for key in (x, y) if found[key].dtype.kind in "fiu"])
    scales = open_plane(ax, found, x, y)
    N = found.N_first.transpose(y, x).values
    field = fill_field(ax, found.N_first, *scales, cmap="cividis")
    colour_bar(ax, field, "lowest $N$ that snaps (multiples of $g$)")
    counted = any(scale.is_counted for scale in scales)
    if min(N.shape) > 1 and np.isfinite(N).all() and not counted:
        levels = ax.contour(scales[0].places, scales[1].places, N, colors="white", linewidths=0.7)
        ax.clabel(levels, fmt=number, fontsize=6)
    relative = (found.N_error / found.N_first).transpose(y, x).values
    doubtful = np.isfinite(N) & ~(relative <= DOUBTFUL)
    j, i = np.nonzero(doubtful)
    if i.size:
        dots = {"linestyle": "", "marker": "x", "markersize": 3, "color": "#d55e00"}
        words = f"error bar above {100 * DOUBTFUL:g} %"
        ax.plot(scales[0].places[i], scales[1].places[j], **dots, label=words)
        keys = ax.get_legend_handles_labels()[0]
        style.legend_below(ax, keys, "", ncols=2, below=BELOW_BAR)
    lines = [place_text(found), style.case(found.attrs, style.COLUMN), _sureness(relative)]
    ax.set_title("\n".join(filter(None, lines)))
    return ax


def draw_design(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the line along which a threshold is what was asked for, over two values of the device.

    found: as `sizing.design` gives it along an axis, with error bars
    """
    (x,) = found.error.dims
    y = next(key for key in found.data_vars if key not in ("error", "solutions"))
    scale = scale_of(x, found[x].values)
    set_scale(ax, "x", scale)
    ax.errorbar(scale.places, found[y].values, found.error.values, marker="o", elinewidth=0.6)
    words, unit = WORDS[y]
    ax.set_ylabel(f"{words} ({unit})")
    ax.set_title(found[y].attrs["comment"])
    return ax


def _sureness(relative):
    """How large the error bars are, as shares of the thresholds."""
    known = 100 * relative[np.isfinite(relative)]
    if not known.size:
        return ""
    return f"error bars: median {np.median(known):.2g} %, largest {known.max():.2g} %"


def draw_damage_boundary(ax: Axes, found: xr.Dataset, lines: str = "C") -> Axes:
    """Draw N_first over the velocity change (m/s) for each line, and what snaps of the first one.

    found: thresholds over f0 and the axis `lines`; of many lines some are drawn
    Along dotted lines the duration of the pulse is constant; shaded is what lies above the first
    curve, of the durations that it has.
    """
    found = some_lines(found, "f0", lines)
    velocity_axis(ax)
    amplitude_axis(ax)
    ax.set_ylabel("peak acceleration $N$ (multiples of $g$)")
    for one, colour, marker in each_line(found, lines):
        draw_curve(ax, velocity_change(one).values, one, colour, marker, size=2)
    _draw_boundary_limits(ax, found, lines)
    first = found.isel({lines: 0})
    _draw_region(ax, first)
    _draw_durations(ax, first)
    name = value_text(lines, first[lines].item()).replace(WORDS["C"][1], "").strip()
    keys = [*line_keys(found, lines), *curve_keys(found, "0.4", "o")]
    keys.append(Patch(**SHADE, label=f"snaps, {name}"))
    place = {"loc": "lower left", "bbox_to_anchor": (-0.16, 1.03), "ncols": 2}
    ax.legend(handles=keys, title=_title(found, WHOLE), alignment="left", **place)
    return ax


def _draw_limits(ax, found, x, lines):
    """Draw the limits of all lines, and leave room for words below them."""
    if lines not in found.N_static.dims:
        draw_static(ax, found, x)
    for place, (one, colour, _) in enumerate(each_line(found, lines)):
        if lines in found.N_static.dims:
            draw_static(ax, one, x, colour, place)
    if undercuts(found):
        draw_bound(ax, found, x, lines)
    _make_room(ax)
    if x == "f0":
        for place, (one, colour, _) in enumerate(each_line(found, lines)):
            draw_impulsive(ax, one, colour, place)


def _make_room(ax):
    """Move the lower end of the axes down to make room for words; end them at ticks."""
    ax.set_ylim(bottom=_height(ax, -ROOM))
    end_at_ticks(ax.yaxis)


def _height(ax, share):
    """The N at a share of the height of the axes."""
    low, high = ax.get_ylim()
    return low * (high / low) ** share


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


def _label_limits(ax, found):
    static = _known(found.N_static)
    if static.size:
        words = "threshold of long pulses"
        words += f", $N$ = {static[0]:.4g}" if static.size == 1 else ""
        ax.annotate(words, (ax.get_xlim()[0], static[0]), xytext=(4, -4), va="top", **NOTE)
    per_N = _known(found.gravity * found.area / (1e-6 * found.velocity_change))
    if static.size and per_N.size:
        lowest = np.fmin(static[0], np.nanmin(found.N_first.values, initial=np.inf))
        N = np.sqrt(lowest * ax.get_ylim()[0])
        words = "limit of short pulses"
        if found.area.ndim == 0:
            words += f",\n$N = {1 / found.area.item():.3g} f_0\\,\\Delta v/g$"
        place = {"xytext": (-6, 0), "ha": "right", "va": "center", **NOTE}
        ax.annotate(words, (N * per_N[0], N), **place)


def _known(values):
    """Finite values, each once, ascending."""
    return np.unique(values.values[np.isfinite(values.values)])


def _draw_region(ax, found):
    """Shade what snaps at the durations of a curve; where it has a hole, the shade has one."""
    found = found.sortby("f0", ascending=False)
    N, v = found.N_first.values, velocity_change(found).values
    known = np.flatnonzero(np.isfinite(N))
    for run in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
        if run.size > 1:
            ends = run[[0, -1]]
            corners = [np.stack([v, N])[:, run], FAR * np.stack([v, N])[:, ends[::-1]]]
            ax.fill(*np.concatenate(corners, axis=1), **SHADE)


def _draw_boundary_limits(ax, found, lines):
    static, changes = _known(found.N_static), _known(found.velocity_change)
    for place, (one, colour, _) in enumerate(each_line(found, lines)):
        if np.isfinite(one.velocity_change):
            ax.axvline(one.velocity_change.item(), **limit_look(colour, place))
        if lines in found.N_static.dims:
            draw_static(ax, one, "f0", colour, place)
    if lines not in found.N_static.dims:
        draw_static(ax, found, "f0")
    end_at_ticks(ax.xaxis)
    _make_room(ax)
    freeze(ax)
    if static.size and changes.size:
        words = "long pulses" + (f", $N$ = {static[0]:.4g}" if static.size == 1 else "")
        at = changes[-1], static[0]
        ax.annotate(words, at, xytext=(4, -4), va="top", **NOTE)


def _draw_durations(ax, found):
    """Draw lines of constant pulse duration, one for each decade of the frequencies looked at."""
    first, last = np.log10(found.f0.values[[0, -1]])
    for f0 in 10.0 ** np.arange(np.ceil(first), np.floor(last) + 1):
        v = found.gravity * found.area.item() / (1e-6 * f0)
        ax.plot([v / FAR, v * FAR], [1 / FAR, FAR], **DURATION)
        _label_duration(ax, f"{1e3 / f0:g} ms", v)


def _label_duration(ax, words, v):
    """Write along the line of the velocity change v per N, at its top or its foot."""
    is_whole = v * ax.get_ylim()[1] < ax.get_xlim()[1]
    N, side = (_height(ax, 0.97), "right") if is_whole else (_height(ax, 0.02), "left")
    place = {"ha": side, "va": "bottom", "rotation_mode": "anchor"}
    turn = {"rotation": np.degrees(np.arctan(1 / v)), "transform_rotates_text": True}
    ax.text(v * N, N, words, fontsize=6, color="0.4", **place, **turn)


def _title(found, width):
    """What every curve has in common, in lines of so many signs."""
    place = place_text(found).replace("\n", ", ")
    units = f"$C$ in {WORDS['C'][1]}" if "C" in found.dims else ""
    symbols = SYMBOLS if found.velocity_change.notnull().any() else ""
    words = "; ".join(filter(None, [units, symbols]))
    return "\n".join(filter(None, [style.case(found.attrs, width), place, words]))


def _gap_keys(found):
    if not found.islands.any():
        return []
    gap = Patch(color="0.5", alpha=0.3, linewidth=0, label="above it, some $N$ do not snap")
    island = Line2D([], [], color="0.5", linewidth=2.2, label="island of $N$ that snap")
    return [gap, island]
