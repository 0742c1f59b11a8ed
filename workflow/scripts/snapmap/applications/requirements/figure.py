"""Required shocks: the margin of each, and which share of devices as made meets them."""

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withTickedStroke

from ...figures import plane, style
from ...figures.curves import LOOKS, each_line
from ...figures.scales import (
    NONE,
    axis_label,
    number,
    place_text,
    tick,
    value_text,
)
from ...numerics.between import (
    FAR,
    between,
    least_reserve,
    reserves_between,
)
from ...numerics.statistics import percents, scope
from ...solver.settings import SECOND
from ...study.axes import Units
from ...study.study import ANY, SNAPS
from .corners import corners, must_text

VERDICTS = {
    "met": {"color": "C0", "marker": "o"},
    "unclear": {"color": "0.5", "marker": "s"},
    "failed": {"color": "#d55e00", "marker": "X"},
}
OTHER = {"color": "0.4", "marker": ".", "linestyle": "", "markersize": 3}
"""Corners that are not the worst."""
BEYOND = 1.25
"""Room beyond the outermost margins, as a factor."""
MEETING = {"color": "#a9cfe8", "linewidth": 0, "label": "all requirements are met"}
FAILING = {"color": "#fdebdc", "linewidth": 0, "label": "a requirement fails"}
BEGINS_TO_FAIL = [withTickedStroke(angle=-90, length=0.6, spacing=6)]
POINTS = {"color": "0.3", "linestyle": "", "marker": ".", "markersize": 1.5, "clip_on": False}
POINTS["label"] = "points that were computed"
MARGINS, SHARES = (1.02, 1.05, 1.1, 1.15, 1.2, 1.5, 2), (0.5, 0.9, 0.99)
"""Level lines of factors by which an N may change, and of shares of devices."""
NAME = 24
"""Signs in a line of a requirement's name beside its shares."""
MET, FAILS = (
    {"color": "0.93", "linewidth": 0},
    {"color": "0.9", "linewidth": 0, "label": "the requirement fails"},
)


def draw_margins(ax: Axes, verdicts: Sequence[Mapping]) -> Axes:
    """Draw the threshold over the required N of each verdict, with its bar; logarithmic.

    verdicts: rows of requirements.csv
    A row is of a requirement on a device at one C; of several shocks or temperatures it is the
    worst, which its name tells, and the others are dots. Shaded is where it is met: above one if
    the shock must not trip, below if it must; all of what may trip or not and is met.
    """
    groups = corners(verdicts)
    known = [row["margin"] for row in verdicts if row["margin"] == row["margin"]]
    low, high = min([*known, 0.8]) / BEYOND, max([*known, 1.25]) * BEYOND
    ax.set(xscale="log", xlim=(low, high), ylim=(len(groups) - 0.5, -0.5))
    for place, (row, *others) in enumerate(groups):
        margin, note = row["margin"], {"va": "center", "fontsize": 6}
        whole = (low, high if row["verdict"] == "met" else low)
        ends = {True: (low, 1), False: (1, high)}.get(row["must_snap"], whole)
        ax.fill_betweenx([place - 0.45, place + 0.45], *ends, **MET)
        ax.plot([one["margin"] for one in others], [place] * len(others), **OTHER)
        if margin == margin:
            ax.errorbar(margin, place, xerr=row["margin_error"], **VERDICTS[row["verdict"]])
        else:
            ax.annotate("snaps at no $N$ seen ", (high, place), ha="right", **note)
        if row["break_probability"] > 1 - row["must_survive"]:
            beside = np.fmax.reduce([low, *(one["margin"] for one in (row, *others))])
            ax.annotate("   the beam breaks", (beside, place), **note)
    ax.axvline(1, color="black", linewidth=0.6)
    ax.set_yticks(range(len(groups)), [_name(row) for row, *_ in groups])
    ax.tick_params(axis="y", which="minor", left=False)
    ax.set_xlabel("margin: threshold over required $N$")
    tick(ax.xaxis, low, high)
    there = [kind for kind in VERDICTS if any(row["verdict"] == kind for row, *_ in groups)]
    keys = [Line2D([], [], linestyle="", **VERDICTS[kind], label=kind) for kind in there]
    if len(groups) < len(verdicts):
        keys.append(Line2D([], [], **OTHER, label="under another shock, at another temperature"))
    style.legend(ax, [*keys, Patch(**MET, label="where the requirement is met")])
    return ax


def _name(row):
    shock = f"{row['shape']} {row['direction'].replace('-', '−')}"
    start = "from the second shape" if row["start"] == SECOND else ""
    where = [row["device"], start, shock]
    where += [f"{number(row['temperature'])} °C", value_text("C", row["C"])]
    return f"{_required(row['requirement'], row['must_snap'])}\n{', '.join(filter(None, where))}"


def _required(name, must_snap):
    return must_text(style.literal(name), must_snap)


def draw_requirement(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the thresholds of the devices under one required pulse, and what meets it.

    found: of one requirement and C; shaded is where it fails
    """
    N_first, N = found.N_first_required.values, found.N_required.item()
    must = found.must_snap.item()
    known = N_first[np.isfinite(N_first)]
    ends = np.array([*known, N])
    room = 0.05 * np.ptp(ends) or 0.05 * N
    low, high = max(ends.min() - room, 0), ends.max() + room
    where = [place_text(found)]
    if must != SNAPS[ANY]:
        where.append(f"met by {percents(found.share_meeting)}")
        ax.axvspan(*((N, high) if must else (low, N)), **FAILS)
    ax.hist(known, bins="sqrt", color="#0072b2", alpha=0.8)
    ax.axvline(N, color="black", linewidth=0.8, label="required $N$")
    words = ", ".join(filter(None, where))
    ax.set_title(f"{_required(found.requirement.item(), must)}\n{words}")
    label = f"threshold $N$ ({style.multiples(found.attrs)})"
    ax.set(xlim=(low, high), xlabel=label, ylabel="devices")
    ax.locator_params(axis="y", integer=True)
    tick(ax.xaxis, low, high, is_log=False)
    return ax


def each_share(found: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, xr.DataArray]]:
    """Name, share and bounds of each requirement, of beams that it leaves unbroken, and of all."""
    for name in found.requirement.values.tolist():
        one = found.sel(requirement=name)
        if one.must_snap != SNAPS[ANY]:
            yield name, one.share_meeting, one.share_meeting_bound
        if "share_breaking" in found:
            bounds = 1 - one.share_breaking_bound.isel(bound=slice(None, None, -1))
            yield f"{name}, unbroken", 1 - one.share_breaking, bounds
    yield f"all together{scope(found['yield'])}", found["yield"], found.yield_bound


def draw_yield(ax: Axes, found: xr.Dataset) -> Axes:
    """Draw the shares of devices that meet each requirement, and all of them, with their bounds.

    found: over requirements and C
    """
    names, shares, bounds = zip(*each_share(found), strict=True)
    shares = np.stack(shares)
    bounds = np.stack([one.transpose("bound", "C") for one in bounds], axis=1)
    rows = np.arange(len(names))
    for i, (one, colour, marker) in enumerate(each_line(found, "C")):
        y = rows + 0.7 * ((i + 0.5) / found.C.size - 0.5)
        error = abs(bounds[:, :, i] - shares[:, i])
        look = {"color": colour, "marker": marker, "linestyle": "", "clip_on": False}
        ax.errorbar(shares[:, i], y, xerr=error, label=value_text("C", one.C.item()), **look)
        for at, share, ends in zip(y, shares[:, i], bounds[:, :, i].T, strict=True):
            words = f"{percents(share)} ({percents(*ends)})"
            place = {"xytext": (6, 0), "textcoords": "offset points", "va": "center"}
            ax.annotate(words, (1, at), fontsize=6, **place)
    ax.axhline(rows[-1] - 0.5, color="0.6", linewidth=0.5)
    ax.set(xlim=(0, 1), ylim=(rows[-1] + 0.5, -0.5), xlabel="share of devices that meet it")
    ax.set_yticks(rows, [textwrap.fill(style.literal(name), NAME) for name in names])
    ax.tick_params(axis="y", which="minor", left=False)
    return ax


def draw_window(figure: FigureBase, found: xr.Dataset, x: str, y: str, units: Units = NONE) -> None:
    """Draw over two axes where all requirements are met: margins, yield and stress, if known.

    found: as from `window.window_of`; units: in which the axes are drawn, if not internal ones
    Lines are where a requirement begins to fail, with ticks on that side. Between points all is
    straight along either axis.
    """
    found = found.squeeze([key for key in found.reserve.dims[1:] if key not in (x, y)])
    found = found.transpose("requirement", ..., y, x)
    sizes = {key: size for key, (_, size) in units.items()}
    found = found.assign_coords({key: found[key].values / sizes[key] for key in sizes})
    reserve = reserves_between(found.reserve.values)
    least = least_reserve(reserve)
    fields = {"least factor that $N$ may change by": (least, MARGINS)}
    if "yield" in found:
        fields["share of devices that meet all"] = between(found["yield"].values), SHARES
    if "stress_max" in found:
        fields["largest stress (MPa)"] = found.stress_max.max("requirement"), ()
    axes = figure.subplots(1, len(fields), squeeze=False, sharey=True)[0]
    for ax, (title, (field, levels)) in zip(axes, fields.items(), strict=True):
        across = _open_window(ax, found, x, y, units)
        ax.set_title(title)
        ax.label_outer()
        grid = [between(scale.places, 1) for scale in across]
        if levels:
            _fill_window(ax, grid, least)
            for lines in _level_lines(ax, grid, field, levels, colors="0.3", linewidths=0.6):
                ax.clabel(lines, fmt=number, fontsize=6)
        else:
            plane.colour_bar(ax, plane.fill_field(ax, field, *across, cmap="cividis"), "")
        for one, (colour, _) in zip(reserve, cycle(LOOKS), strict=False):
            for edge in _level_lines(ax, grid, one, [1], colors=colour):
                edge.set(path_effects=BEGINS_TO_FAIL)
    places = np.meshgrid(*(scale.places for scale in across))
    points = axes[0].plot(*map(np.ravel, places), **POINTS)
    style.legend(figure, [*_window_keys(found, reserve, least), *points], _about(found, reserve), 3)


def _open_window(ax, found, x, y, units):
    """As `plane.open_plane`, in other units, up to the outermost points."""
    across = plane.open_plane(ax, found, x, y)
    for which, scale in zip("xy", across, strict=True):
        unit, _ = units.get(scale.key, ("", 1.0))
        ends = scale.places[[0, -1]]
        ax.set(**{f"{which}lim": ends, f"{which}label": axis_label(scale.key, unit=unit)})
        if not scale.is_counted:
            tick(getattr(ax, f"{which}axis"), *ends, scale.is_log)
    return across


def _fill_window(ax, grid, least):
    """Fill what is met and what is not; what is neither stays hatched."""
    if np.isnan(least).any():
        ax.patch.set(**plane.ABSENT)
    ax.contourf(*grid, least, [0, 1, FAR], colors=[FAILING["color"], MEETING["color"]])


def _level_lines(ax, grid, field, levels, **look):
    """Contours at those levels that a field has, if it has any."""
    low, high = _ends(field)
    if within := [level for level in levels if low < level < high]:
        yield ax.contour(*grid, field, within, **look)


def _ends(field):
    """The least and the largest that is known."""
    return np.nanmin(field, initial=np.inf), np.nanmax(field, initial=-np.inf)


def _window_keys(found, reserve, least):
    """Keys of what a window shows: of requirements that begin to fail in it, and of colours."""
    known = least[np.isfinite(least)]
    for one, must, (colour, _) in zip(reserve, found.must_snap, cycle(LOOKS), strict=False):
        low, high = _ends(one)
        if low < 1 < high:
            label = _required(must.requirement.item(), must.item())
            yield Line2D([], [], color=colour, path_effects=BEGINS_TO_FAIL, label=label)
    if (known >= 1).any():
        yield Patch(**MEETING)
    if (known < 1).any():
        yield Patch(**FAILING)
    if known.size < least.size:
        yield Patch(facecolor="white", **plane.ABSENT, label="no device, or not known")


def _about(found, reserve):
    """What a window holds for, which requirements never end it, and how sure it is."""
    bar, off = (found.N_error / found.N_first).max(), found.reserve.attrs["off_between_points"]
    sure = f"error bars up to {percents(bar)}, between points up to {percents(off)} more"
    if "yield" in found:
        sure += f", shares within {percents(abs(found.yield_bound - found['yield']).max())}"
    words = [place_text(found)]
    if "temperatures" in found.attrs:
        low, *_, high = np.sort(found.attrs["temperatures"])
        words.append(f"at each temperature from {number(low)} to {number(high)} °C")
    everywhere = {"met": (reserve >= 1).all(axis=(1, 2)), "failed": (reserve < 1).all(axis=(1, 2))}
    for word, which in everywhere.items():
        if names := ", ".join(found.requirement.values[which]):
            words.append(style.literal(f"{word} everywhere: {names}"))
    words.append(f"ticks: where a requirement fails; {sure}")
    return "\n".join(textwrap.fill(line, style.PAGE) for line in words if line)
