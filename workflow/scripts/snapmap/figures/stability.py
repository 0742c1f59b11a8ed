"""Hard cases at a glance: the verdict on every case and step, one panel for each model."""

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

COLOURS = {
    "sound": "#e3eef6",
    "sensitive": "#a5c8e1",
    "shifted": "#f0d060",
    "unchecked": "#c4c4c4",
    "caught": "#dd7f35",
    "unseen": "#000000",
    "refused": "#ffffff",
    "left_out": "#ffffff",
}
WORDS = {
    "sound": "sound: as with fine steps",
    "sensitive": "believed, but fine runs differ among themselves",
    "shifted": "outcome sound, time of snap off by more than 2 %",
    "unchecked": "believed, not compared with fine steps",
    "caught": "caught: the energy ledger of a cell does not close",
    "unseen": "unseen: believed and wrong",
    "refused": "r: refused by the model",
    "left_out": "–: left out, too long to run",
}
READING = (
    "number: decimal exponent of the largest energy error of the case's cells, ∞ for a blow-up\n"
    "default: the model's own step, halved where a ledger does not close"
)
COLUMNS = 4
"""Panels side by side."""
LEGEND, PANEL = 1.6, 2.0
"""Heights of the legend with the ticks, and of a row of panels, in."""
GAP = 0.4
"""Between the columns of the steps and that of the default step, in columns."""


def height(cases: xr.Dataset) -> float:
    """How high a figure of so many panels is to be, in."""
    return LEGEND + PANEL * int(np.ceil(cases.sizes["model"] / COLUMNS))


def draw_panels(figure: Figure, cases: xr.Dataset) -> np.ndarray:
    """Draw a panel for each model on an empty figure, and the legend; returns the axes."""
    models = cases.model.values
    rows = int(np.ceil(models.size / COLUMNS))
    axes = figure.subplots(rows, COLUMNS, sharex=True, sharey=True, squeeze=False)
    for ax in axes.flat[models.size :]:
        ax.set_axis_off()
    for ax, model in zip(axes.flat, models, strict=False):
        draw_panel(ax, cases.sel(model=model))
        ax.set_title("\n".join(model.rsplit(", ", 1)))
    for ax in axes[-1]:
        ax.set_xlabel("step / limit")
    figure.legend(handles=_patches(cases), ncols=2, title=READING, loc="outside lower center")
    return axes


def draw_panel(ax: Axes, cases: xr.Dataset) -> Axes:
    """Draw one model's verdicts over steps and cases, with the exponents of the energy errors.

    The last column is what a sweep gives: the default step, halved where a ledger does not close.
    """
    steps = np.arange(cases.step.size)
    default = cases.step.size + GAP
    _draw_cells(ax, steps, cases.verdict, cases.energy_error)
    _draw_cells(ax, [default], *(cases[f"default_{key}"] for key in ("verdict", "energy_error")))
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
    ax.pcolormesh(
        columns[0] - 0.5 + np.arange(len(columns) + 1),
        np.arange(len(verdict) + 1) - 0.5,
        verdict,
        cmap=ListedColormap(list(COLOURS.values())),
        norm=BoundaryNorm(np.arange(len(COLOURS) + 1) - 0.5, len(COLOURS)),
        edgecolors="white",
        linewidth=0.4,
    )
    for (row, column), code in np.ndenumerate(verdict):
        name = list(COLOURS)[code]
        colour = "white" if name == "unseen" else "black"
        words = {"refused": "r", "left_out": "–"}.get(name) or exponent(error[row, column])
        place = columns[column], row
        ax.text(*place, words, size=4.5, color=colour, ha="center", va="center_baseline")


def exponent(error: float) -> str:
    """Decimal exponent of an energy error, rounded up; the signs of infinity and 0 as they are."""
    if error == 0:
        return "0"
    return f"{int(np.ceil(np.log10(error)))}".replace("-", "−") if np.isfinite(error) else "∞"


def _patches(cases):
    """A labelled patch for each verdict that is there."""
    present = np.union1d(cases.verdict, cases.default_verdict)
    return [
        Patch(facecolor=colour, edgecolor="black", label=WORDS[name])
        for code, (name, colour) in enumerate(COLOURS.items())
        if code in present
    ]
