"""Where axes stand in a figure for print: boxes of one size, whatever is written around them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import style

BOX = 2.62, 1.9
"""Width and height of the only box of a figure, in."""
LEFT, RIGHT, GAP, PAD = 0.56, 0.22, 0.3, 0.04
"""Room for the labels of y, for half a tick label, between columns, and about all; in."""
LOWER = 0.72
"""Height over width of boxes side by side."""
COLUMNS = {1: 1, 2: 2, 3: 3, 4: 2, 5: 3, 6: 3, 9: 3}
MOST_COLUMNS = 4
"""Columns by the number of boxes, and of all other numbers."""
TITLE = 0.3
"""Room between rows for titles of one line; in."""


def single_box() -> Axes:
    """Make a figure as wide as one column of a journal, with axes of one size; `trim` ends it."""
    figure = style.single_column(height=4.5)
    figure.set_layout_engine("none")
    return _add_box(figure, LEFT, 1.5, *BOX)


def boxes(figure: Figure, number: int, lines: int = 1) -> np.ndarray:
    """Set axes of one size in rows and columns on an empty figure; `trim` ends it.

    lines: of each title
    Returns them as an array; those that nothing is drawn on are not there, but None.
    """
    figure.set_layout_engine("none")
    columns = COLUMNS.get(number, MOST_COLUMNS)
    rows = -(-number // columns)
    room = figure.get_figwidth() - LEFT - RIGHT - (columns - 1) * GAP
    width = min(room / columns, 3.1)
    height, apart = LOWER * width, TITLE + 0.12 * (lines - 1)
    figure.set_figheight(2.5 + rows * (height + apart))
    axes = np.full((rows, columns), None)
    for place in range(number):
        row, column = divmod(place, columns)
        left, low = LEFT + column * (width + GAP), 1.5 + (rows - 1 - row) * (height + apart)
        axes[row, column] = _add_box(figure, left, low, width, height)
    return axes


def trim(figure: Figure) -> None:
    """Make a figure as high as what is drawn on it; the axes keep their size."""
    width, before = figure.get_size_inches()
    drawn = figure.get_tightbbox()
    low, height = drawn.y0 - PAD, drawn.height + 2 * PAD
    for ax in figure.axes:
        box = ax.get_position(original=True)
        bottom = (box.y0 * before - low) / height
        ax.set_position([box.x0, bottom, box.width, box.height * before / height])
    figure.set_size_inches(width, height)


def _add_box(figure, left, low, width, height):
    whole, high = figure.get_size_inches()
    return figure.add_axes([left / whole, low / high, width / whole, height / high])
