"""The style of all figures for print: sheet, sizes, legends, and how they are saved."""

import re
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from copy import copy
from io import BytesIO
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import Collection
from matplotlib.container import Container
from matplotlib.figure import Figure, FigureBase
from matplotlib.font_manager import FontProperties
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike

from ..files.atomic import replacing

SIGN = 0.62
"""Width of a sign over the size of its font, on average, with some room to spare."""
SMALLEST, FEWEST = 6.0, 8
"""Least size of letters that is chosen, pt, and fewest signs in a line of a label."""
HARDLY = 0.8
"""Share of their size to which letters of a legend shrink, rather than a column is lost."""
WIDEST, HIGHEST = 0.6, 0.5
"""Largest share of a user's own axes for a legend, if its letters need not be too small for it."""
ORANGE, SKY, GREEN, BLUE = "#e69f00", "#56b4e9", "#009e73", "#0072b2"
VERMILION, PINK = "#d55e00", "#cc79a7"
"""Colours of Okabe and Ito, which the colour-blind tell apart, whatever a user's own are."""
SPECIAL = re.compile(r"(?<!\\)[%&#]")
"""Signs that LaTeX needs escaped; matplotlib itself escapes an underscore."""
DPI = 300
"""Resolution of PNG, and of rasters in PDF."""
NOTHING = {"ha": "center", "va": "center", "fontsize": 7, "color": "0.3", "zorder": 5}
NOTHING |= {"bbox": {"facecolor": "white", "linewidth": 0}}
"""Look of the words in axes without data."""
SHEET = Path(__file__).with_name("paper.mplstyle")
# Metadata of each format, and the attributes of a dataset behind them; PNG comes first.
METADATA = {
    "png": {"Title": "title", "Software": "code_version", "Comment": "config"},
    "pdf": {"Title": "title", "Creator": "code_version", "Subject": "config"},
}


def paper() -> AbstractContextManager:
    """Give the context in which figures are made and saved, whatever the user's own settings."""
    return matplotlib.style.context(SHEET, after_reset=True)


class Paper(Figure):
    """A figure of ours: it is laid out once, and its legend lies below all axes."""


def single_column(height: float) -> Paper:
    """Make an empty figure as wide as a column of a journal, 3.4 in; height: in inches."""
    return Paper((3.4, height), DPI)


def double_column(height: float) -> Paper:
    """Make an empty figure as wide as two columns of a journal, 7.0 in; height: in inches."""
    return Paper((7.0, height), DPI)


def notebook_axes() -> Axes:
    """Make axes on a new figure that a notebook shows."""
    # Only notebooks pay for this import.
    import matplotlib.pyplot as plt

    return plt.figure(FigureClass=Paper, figsize=(5, 5), layout="constrained").subplots()


def is_ours(where: Axes | FigureBase) -> bool:
    """Tell whether axes or a part of a figure belong to a `Paper`, not to a user's own figure."""
    return isinstance(where.figure.figure, Paper)


def labelled(axes: Iterable[Axes]) -> list[Artist]:
    """Collect labelled, visible artists of axes, each label once, in grey if lines share it."""
    keys: dict[str, Artist] = {}
    for ax in axes:
        for artist, label in zip(*ax.get_legend_handles_labels(), strict=True):
            if not _is_seen(ax, artist):
                continue
            if hatch := getattr(artist, "get_hatch", lambda: None)():
                artist = Patch(hatch=hatch, facecolor="none", edgecolor="black", label=label)
            key = keys.setdefault(label, artist)
            if isinstance(key, Line2D) and key.get_color() != artist.get_color():
                keys[label] = copy(key)
                keys[label].set_color("0.4")
    return list(keys.values())


def _is_seen(ax, artist):
    """Tell whether part of an artist lies within its axes."""
    drawn = artist[0] if isinstance(artist, Container) else artist
    paths = drawn.get_paths() if isinstance(drawn, Collection) else [drawn.get_path()]
    if isinstance(drawn, Line2D) and drawn.get_linestyle() != "None" and len(paths[0]) > 1:
        line = drawn.get_transform().transform_path(paths[0])
        return line.intersects_bbox(ax.bbox, filled=False)
    points = np.concatenate([np.empty((0, 2)), *(path.vertices for path in paths)])
    points = drawn.get_transform().transform(points[np.isfinite(points).all(axis=1)])
    return points.size > 0 and Bbox([points.min(0), points.max(0)]).overlaps(ax.bbox)


def points(key: str) -> float:
    """Give the size of a font of the user's settings, pt."""
    return FontProperties(size=matplotlib.rcParams[key]).get_size_in_points()


def signs(where: Axes | FigureBase, key: str = "legend.title_fontsize") -> int:
    """Tell how many signs a line as wide as a figure or axes has in a font of the settings."""
    width = where.bbox.width / where.figure.dpi * 72
    return int(width / (SIGN * points(key)))


def legend(
    where: Axes | FigureBase, keys: Iterable[Artist], title: str = "", ncols: int = 4, **given
) -> Legend | None:
    """Make a legend: of our own figure below it, else of the axes, inside them.

    title: only of our own figure, which has no other place for it
    ncols: most columns below a figure; given: further arguments of matplotlib's legend
    """
    if matplotlib.rcParams["text.usetex"]:
        for text in where.findobj(Text):
            text.set_text(_escaped(text.get_text()))
    for key in (keys := list(keys)):
        key.set_label(_escaped(key.get_label()))
    if isinstance(where, Axes) and not is_ours(where):
        fit_labels(where)
        return _legend_inside(where, keys, {"loc": "upper left"} | given)
    figure = where.get_figure() if isinstance(where, Axes) else where
    given = {"loc": "outside lower center", "title": _escaped(title)} | given
    return _legend_below(figure, keys, ncols, given)


def _escaped(text):
    """Escape what LaTeX would take for a command, if the settings hand text to it."""
    return SPECIAL.sub(r"\\\g<0>", text) if matplotlib.rcParams["text.usetex"] else text


def _legend_below(figure, keys, ncols, given):
    """Make a legend of as many columns as fit in the width of a figure."""
    size = points("legend.fontsize")
    while True:
        made = figure.legend(handles=keys, ncols=ncols, **given)
        share = figure.bbox.width / made.get_window_extent().width
        if share >= 1:
            return made
        made.remove()
        if ncols == 1 or share * size >= max(HARDLY * size, SMALLEST):
            return figure.legend(handles=keys, ncols=ncols, fontsize=share * size, **given)
        ncols -= 1


def _legend_inside(ax, keys, given):
    """Make a legend, in smaller letters than the user's if it is large; none without keys."""
    if not keys:
        return None
    made = ax.legend(handles=keys, **given)
    if not {"fontsize", "prop"} & {*given}:
        box, size = made.get_window_extent(), points("legend.fontsize")
        share = min(WIDEST * ax.bbox.width / box.width, HIGHEST * ax.bbox.height / box.height)
        if share < 1:
            size = max(size * share, min(size, SMALLEST))
            made = ax.legend(handles=keys, fontsize=size, **given)
    return made


def fit_labels(ax: Axes) -> None:
    """Break the labels of axes that are longer than the axes, before the unit or anywhere."""
    for axis, length in ((ax.xaxis, ax.bbox.width), (ax.yaxis, ax.bbox.height)):
        text, size = axis.label.get_text(), axis.label.get_fontsize()
        most = max(int(length / ax.figure.dpi * 72 / (SIGN * size)), FEWEST)
        if len(text) > most:
            lines = text.replace(" (", "\n(", 1).split("\n")
            axis.label.set_text("\n".join(textwrap.fill(line, most) for line in lines))


def lay_out(figure: Figure) -> None:
    """Lay a figure out, once: what is drawn from now on finds the layout as it is."""
    if engine := figure.get_layout_engine():
        engine.execute(figure)
        figure.set_layout_engine("none")


def note_missing(ax: Axes, values: ArrayLike, why: str) -> bool:
    """Tell whether none of the values that axes show is finite, and if so, say why in the axes."""
    if np.isfinite(values).any():
        return False
    ax.text(0.5, 0.5, f"nothing to show: {why}", transform=ax.transAxes, **NOTHING)
    return True


def annotate_row(ax: Axes, row: float, words: str) -> None:
    """Write words to the right of axes, beside a row."""
    place = {"xytext": (4, 0), "textcoords": "offset points", "va": "center"}
    ax.annotate(words, (1, row), xycoords=ax.get_yaxis_transform(), fontsize=6, **place)


@contextmanager
def saved(
    stem: str, attributes: Mapping[str, str], height: float, columns: int = 2
) -> Iterator[Figure]:
    """Give an empty figure, as wide as one or two columns, and save it when the context ends.

    stem: path without ending; attributes: attributes of the dataset drawn; height: in inches
    """
    with paper():
        figure = double_column(height) if columns == 2 else single_column(height)
        yield figure
        save(figure, stem, attributes)


def save(figure: Figure, stem: str | Path, attributes: Mapping[str, str]) -> None:
    """Write a figure as PNG and PDF, without dates, each file whole or not at all.

    stem: path without ending
    attributes: of the dataset drawn; title, code_version and config go into the metadata of files
    """
    # `Figure.savefig` would draw everything twice for each format.
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    lay_out(figure)
    for ending, keys in METADATA.items():
        metadata = {key: attributes[name] for key, name in keys.items() if name in attributes}
        drawn = BytesIO()  # on a full disk the writers of files end in faults of their own
        if ending == "png":
            FigureCanvasAgg(figure).print_png(drawn, metadata=metadata)
        else:
            FigureCanvasPdf(figure).print_pdf(drawn, metadata=metadata | {"CreationDate": None})
        with replacing(f"{stem}.{ending}") as temporary:
            Path(temporary).write_bytes(drawn.getvalue())
