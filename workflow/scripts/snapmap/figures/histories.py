"""The time history of one cell: deflection and mass, contact force, acceleration of the frame."""

import json
import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from . import style
from .scales import value_text

BEAM, MASS, FORCE, AID = "C5", "black", "black", "0.3"
FINE = 0.5  # pt, for what oscillates fast


def draw_history(axes: Sequence[Axes], history: xr.Dataset) -> Sequence[Axes]:
    """Draw w(L/2) and z_M, the contact force and the pulse on three axes over time in ms."""
    positions, force, shock = axes
    time = history.time / 1e3
    _draw_positions(positions, time, history)
    force.plot(time, history.contact_force, color=FORCE, linewidth=FINE)
    force.set_ylabel("contact force (µN)")
    if "midpoint_force" in history:
        shock.plot(time, history.midpoint_force, color=FORCE)
        shock.set_ylabel("force on the\nmidpoint (µN)")
    else:
        shock.plot(time, history.acceleration / history.gravity, color=FORCE)
        shock.set_ylabel("acceleration\n(multiples of $g$)")
    shock.set_xlabel("time after the start of the pulse (ms)")
    _mark_snap(axes, history)
    for ax in axes:
        ax.margins(x=0)
    positions.figure.align_ylabels(axes)
    _draw_legend(positions, history)
    return axes


def snap_time(history: xr.Dataset) -> float:
    """First arrival of the midpoint at the second equilibrium, us; NaN if not seen."""
    time, w = history.time.values, history.w_mid.values
    arrived = np.flatnonzero(w <= history.second_equilibrium)
    if arrived.size == 0:
        return math.nan
    around = [arrived[0], arrived[0] - 1]
    return float(np.interp(history.second_equilibrium, w[around], time[around]))


def _draw_positions(ax, time, history):
    beam = {"color": BEAM, "linewidth": FINE, "label": "midpoint of the beam $w(L/2)$"}
    ax.plot(time, history.w_mid, **beam)
    if history.z_mass.notnull().any():
        ax.plot(time, history.z_mass, color=MASS, label="mass $z_M$")
    second = {"color": AID, "linestyle": "--", "label": "second equilibrium $w_2$"}
    ax.axhline(history.second_equilibrium, **second)
    places = [history.attrs[key] for key in ("stop_toward", "stop_away") if key in history.attrs]
    for place, label in zip(places, ["stop of the mass", None], strict=False):
        ax.axhline(place, color=MASS, linestyle="-.", linewidth=FINE, label=label)
    ax.set_ylabel("position (µm)")


def _mark_snap(axes, history):
    time = snap_time(history) / 1e3
    if math.isnan(time):
        return
    for ax in axes:
        ax.axvline(time, color=AID, linestyle=":")
    dot = {"linestyle": "", "marker": "o", "color": "black", "markeredgecolor": "white"}
    label = f"snap at {time:.4g} ms"
    axes[0].plot(time, history.second_equilibrium, **dot, label=label)


def _draw_legend(ax, history):
    ax.legend(
        title=_caption(history),
        alignment="left",
        loc="lower left",
        bbox_to_anchor=(0, 1.03),
        ncols=4,
    )


def _caption(history):
    if "config" not in history.attrs:
        return None
    model = style.model_words(json.loads(history.attrs["config"]))
    shock = (value_text(key, history.attrs[key]) for key in ("N", "f0", "C"))
    return "\n".join([", ".join([*shock, model]), *_with_another_step(history)])


def _with_another_step(history):
    """A line on how far a run with another step goes apart, if its work is known."""
    work, snap = (history.attrs.get(key, math.nan) for key in ("work_error", "t_snap_error"))
    if math.isnan(work):
        return []
    told = f"with another step (an indicator) the work of the pulse differs by {100 * work:.2g} %"
    return [told if math.isnan(snap) else f"{told}, the time of snap by {snap:.2g} µs"]
