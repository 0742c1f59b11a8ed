"""Hard cases at a glance: the verdict on every case and step, one panel for each model."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from snapmap.figures import style

LOOKS = {
    "sound": ("#e3eef6", "sound: as with fine steps"),
    "sensitive": ("#a5c8e1", "believed, but fine runs differ among themselves"),
    "shifted": ("#f0d060", "outcome sound, time of snap off by more than 2 %"),
    "unchecked": ("#c4c4c4", "believed, not compared with fine steps"),
    "caught": ("#dd7f35", "caught: the energy ledger of a cell does not close"),
    "unseen": ("#000000", "unseen: believed and wrong"),
    "refused": ("#ffffff", "r: refused by the model"),
    "left_out": ("#ffffff", "–: left out, too long to run"),
}
"""Colour and words of each verdict, in the order of the codes."""
READING = (
    "number: decimal exponent of the largest energy error of the case's cells, ∞ for a blow-up\n"
    "default: the model's own step, halved where a ledger does not close"
)
COLUMNS = 4
"""Panels side by side."""
LEGEND, PANEL = 1.6, 2.0
"""Height of the legend with the ticks, and of a row of panels, in."""
GAP = 0.4
"""Gap between the columns of the steps and that of the default step, in columns."""


def draw_panels(figure: Figure, cases: xr.Dataset) -> np.ndarray:
    """Draw a panel for each model on an empty figure, and set its height; returns the axes."""
    models = cases.model.values.tolist()
    rows = -(-len(models) // COLUMNS)
    figure.set_figheight(LEGEND + PANEL * rows)
    axes = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False)
    for ax in axes.flat[len(models) :]:
        ax.set_axis_off()
    for ax, model in zip(axes.flat, models, strict=False):
        draw_panel(ax, cases.sel(model=model))
        ax.set_title("\n".join(model.rsplit(", ", 1)))
    for ax in axes[-1]:
        ax.set_xlabel("step / limit")
    present = np.union1d(cases.verdict, cases.default_verdict)
    looks = [look for code, look in enumerate(LOOKS.values()) if code in present]
    keys = [Patch(facecolor=colour, edgecolor="black", label=words) for colour, words in looks]
    style.legend(figure, keys, READING, 2)
    return axes


def draw_panel(ax: Axes, cases: xr.Dataset) -> Axes:
    """Draw one model's verdicts over steps and cases, with the exponents of the energy errors.

    The last column is a sweep: it takes the default step, and halves it if a ledger does not close.
    """
    steps, default = np.arange(cases.step.size), cases.step.size + GAP
    _draw_cells(ax, steps, cases.verdict, cases.energy_error)
    _draw_cells(ax, [default], cases.default_verdict, cases.default_energy_error)
    ax.set_xticks([*steps, default], [*(f"{step:g}" for step in cases.step.values), "default"])
    ax.set_yticks(np.arange(cases.case.size), cases.case.values)
    ax.tick_params(axis="x", rotation=90)
    ax.tick_params(which="both", length=0)
    ax.minorticks_off()
    ax.spines[:].set_visible(False)
    ax.set_ylim(cases.case.size - 0.5, -0.5)
    return ax


def _draw_cells(ax, columns, verdict, error):
    verdict, error = (values.values.reshape(-1, len(columns)) for values in (verdict, error))
    colours = ListedColormap([colour for colour, _ in LOOKS.values()])
    look = {"cmap": colours, "norm": BoundaryNorm(np.arange(colours.N + 1) - 0.5, colours.N)}
    look |= {"edgecolors": "white", "linewidth": 0.4}
    ax.pcolormesh(columns, np.arange(len(verdict)), verdict, shading="nearest", **look)
    for (row, column), code in np.ndenumerate(verdict):
        name = list(LOOKS)[code]
        words = {"refused": "r", "left_out": "–"}.get(name) or exponent(error[row, column])
        look = {"color": "white" if name == "unseen" else "black", "size": 4.5}
        ax.text(columns[column], row, words, ha="center", va="center_baseline", **look)


def exponent(error: float) -> str:
    """Write the decimal exponent of an energy error, rounded up; ∞ and 0 as they are."""
    if error == 0:
        return "0"
    return f"{int(np.ceil(np.log10(error)))}".replace("-", "−") if np.isfinite(error) else "∞"
