"""The time history of one cell: deflection and mass, contact force, acceleration of the frame."""

import json
import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from .style import typeset

BEAM, MASS, FORCE, AID = "C5", "C1", "C0", "0.45"


def draw_history(
    axes: Sequence[Axes], history: xr.Dataset, second_equilibrium: float, gravity: float
) -> Sequence[Axes]:
    """Draw w(L/2) and z_M, the contact force and the acceleration on three axes over time in ms.

    second_equilibrium: of the midpoint, um; gravity: um/us^2
    """
    positions, force, shock = axes
    time = history.time / 1e3
    _draw_positions(positions, time, history, second_equilibrium)
    force.plot(time, history.contact_force, color=FORCE, linewidth=0.5)
    force.set_ylabel("contact force (µN)")
    shock.plot(time, history.acceleration / gravity, color=FORCE)
    shock.set_ylabel("acceleration\n(multiples of $g$)")
    shock.set_xlabel("time after the start of the pulse (ms)")
    _mark_snap(axes, snap_time(history, second_equilibrium) / 1e3, second_equilibrium)
    for ax in axes:
        ax.margins(x=0)
    positions.figure.align_ylabels(axes)
    _draw_legend(positions, history)
    return axes


def snap_time(history: xr.Dataset, second_equilibrium: float) -> float:
    """First arrival of the midpoint at the second equilibrium (um), us; NaN if not seen."""
    time, w = history.time.values, history.w_mid.values
    arrived = np.flatnonzero(w <= second_equilibrium)
    if arrived.size == 0:
        return math.nan
    after, before = arrived[0], arrived[0] - 1
    return float(np.interp(second_equilibrium, w[[after, before]], time[[after, before]]))


def _draw_positions(ax, time, history, second_equilibrium):
    ax.plot(time, history.w_mid, color=BEAM, linewidth=0.5, label="midpoint of the beam $w(L/2)$")
    ax.plot(time, history.z_mass, color=MASS, label="mass $z_M$")
    ax.axhline(second_equilibrium, color=AID, linestyle="--", label="second equilibrium $w_2$")
    ax.set_ylabel("position (µm)")


def _mark_snap(axes, time, second_equilibrium):
    if math.isnan(time):
        return
    for ax in axes:
        ax.axvline(time, color=AID, linestyle=":")
    label = f"snap at {time:.4g} ms"
    axes[0].plot(time, second_equilibrium, "o", color="black", linestyle="", label=label)


def _draw_legend(ax, history):
    ax.legend(
        title=_caption(history),
        alignment="left",
        loc="lower left",
        bbox_to_anchor=(0, 1.03),
        ncols=4,
    )


def _caption(history):
    settings = json.loads(history.attrs.get("config", "{}"))
    if "cell" not in settings:
        return None
    N, f0, C = (settings["cell"][key] for key in ("N", "f0", "C"))
    damping = f"$C$ = {C:g} {typeset('uN us um-1')}"
    return f"$N$ = {N:g}, $f_0$ = {f0:g} Hz, {damping}, {settings['model']['name']} model"
