"""Shocks pointed out on a map: those that are required, and a user's own."""

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..io.tables import Point
from .curves import freeze
from .scales import value_text
from .style import COLUMN, literal

RING = {"boxstyle": "circle,pad=0.25", "facecolor": "white", "linewidth": 0.8}
ARROW = {"arrowstyle": "-|>,head_length=0.3,head_width=0.15", "facecolor": "black"}
ARROW |= {"linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
NUMBER = {"fontsize": 5, "ha": "center", "va": "center", "bbox": RING, "arrowprops": ARROW}
NUMBER |= {"textcoords": "offset points"}
INWARD = 12
"""How far from an edge the number of a shock beyond it stands, pt."""
POINT = {"marker": "D", "markersize": 4, "markeredgecolor": "black", "linestyle": ""}
TRIPPED = {True: "black", False: "white", None: "0.6"}
POINT_WORDS = {True: "own point, tripped", False: "own point, not tripped", None: "own point"}
PAPER = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.6}
NAME = {"xytext": (4, 3), "textcoords": "offset points", "fontsize": 5.5, "bbox": PAPER}
NAME |= {"annotation_clip": True}
NAMED = 12
"""Most points whose names are written beside them."""


def number_shocks(ax: Axes, x: str, shocks: Sequence[tuple[str, float, float, bool]]) -> list[str]:
    """Point out shocks by numbers in the order given, by arrows at the edge what lies beyond it.

    shocks: name, f0 (Hz), N, and whether it has the map's pulse; what has not is but named
    Returns lines that name them.
    """
    freeze(ax)
    lines, others = [], []
    for number, (name, f0, N, is_of_map) in enumerate(shocks, start=1):
        name = f"{number}:\u00a0{literal(name)}"
        if not is_of_map:
            others.append(name)
            continue
        place = np.array([_place(x, f0), N])
        low, high = np.transpose([ax.get_xlim(), ax.get_ylim()])
        inside = np.clip(place, low, high)
        inward = {"xytext": INWARD * np.sign(inside - place)}
        ax.annotate(str(number), inside, **inward, **NUMBER)
        beyond = f" at {value_text('N', N)}, {value_text('f0', f0)}"
        lines.append(name + beyond * bool((place != inside).any()))
    others = ["of another shape or direction: " + ", ".join(others)] if others else []
    return [*lines, *(textwrap.fill(line, COLUMN) for line in others)]


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
