"""Simulated thresholds over f0, the three laws, and where each holds to 1 %."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...figures import captions, curves, scales, style
from ...figures.thresholds import NONE_KNOWN
from ...thresholds.slow import HOLDS

DASHES = {"law of the dwell time, and half of it": "--", "law of the velocity change": ":"}
SADDLES = {"saddle with $r < 0$": "-", "saddle with $r > 0$": "-."}
DELAYS = "snap_scale", "dwell", "saddle_scale"
HOLDING = {"linewidth": 4, "alpha": 0.3, "solid_capstyle": "butt", "zorder": 1}
THIN = {"color": "0.4", "linewidth": 0.8}


def draw(figure: Figure, laws: xr.Dataset) -> None:
    """Draw thresholds over f0, and below the delay of snaps near them; laws where they hold."""
    laws = curves.some_lines(laws, "f0", "C")
    top, below = figure.subplots(2, sharex=True, height_ratios=[3, 2])
    scales.study_axis(top, scale := scales.scale_of("f0", laws.f0.values))
    scales.leave_space(top, scale)
    for curve, colour, marker in curves.each_line(laws, "C"):
        look = {"color": colour, "linestyle": "", "marker": marker, "markersize": 3}
        top.plot(scale.places, curve.N_first, **look)
        below.plot(scale.places, curve.snap_scale, **look)
        if _holding(curve.N_slow, curve).notnull().any():
            below.axhline(curve.dwell.item() / 2, **THIN | {"color": colour}, linestyle="--")
        for law, dashes in zip((curve.N_slow, curve.N_short), DASHES.values(), strict=True):
            holds = _holding(law, curve).notnull()
            left, right = (holds.shift(f0=by, fill_value=False) for by in (-1, 1))
            beside = holds | left | right
            look = THIN | {"color": colour, "linestyle": dashes}
            top.plot(scale.places, law.where(beside), **look)
            top.plot(scale.places, law.where(holds), color=colour, **HOLDING)
    for delay, dashes in zip(laws.saddle_scale.values, SADDLES.values(), strict=True):
        below.axhline(delay, linestyle=dashes, **THIN)
    held = [_holding(law, laws) for law in (laws.N_slow, laws.N_short)]
    lines = *held, *laws.saddle_scale.values
    looks = {
        words: THIN | {"linestyle": dashes}
        for (words, dashes), line in zip((DASHES | SADDLES).items(), lines, strict=True)
        if np.isfinite(line).any()
    }
    if any(np.isfinite(law).any() for law in held):
        looks["holds to 1 %"] = HOLDING | {"color": "0.4"}
    keys = [Line2D([], [], label=words, **look) for words, look in looks.items()]
    top.set(yscale="log", ylabel=scales.axis_label("N", laws.attrs))
    if not style.note_missing(top, laws.N_first, NONE_KNOWN):
        top.set_ylim(laws.N_first.min().item() / 1.2, laws.N_first.max().item() * 1.2)
    delays = np.concatenate([laws[key].values.ravel() for key in DELAYS])
    obstacle = laws.dwell.attrs["missing_as"]
    style.note_missing(below, delays, obstacle)
    below.set(xlabel=top.get_xlabel(), yscale="log", ylabel="delay per factor e (µs)")
    top.set_xlabel("")
    for ax in (top, below):
        scales.tick(ax.yaxis, *ax.get_ylim())
    place = scales.place_text(laws, captions.PAGE)
    missing = obstacle and f"no law of slow shocks: {obstacle}"
    words = "\n".join(filter(None, [place, captions.case(laws.attrs), missing]))
    style.legend(figure, [*curves.line_keys(laws, "C"), *keys], words, 3)


def _holding(law, thresholds):
    """Give the amplitudes of a law where it is within HOLDS of the threshold; NaN elsewhere."""
    return law.where(abs(law / thresholds.N_first - 1) <= HOLDS)
