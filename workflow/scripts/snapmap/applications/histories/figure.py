"""The time history of one cell: deflection and mass, contact force, acceleration of the frame."""

import math
from collections.abc import Sequence

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...figures import captions, style
from ...figures.scales import number, place_text

BEAM, MASS, AID = style.BLUE, "black", "0.3"
FINE = 0.5
"""Width of lines that oscillate fast, pt."""


def draw(figure: Figure, history: xr.Dataset) -> None:
    """Draw a history on an empty figure."""
    draw_history(figure.subplots(3, sharex=True, height_ratios=[2, 1, 1]), history)


def draw_history(axes: Sequence[Axes], history: xr.Dataset) -> Sequence[Axes]:
    """Draw w(L/2) and z_M, the contact force and the pulse on three axes over time in ms."""
    positions, force, shock = axes
    time, second = history.time / 1e3, history.second_equilibrium.item()
    beam = {"color": BEAM, "linewidth": FINE, "label": "midpoint of the beam $w(L/2)$"}
    positions.plot(time, history.w_mid, **beam)
    if history.z_mass.notnull().any():
        positions.plot(time, history.z_mass, color=MASS, label="mass $z_M$")
    look = {"color": AID, "linestyle": "--", "label": "second shape at rest $w_2$"}
    positions.axhline(second, **look)
    if "contact_at" in history:
        look = {"color": BEAM, "linestyle": ":", "label": "electrode"}
        positions.axhline(history.contact_at, **look)
    stops = [history[key] for key in ("stop_toward", "stop_away") if key in history]
    for stop, label in zip(stops, ["stop of the mass", None], strict=False):
        positions.axhline(stop, color=MASS, linestyle="-.", linewidth=FINE, label=label)
    positions.set_ylabel("position (µm)")
    force.plot(time, history.contact_force, color=MASS, linewidth=FINE)
    force.set_ylabel("contact\nforce (µN)")
    if "midpoint_force" in history:
        shock.plot(time, history.midpoint_force, color=MASS)
        shock.set_ylabel("force on the\nmidpoint (µN)")
    else:
        shock.plot(time, history.acceleration / history.gravity, color=MASS)
        shock.set_ylabel(f"acceleration\n({captions.multiples(history.attrs)})")
    shock.set_xlabel("time (ms)")
    snap = history.t_snap.item() / 1e3
    shown = history.w_mid, history.contact_force, shock.lines[0].get_ydata()
    for ax, values in zip(axes, shown, strict=True):
        style.note_missing(ax, values, "the run failed")
        ax.margins(x=0)
        if not math.isnan(snap):
            ax.axvline(snap, color=AID, linestyle=":")
    if not math.isnan(snap):
        dot = {"linestyle": "", "marker": "o", "color": "black", "markeredgecolor": "white"}
        at = history.get("first_equilibrium", second)
        positions.plot(snap, at, **dot, label=f"snap at {snap:.4g} ms")
    positions.figure.align_ylabels(axes)
    style.legend(positions, positions.get_legend_handles_labels()[0], _caption(history), 5)
    return axes


def _caption(history):
    """The shock, the model and, if known, the errors that the time step makes."""
    case = captions.case(history.attrs, captions.PAGE)
    words = "\n".join(filter(None, [place_text(history, captions.PAGE), case]))
    work, snap = (history[key].item() for key in ("work_error", "t_snap_error"))
    if math.isnan(work):
        return words
    words += f"\nerror by the time step: {number(100 * work, 2)} % of the work of the pulse"
    return words if math.isnan(snap) else f"{words}, {number(snap, 2)} µs of the time of snap"
