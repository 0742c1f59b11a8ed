"""Shocks pointed out on a map: those that are required, and a user's own."""

from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..io.points import Point
from .curves import freeze
from .style import literal

MARK = {"markerfacecolor": "white", "markeredgecolor": "black", "markeredgewidth": 0.8}
POINT = {"marker": "D", "markersize": 4, "markeredgecolor": "black", "linestyle": ""}
TRIPPED = {True: "black", False: "white", None: "0.6"}
POINT_WORDS = {True: "own point, tripped", False: "own point, not tripped", None: "own point"}
PAPER = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.6}
NAME = {"xytext": (4, 3), "textcoords": "offset points", "fontsize": 5.5, "bbox": PAPER}
NAME |= {"annotation_clip": True}
NAMED = 12
"""Most points whose names are written beside them."""


def number_shocks(ax: Axes, x: str, shocks: Sequence[tuple[str, float, float]]) -> None:
    """Point out shocks, each its name, f0 (Hz) and N, by numbers in the order given."""
    freeze(ax)
    low, high = ax.get_ylim()
    for number, (_, f0, N) in enumerate(shocks, start=1):
        place = _place(x, f0)
        if low <= N <= high:
            ax.plot(place, N, "o", markersize=7, **MARK)
            ax.annotate(str(number), (place, N), ha="center", va="center", fontsize=5)


def draw_points(ax: Axes, x: str, points: Sequence[Point]) -> None:
    """Draw a user's own points, filled where the device tripped, hollow where it did not.

    Of a few the names are written beside them.
    """
    freeze(ax)
    for point in points:
        place = _place(x, point.f0), point.N
        ax.plot(*place, markerfacecolor=TRIPPED[point.snapped], **POINT)
        if point.name and len(points) <= NAMED:
            ax.annotate(literal(point.name), place, **NAME)


def point_keys(points: Sequence[Point]) -> list[Line2D]:
    """Keys of a legend for the kinds of points that there are."""
    kinds = [kind for kind in TRIPPED if any(point.snapped is kind for point in points)]
    return [
        Line2D([], [], markerfacecolor=TRIPPED[kind], **POINT, label=POINT_WORDS[kind])
        for kind in kinds
    ]


def _place(x, f0):
    return f0 if x == "f0" else 1e3 / f0
