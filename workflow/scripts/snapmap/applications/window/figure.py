"""A figure of the region of two axes where required shocks are met."""

import textwrap
from itertools import cycle

import numpy as np
import xarray as xr
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withTickedStroke

from ...figures import captions, plane, scales, style
from ...figures.curves import LOOKS
from ...numerics.statistics import percents
from ...study.axes import Units
from ...study.study import ARRIVES, SNAPS
from ...values.units import spelling
from ..requirements.figure import WRONG, required_text
from .between import FAR, between, least_reserve, reserves_between

MEETING = {"color": "#a9cfe8", "linewidth": 0, "label": "all thresholds are as required"}
FAILING = WRONG | {"label": "a threshold is not as required"}
BEGINS_TO_FAIL = [withTickedStroke(angle=-90, length=0.6, spacing=6)]
POINTS = {"color": "0.3", "linestyle": "", "marker": ".", "markersize": 1.5, "clip_on": False}
POINTS["label"] = "points that were computed"
MARGINS, SHARES = (1.02, 1.05, 1.1, 1.15, 1.2, 1.5, 2), (0.5, 0.9, 0.99)
"""Level lines of the smallest safety factor, and of shares of devices."""


def draw(figure: FigureBase, data: xr.Dataset, units: Units) -> None:
    """Draw margins over two axes, and yield and stress if known, with the region that meets all.

    data: as `window_of` returns it; units: of the horizontal and of the vertical axis
    A requirement begins to fail at its line, on the side of the ticks. Values between points are
    bilinear.
    """
    x, y = units
    data = data.squeeze([key for key in data.reserve.dims[1:] if key not in units])
    data = data.transpose("requirement", ..., y, x)
    data = data.assign_coords({key: data[key].values / size for key, (_, size) in units.items()})
    reserve = reserves_between(data.reserve.values)
    least = least_reserve(reserve)
    fields: dict[str, tuple] = {"smallest safety factor on $N$": (least, MARGINS)}
    if "yield" in data:
        fields["share of devices that meet all"] = between(data["yield"].values), SHARES
    if "stress_max" in data:
        fields["largest stress (MPa)"] = data.stress_max.max("requirement"), ()
    axes = figure.subplots(1, len(fields), squeeze=False, sharey=True)[0]
    for ax, (title, (field, levels)) in zip(axes, fields.items(), strict=True):
        across = _open_window(ax, data, units)
        ax.set_title(title)
        ax.label_outer()
        grid = [between(scale.places, 1) for scale in across]
        style.note_missing(ax, field, "no device, or not known")
        if levels:
            _fill_window(ax, grid, reserve, least)
            for lines in _level_lines(ax, grid, field, levels, colors="0.3", linewidths=0.6):
                ax.clabel(lines, fmt=scales.number, fontsize=6)
        else:
            plane.colour_bar(ax, plane.fill_field(ax, field, *across, cmap="viridis"), "")
        for of_requirement, (colour, _) in zip(reserve, cycle(LOOKS), strict=False):
            for edge in _level_lines(ax, grid, of_requirement, [1], colors=colour):
                edge.set(path_effects=BEGINS_TO_FAIL)
    places = np.meshgrid(*(scale.places for scale in across))
    points = axes[0].plot(*map(np.ravel, places), **POINTS)
    style.legend(figure, [*_window_keys(data, reserve, least), *points], _about(data, reserve), 3)


def _open_window(ax, data, units):
    """Open a plane with its axes in their units, up to the outermost points."""
    across = [scales.scale_of(key, data[key].values) for key in units]
    scales.study_axis(ax, across[0])
    scales.set_scale(ax, "y", across[1])
    for which, scale, (unit, _) in zip("xy", across, units.values(), strict=True):
        ends, label = (
            scale.places[[0, -1]],
            scales.axis_label(scale.key, unit=spelling(unit).figures),
        )
        ax.set(**{f"{which}lim": ends, f"{which}label": label})
        if not scale.is_counted:
            scales.tick(getattr(ax, f"{which}axis"), *ends, scale.is_log)
    return across


def _fill_window(ax, grid, reserve, least):
    """Fill the regions that meet all requirements and that do not; unknown regions are hatched."""
    if np.isnan(least).any():
        ax.patch.set(**plane.HATCHES["absent"])
    ax.contourf(*grid, least, [0, FAR], colors=[MEETING["color"]])
    for field in reserve:  # each by itself, as the least of two is cut off where they cross
        failing = np.where(np.isnan(least), np.nan, field)
        ax.contourf(*grid, failing, [0, 1], colors=[FAILING["color"]])


def _level_lines(ax, grid, field, levels, **look):
    """Yield the contours at the levels within a field's range, if there are any."""
    low, high = _ends(field)
    if within := [level for level in levels if low < level < high]:
        yield ax.contour(*grid, field, within, **look)


def _ends(field):
    """The least and the largest known value."""
    return np.nanmin(field, initial=np.inf), np.nanmax(field, initial=-np.inf)


def _window_keys(data, reserve, least):
    """Keys of the requirements that begin to fail in the window, and of its colours."""
    known = least[np.isfinite(least)]
    looks = cycle(LOOKS)
    for field, must, (colour, _) in zip(reserve, data.must_snap, looks, strict=False):
        low, high = _ends(field)
        if low < 1 < high:
            arrives = SNAPS[ARRIVES] if must else SNAPS[False]  # lines are of thresholds
            label = required_text(must.requirement.item(), arrives)
            yield Line2D([], [], color=colour, path_effects=BEGINS_TO_FAIL, label=label)
    if (known >= 1).any():
        yield Patch(**MEETING)
    if (known < 1).any():
        yield Patch(**FAILING)
    if known.size < least.size:
        yield Patch(facecolor="white", **plane.HATCHES["absent"], label="no device, or not known")


def _about(data, reserve):
    """The conditions of a window, requirements without a line in it, and error bars."""
    bar, off = (data.N_error / data.N_first).max(), data.reserve.attrs["off_between_points"]
    sure = f"error bars up to {percents(bar)}, between points up to {percents(off)} more"
    if np.isnan(bar):
        sure = "nothing snaps"
    if "yield" in data:
        sure += f", shares within {percents(abs(data.yield_bound - data['yield']).max())}"
    words = [scales.place_text(data)]
    if "temperatures" in data.attrs:
        low, *_, high = np.sort(data.attrs["temperatures"])
        words.append(f"at each temperature from {scales.number(low)} to {scales.number(high)} °C")
    everywhere = {"met": (reserve >= 1).all(axis=(1, 2)), "failed": (reserve < 1).all(axis=(1, 2))}
    for word, which in everywhere.items():
        if names := ", ".join(data.requirement.values[which]):
            words.append(captions.literal(f"{word} everywhere: {names}"))
    words.append(f"ticks: where a requirement fails; {sure}")
    return "\n".join(textwrap.fill(line, captions.PAGE) for line in words if line)
