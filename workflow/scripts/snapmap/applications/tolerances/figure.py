"""Figures of devices as made: probability of a snap, sensitivity of thresholds, and yield."""

import textwrap
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LinearSegmentedColormap

from ...figures import captions, scales, states, style
from ...figures.curves import LOOKS, STAYS, cross, each_line
from ...files.text import plain
from ...numerics.portable import evenly
from ...numerics.statistics import percents, scope, share_bounds
from ...study.study import ANY, SNAPS
from ..requirements.figure import WRONG, required_text
from ..requirements.summary import missing_fire

LINES = {0.01: ":", 0.1: "--", 0.5: "-", 0.9: "--", 0.99: ":"}
"""Dashes of the lines at which these shares of devices snap."""
SNAP = {"-": "half of the devices snap", "--": "10 and 90 % snap", ":": "1 and 99 % snap"}
NOMINAL = {"color": "#d55e00", "linewidth": 1.0, "linestyle": "-."}
NOMINAL["label"] = "threshold of the nominal device"
LATCHED = "#0072b2"
STAYED = {"color": LATCHED, "marker": ".", "linestyle": "", "clip_on": False}
STAYED["label"] = "share that stays snapped"
SNAPPED = "share of devices that snap at or below $N$"
STAYING = {0.5: "white", 0.99: LATCHED}
"""Colours of markers, by the share that stays in the second shape at this N and all above."""
SHARES = LinearSegmentedColormap.from_list("shares", [cell.colour for cell in states.SNAPS[:2]])
FIELD = {"cmap": SHARES, "vmin": 0, "vmax": 1, "edgecolors": "face", "rasterized": True}
"""Look of the field of shares, in the colours of cells that do not snap and that do."""
FIRST = {"linestyle": ":", "markerfacecolor": "white", "markeredgewidth": 0.5, "markersize": 2.5}
"""Look of first-order indices; total indices are solid."""
NAME = 24
"""Characters in a line of a requirement's name beside its shares."""
ROOM = 0.05
"""Margin of an axis over the range of its data."""
FIRE = {"color": "#7b1fa2", "linewidth": 1.2, "linestyle": (0, (4, 1.5))}
"""Look of the levels of no-fire and all-fire."""
BOUNDS = {"color": "#56b4e9", "alpha": 0.5, "linewidth": 0, "label": "bounds at 95 %"}
COLUMNS, MOST, DAMPINGS = 3, 12, 6
"""Most panels side by side, panels in a figure, and lines; of more, some are evenly chosen."""
ROW, FLAT = 2.6, 1.7
"""Height of a row of panels, and of histograms, in."""


def draw_stem(stem: str, data: xr.Dataset) -> None:
    """Draw and save probability, sensitivity or yield; the name of the file begins with it."""
    name = Path(stem).name
    if not name.startswith("yield"):
        draw = draw_probability if name.startswith("probability") else draw_sensitivity
        panels = [data.isel(C=i) for i in evenly(data.C.size, MOST)]
        _draw_panels(stem, panels, draw)
        return
    data = data.isel(C=evenly(data.C.size, DAMPINGS))
    panels = [
        data.isel(requirement=i, C=j)
        for i in evenly(data.requirement.size, MOST)
        for j in evenly(data.C.size, MOST // min(MOST, data.requirement.size))
    ]
    _draw_panels(stem, panels, draw_requirement, data)


def _draw_panels(stem, panels, draw, shares=None):
    """Draw panels, above them the yield if `shares` is not None, and their legend; save them."""
    dampings = len({panel.C.item() for panel in panels})
    columns = dampings if dampings in (2, COLUMNS) else min(COLUMNS, len(panels))
    rows = -(-len(panels) // columns)
    heights = [(ROW if shares is None else FLAT) * rows]
    if shares is not None:
        rows_above = len(list(each_share(shares))) * shares.C.size
        heights.insert(0, 0.5 + 0.17 * rows_above)
    with style.saved(stem, panels[0].attrs, 0.9 + sum(heights)) as figure:
        *above, lower = figure.subfigures(len(heights), height_ratios=heights, squeeze=False).flat
        axes = lower.subplots(rows, columns, squeeze=False).flat
        for ax, panel in zip(axes, panels, strict=False):
            draw(ax, panel)
        for ax in axes[len(panels) :]:
            ax.remove()
        if above:
            draw_yield(above[0].subplots(), shares)
        fields = [field for ax in lower.axes for field in ax.findobj(QuadMesh)]
        if fields:
            lower.colorbar(fields[0], ax=lower.axes, aspect=30, label=SNAPPED)
        style.legend(figure, style.labelled(figure.axes), batch_text(panels[0]))


def draw_probability(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the share of devices that snap up to N, over f0 and N, or over N alone at one f0.

    data: of one C; lines where 1, 10, 50, 90 and 99 % snap, and the nominal threshold
    """
    few = missing_fire(data.N_all_fire, data.bistable.size)
    words = f"all-fire {few}" if few else ""
    ax.set_title("\n".join(filter(None, [scales.place_text(data), words])))
    style.note_missing(ax, data.probability, "no share of devices is known")
    f0, N = scales.scale_of("f0", data.f0.values), scales.scale_of("N", data.N.values)
    if f0.values.size == 1:
        shares, ends = data.squeeze("f0"), N.values if np.ptp(N.values) else N.edges
        _draw_steps(ax, shares.N_first.values, ends[[0, -1]])
        ax.axvline(data.N_nominal.item(), **NOMINAL)
        for key in ("N_no_fire", "N_all_fire"):
            ax.axvline(data[key].item(), label=fire_words(data), **FIRE)
        if "latched" in data:
            ax.plot(N.values, shares.latched.values, **STAYED)
        ax.set(xlabel=scales.axis_label("N", data.attrs), ylabel=SNAPPED)
        ax.set(xlim=ends[[0, -1]], ylim=(0, 1))
        return ax
    scales.study_axis(ax, f0)
    scales.set_scale(ax, "y", N, data.attrs)
    scales.leave_space(ax, f0)
    ax.pcolormesh(f0.edges, N.edges, data.probability.transpose("N", "f0").values, **FIELD)
    for share, dashes in LINES.items():
        line = data.N_quantile.sel(quantile=share).values
        ax.plot(f0.values, line, color="black", linestyle=dashes, label=SNAP[dashes])
    ax.plot(f0.values, data.N_nominal.values, **NOMINAL)
    for key in ("N_no_fire", "N_all_fire"):
        ax.plot(f0.values, data[key].values, label=fire_words(data), **FIRE)
    for share, face in STAYING.items() if "latched" in data else ():
        stay = (data.latched >= share).transpose("f0", "N").values
        above = np.logical_and.accumulate(stay[:, ::-1], axis=1)[:, ::-1]
        line = np.where(above.any(axis=1), N.values[above.argmax(axis=1)], np.nan)
        look = {"color": LATCHED, "markerfacecolor": face, **STAYS}
        ax.plot(f0.values, line, label=f"{100 * share:g} % latched at all $N$ above", **look)
    return ax


def _draw_steps(ax, N_first, ends):
    """Draw the share of samples whose threshold is not above N, with its bounds, between two N."""
    known = np.sort(N_first[np.isfinite(N_first)])
    count = np.r_[0, 1 : known.size + 1, known.size]
    places = np.r_[min(ends[0], *known[:1]), known, max(ends[1], *known[-1:])]
    ax.fill_between(places, *share_bounds(count, N_first.size), step="post", **BOUNDS)
    ax.step(places, count / N_first.size, where="post", color="black")


def fire_words(data: xr.Dataset) -> str:
    """Write what the levels of no-fire and all-fire are, for a legend."""
    share, confidence = (data.N_all_fire.attrs[key] for key in ("share", "confidence"))
    ends = f"{plain(100 * (1 - share), 7)} and {plain(100 * share, 7)} % snap"
    return f"no-fire and all-fire: {ends}, sure at {plain(100 * confidence)} %"


def draw_sensitivity(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the Sobol indices of each value over f0, with their bounds; data: of one C."""
    ax.set_title(scales.place_text(data))
    f0 = scales.scale_of("f0", data.f0.values)
    scales.study_axis(ax, f0)
    scales.leave_space(ax, f0)
    for i, value in enumerate(data.value.values.tolist()):
        index, (colour, marker) = data.sel(value=value), LOOKS[i % len(LOOKS)]
        shares = index.sensitivity.clip(0, 1)  # as a share has no other values
        total, first = (shares.sel(order=order).values for order in ("total", "first"))
        bounds = index.sensitivity_bound.sel(order="total").transpose("bound", "f0").values
        low, high = np.clip(bounds, 0, 1)
        bars = {"yerr": np.maximum([total - low, high - total], 0), "elinewidth": 0.5}
        look = {"color": colour, "marker": marker}
        ax.errorbar(f0.places, total, markersize=3, label=words_of(value), **bars, **look)
        alone = "hollow: that value alone" if i == 0 else None
        ax.plot(f0.places, first, label=alone, **look, **FIRST)
    unknown = data.sensitivity.sel(order="total").isnull().all("value").values
    if not style.note_missing(ax, data.sensitivity, "few devices snap"):
        cross(ax, f0.places[unknown], 0.02, "0.4", "not known: few devices snap")
    ax.set(ylim=(-0.05, 1.05), ylabel="share of the variance of the threshold")
    return ax


def words_of(value: str) -> str:
    """Write the values that a draw changes: `thickness and depth`."""
    of_shock = {"N": "$N$ of the shock", "duration": "duration of the pulse"}
    return " and ".join(of_shock.get(key) or scales.WORDS[key] for key in value.split("+"))


def batch_text(data: xr.Dataset) -> str:
    """Write the number of devices and the model."""
    missing = int((data.bistable == 0).sum())
    lost = f", {missing} of them without a second stable shape" if missing else ""
    return f"{data.bistable.size} devices{lost}; {captions.case(data.attrs)}"


def draw_requirement(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the thresholds of the devices under one required pulse; the shade is where it fails.

    data: of one requirement and C
    """
    N_first, N = data.N_first_required.values, data.N_required.item()
    must = data.must_snap.item()
    known = N_first[np.isfinite(N_first)]
    ends = np.array([*known, N])
    room = ROOM * np.ptp(ends) or ROOM * N
    low, high = max(ends.min() - room, 0), ends.max() + room
    where = [scales.place_text(data.drop_vars("temperature"))]  # it is met at all of them
    if must != SNAPS[ANY]:
        where.append(f"met by {percents(data.share_meeting)}")
        ax.axvspan(*((N, high) if must else (low, N)), **WRONG)
    style.note_missing(ax, known, "no device has a threshold")
    ax.hist(known, bins="sqrt", color="#0072b2", alpha=0.8)
    ax.axvline(N, color="black", linewidth=0.8, label="required $N$")
    words = ", ".join(filter(None, where))
    ax.set_title(f"{required_text(data.requirement.item(), must)}\n{words}")
    label = f"threshold $N$ ({captions.multiples(data.attrs)})"
    ax.set(xlim=(low, high), xlabel=label, ylabel="devices")
    ax.locator_params(axis="y", integer=True)
    scales.tick(ax.xaxis, low, high, is_log=False)
    return ax


def each_share(data: xr.Dataset) -> Iterator[tuple[str, xr.DataArray, xr.DataArray]]:
    """Yield name, share and bounds of each requirement, of its unbroken beams, and of all."""
    for name in data.requirement.values.tolist():
        required = data.sel(requirement=name)
        if required.must_snap != SNAPS[ANY]:
            yield name, required.share_meeting, required.share_meeting_bound
        if "share_breaking" in data:
            bounds = 1 - required.share_breaking_bound.isel(bound=slice(None, None, -1))
            yield f"{name}, unbroken", 1 - required.share_breaking, bounds
    yield "all together", data["yield"], data.yield_bound


def draw_yield(ax: Axes, data: xr.Dataset) -> Axes:
    """Draw the shares of devices that meet each requirement, and all of them, with bounds.

    data: over requirements and C
    """
    names, shares, bounds = zip(*each_share(data), strict=True)
    shares = np.stack(shares)
    bounds = np.stack([ends.transpose("bound", "C") for ends in bounds], axis=1)
    rows = np.arange(len(names))
    for i, (line, colour, marker) in enumerate(each_line(data, "C")):
        y = rows + 0.7 * ((i + 0.5) / data.C.size - 0.5)
        error = abs(bounds[:, :, i] - shares[:, i])
        look = {"color": colour, "marker": marker, "linestyle": ""}
        label = scales.value_text("C", line.C.item(), scales.unit_of("C", line.C.attrs))
        ax.errorbar(shares[:, i], y, xerr=error, label=label, **look)
        for at, share, ends in zip(y, shares[:, i], bounds[:, :, i].T, strict=True):
            style.annotate_row(ax, at, f"{percents(share)} ({percents(*ends)})")
    ax.axhline(rows[-1] - 0.5, color="0.6", linewidth=0.5)
    label = "share of devices that meet it"
    if counted := scope(data["yield"]).removeprefix(", "):
        label += f"; all together: {counted}"
    least = np.nanmin(bounds, initial=1.0)
    room = ROOM * (1 - least) or ROOM
    ax.set(xlim=(least - room, 1 + room), ylim=(rows[-1] + 0.5, -0.5))
    style.note_missing(ax, shares, "no share of devices is known")
    ax.set_xlabel(textwrap.fill(label, captions.PAGE))
    ax.set_yticks(rows, [textwrap.fill(captions.literal(name), NAME) for name in names])
    ax.tick_params(axis="y", which="minor", left=False)
    return ax
