"""Margins of required shocks."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from . import style
from .scales import tick_log

COLOURS = {"met": "C0", "unclear": "0.5", "failed": "#d55e00"}
MARKERS = {"met": "o", "unclear": "s", "failed": "X"}
BEYOND = 1.25
"""Room beyond the outermost margins, as a factor."""


def draw_margins(ax: Axes, verdicts: Sequence[Mapping]) -> Axes:
    """Draw the threshold over the required N of each verdict, with its bar; logarithmic.

    verdicts: rows of requirements.csv
    Shaded is where a requirement is met: above one if the shock must not trip, below if it must.
    """
    margins = [row["margin"] for row in verdicts]
    known = [margin for margin in margins if margin == margin]
    low, high = min([*known, 0.8]) / BEYOND, max([*known, 1.25]) * BEYOND
    ax.set(xscale="log", xlim=(low, high), ylim=(len(verdicts) - 0.5, -0.5))
    for place, (row, margin) in enumerate(zip(verdicts, margins, strict=True)):
        ends = (low, 1) if row["must_snap"] else (1, high)
        ax.fill_betweenx([place - 0.45, place + 0.45], *ends, color="0.93", linewidth=0)
        look = {"color": COLOURS[row["verdict"]], "marker": MARKERS[row["verdict"]]}
        if margin == margin:
            ax.errorbar(margin, place, xerr=row["margin_error"], **look)
        else:
            ax.annotate("snaps at no $N$ seen ", (high, place), ha="right", va="center", fontsize=6)
        if row["break_probability"] > 1 - row["must_survive"]:
            beside = margin if margin == margin else low
            ax.annotate("   the beam breaks", (beside, place), va="center", fontsize=6)
    ax.axvline(1, color="black", linewidth=0.6)
    ax.set_yticks(range(len(verdicts)), [_name(row) for row in verdicts])
    ax.tick_params(axis="y", which="minor", left=False)
    ax.set_xlabel("margin: threshold over required $N$")
    tick_log(ax.xaxis, (low, high), ax.bbox.width / ax.get_figure().dpi)
    kinds = [kind for kind in COLOURS if any(row["verdict"] == kind for row in verdicts)]
    keys = [
        Line2D([], [], linestyle="", color=COLOURS[kind], marker=MARKERS[kind], label=kind)
        for kind in kinds
    ]
    style.legend_below(ax, keys, "shaded: where the requirement is met", ncols=3)
    return ax


def _name(row):
    words = "trips" if row["must_snap"] else "does not trip"
    where = f"{row['device']}, " if row["device"] else ""
    return f"{style.literal(row['requirement'])}, {words}\n{where}$C$ = {row['C']:g}"
