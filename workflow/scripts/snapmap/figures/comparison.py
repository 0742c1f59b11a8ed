"""Thresholds of several studies in one figure."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from . import style
from .curves import (
    LIMITS,
    LOOKS,
    curve_keys,
    draw_curve,
    draw_impulsive,
    draw_static,
    limit_key,
    mark_missing,
    missing_keys,
)
from .scales import amplitude_axis, end_at_ticks, frequency_axis, value_text

CLOSE = 1e-9
"""Relative difference below which two values of C are the same."""


def plot_thresholds(studies: Mapping[str, xr.Dataset], ax: Axes | None = None) -> Axes:
    """Draw the thresholds of several studies over f0 in one figure, each under its name.

    studies: thresholds over C and f0 by name, as from `threshold` or threshold.nc; of several
        values of C those that all studies have are drawn

    >>> device = snapmap.load_device("config/config.yaml")
    >>> cheap = {"model": "cosines", "modes": 3, "horizon": 300.0}
    >>> few = snapmap.threshold(device, [1000.0, 3000.0], [25.0], **cheap)
    >>> hard = snapmap.threshold(device, [1000.0, 3000.0], [25.0], pulse="half sine", **cheap)
    >>> ax = snapmap.plot_thresholds({"versed sine": few, "half sine": hard})
    >>> [text.get_text() for text in ax.get_legend().get_texts()][:2]
    ['versed sine', 'half sine']
    """
    shared = _shared_C(studies)
    ax = ax or style.notebook_axes()
    f0 = np.concatenate([found.f0.values for found in studies.values()])
    frequency_axis(ax, np.unique(f0))
    amplitude_axis(ax)
    lines = [
        (f"{name}{words}", found.isel(C=place).sortby("f0"))
        for name, found in studies.items()
        for place, words in zip(shared[name], _words(studies, shared), strict=True)
    ]
    looks = [LOOKS[i % len(LOOKS)] for i in range(len(lines))]
    for place, ((_, found), (colour, marker)) in enumerate(zip(lines, looks, strict=True)):
        draw_curve(ax, found.f0.values, found, colour, marker)
        mark_missing(ax, found.f0.values, found, colour, place)
    firsts = {found.N_static.item(): place for place, (_, found) in reversed([*enumerate(lines)])}
    for place in firsts.values():
        draw_static(ax, lines[place][1], "f0", looks[place][0], place)
    end_at_ticks(ax.yaxis)
    for place, ((_, found), (colour, _)) in enumerate(zip(lines, looks, strict=True)):
        draw_impulsive(ax, found, colour, place)
    _draw_legend(ax, lines, looks)
    return ax


def _shared_C(studies):
    """The places on C, by study, of the values that all have; or of the only one of each."""
    if not studies:
        raise ValueError("studies: none; give thresholds by name")
    for name, found in studies.items():
        several = [key for key in found.N_first.dims if key not in ("C", "f0")]
        if several:
            key = several[0]
            raise ValueError(f"{name}: is over {key}, too; choose one, as found.isel({key}=0)")
    values = {name: np.atleast_1d(found.C.values) for name, found in studies.items()}
    if all(one.size == 1 for one in values.values()):
        return {name: [0] for name in studies}
    first, *others = values.values()
    shared = [
        C for C in first if all(np.isclose(C, one, rtol=CLOSE, atol=0).any() for one in others)
    ]
    if not shared:
        raise ValueError("studies: no value of C is in all of them; choose one of each")
    return {name: [int(np.argmin(abs(one - C))) for C in shared] for name, one in values.items()}


def _words(studies, shared):
    """What stands behind the name of a study for each value of C, if there are several."""
    name, found = next(iter(studies.items()))
    if len(shared[name]) == 1:
        return [""]
    return [", " + value_text("C", np.atleast_1d(found.C.values)[i]) for i in shared[name]]


def _draw_legend(ax, lines, looks):
    keys = [
        Line2D([], [], color=colour, marker=marker, label=name)
        for (name, _), (colour, marker) in zip(lines, looks, strict=True)
    ]
    ways = {
        key.get_label(): key
        for _, found in lines
        for key in [*curve_keys(found, "0.4", "o"), *missing_keys(found)]
    }
    style.legend_below(ax, [*keys, *ways.values(), limit_key(LIMITS)], "", ncols=2)
