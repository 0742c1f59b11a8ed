"""The style of all figures for print: sheet, sizes, legends, and how they are saved."""

import re
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
from matplotlib.layout_engine import ConstrainedLayoutEngine, LayoutEngine
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.text import Text
from matplotlib.transforms import Bbox, ScaledTranslation
from numpy.typing import ArrayLike

from ..files.atomic import replacing

SIGN = 0.62
"""Width of a sign over the size of its font, on average, with some room to spare."""
SMALLEST, HIGHEST = 5.0, 1 / 3
"""Least size of letters that is chosen, pt, and largest share of the height for a legend."""
GAP = 0.05
"""Distance between the labels of axes and the legend below them, in."""
SPECIAL = re.compile(r"(?<!\\)[%&#]")
"""Signs that LaTeX needs escaped; matplotlib itself escapes an underscore."""
DPI = 300
"""Resolution of PNG, and of rasters in PDF."""
NOTHING = {"ha": "center", "va": "center", "fontsize": 7, "color": "0.3", "zorder": 5}
NOTHING |= {"bbox": {"facecolor": "white", "linewidth": 0}}
"""Look of the words in axes without data."""
SHEET = Path(__file__).with_name("paper.mplstyle")
PLACING = {"GDEF", "GPOS", "GSUB", "kern"}
"""Tables of a font that a PDF, which places each glyph itself, never reads."""
# Metadata of each format, and the attributes of a dataset behind them; PNG comes first.
METADATA = {
    "png": {"Title": "title", "Software": "code_version", "Comment": "config"},
    "pdf": {"Title": "title", "Creator": "code_version", "Subject": "config"},
}


def paper() -> AbstractContextManager:
    """Give the context in which figures are made and saved, whatever the user's own settings."""
    return matplotlib.style.context(SHEET, after_reset=True)


def single_column(height: float) -> Figure:
    """Make an empty figure as wide as a column of a journal, 3.4 in; height: in inches."""
    return Figure((3.4, height), DPI)


def double_column(height: float) -> Figure:
    """Make an empty figure as wide as two columns of a journal, 7.0 in; height: in inches."""
    return Figure((7.0, height), DPI)


def notebook_axes() -> Axes:
    """Make axes on a new figure that a notebook shows."""
    # Only notebooks pay for this import.
    import matplotlib.pyplot as plt

    return plt.figure(figsize=(5, 5), layout="constrained").subplots()


def is_alone(ax: Axes) -> bool:
    """Tell whether axes are the only ones of their figure or subfigure, but for colour bars."""
    return [other for other in ax.get_figure().axes if not _is_colour_bar(other)] == [ax]


def _is_colour_bar(ax):
    return ax.get_label() == "<colorbar>"


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


def engine_of(figure: FigureBase) -> LayoutEngine:
    """Give the layout engine of a figure, the constrained one if it had none."""
    if figure.get_layout_engine() is None:
        figure.figure.set_layout_engine("constrained")
    return figure.get_layout_engine()


def legend(
    where: Axes | FigureBase, keys: Iterable[Artist], title: str = "", ncols: int = 4
) -> Legend:
    """Put a legend below a figure or axes, with room for it and for the labels of the axes.

    It has at most `ncols` columns, and smaller letters than in the settings where room is little.
    A figure without a layout engine gets the constrained one.
    """
    ax, figure = (where, where.get_figure()) if isinstance(where, Axes) else (None, where)
    for text in (ax or figure).findobj(Text):
        text.set_text(_escaped(text.get_text()))
    root, engine = figure.figure, engine_of(figure)
    if ax:
        engine.execute(root)
        _fit_labels(ax, "x", "width")
    place, highest = {"loc": "outside lower center"}, HIGHEST * root.bbox.height
    if ax and is_alone(ax) and isinstance(engine, ConstrainedLayoutEngine):
        where = figure
    elif ax:
        drop = (ax.bbox.y0 - ax.xaxis.get_tightbbox().y0) / root.dpi
        below = ax.transAxes + ScaledTranslation(0, -drop - GAP, root.dpi_scale_trans)
        place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0), "bbox_transform": below}
        highest /= ax.get_subplotspec().get_gridspec().nrows if ax.get_subplotspec() else 1
    place |= {"handles": (keys := list(keys)), "title": _escaped(title)}
    for key in keys:
        key.set_label(_escaped(key.get_label()))
    made = _fitting_legend(where, place, ncols, highest)
    if ax:
        engine.execute(root)
        _fit_labels(ax, "y", "height")
    return made


def _escaped(text):
    """Escape what LaTeX would take for a command, if the settings hand text to it."""
    return SPECIAL.sub(r"\\\g<0>", text) if matplotlib.rcParams["text.usetex"] else text


def _fitting_legend(where, parts, ncols, highest):
    """Make a legend of as many columns as keep its letters largest, at most of the user's size."""
    size, shares = points("legend.fontsize"), []
    for columns in range(1, ncols + 1):
        made = where.legend(**parts, ncols=columns)
        box = made.get_window_extent()
        shares.append(min(where.bbox.width / box.width, highest / box.height, 1))
        made.remove()
    columns = ncols - int(np.argmax(shares[::-1]))  # the flattest of equals
    title, least, share = points("legend.title_fontsize") / size, min(size, SMALLEST), max(shares)
    while True:  # small letters of LaTeX are wider than their size tells
        size = max(size * share, least)
        made = where.legend(**parts, fontsize=size, title_fontsize=size * title, ncols=columns)
        share = where.bbox.width / made.get_window_extent().width
        if share >= 1 or size == least:
            return made
        made.remove()


def _fit_labels(ax, which, side):
    """Break the labels of axes and colour bars before the unit, or shrink them, if too long."""
    for each in (ax, *filter(_is_colour_bar, ax.get_figure().axes)):
        label, room = getattr(each, f"{which}axis").label, getattr(each.bbox, side)
        length = getattr(label.get_window_extent(), side)
        if length > room:
            label.set_text(label.get_text().replace(" (", "\n(", 1))
            length = getattr(label.get_window_extent(), side)
        if length > room:
            label.set_fontsize(max(label.get_fontsize() * room / length, SMALLEST))


def fit(figure: Figure, ratio: float) -> None:
    """Lay a figure out, and set its height so that axes, all alike, are `ratio` as high as wide.

    Colour bars must lie below the axes.
    """
    figure.get_layout_engine().execute(figure)
    figure.set_layout_engine("none")
    rows = figure.axes[0].get_subplotspec().get_gridspec().nrows
    places = {ax: ax.get_position(original=True) for ax in figure.axes}
    width, height = places[figure.axes[0]].size * figure.get_size_inches()
    before, growth = figure.get_figheight(), ratio * width - height
    after = before + rows * growth
    figure.set_figheight(after)
    for ax, place in places.items():
        spec = ax.get_subplotspec()
        y0, y1 = place.y0 * before, place.y1 * before
        if spec:
            y0 += (rows - spec.rowspan.stop) * growth
            y1 += (rows - spec.rowspan.start) * growth
        ax.set_position([place.x0, y0 / after, place.width, (y1 - y0) / after])


def note_missing(ax: Axes, values: ArrayLike, why: str) -> bool:
    """Tell whether none of the values that axes show is finite, and if so, say why in the axes."""
    if np.isfinite(values).any():
        return False
    ax.text(0.5, 0.5, f"nothing to show: {why}", transform=ax.transAxes, **NOTHING)
    return True


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
    from fontTools import subset
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_pdf import FigureCanvasPdf

    for ending, keys in METADATA.items():
        metadata = {key: attributes[name] for key, name in keys.items() if name in attributes}
        drawn = BytesIO()  # on a full disk the writers of files end in faults of their own
        if ending == "png":
            FigureCanvasAgg(figure).print_png(drawn, metadata=metadata)
            figure.set_layout_engine("none")
        else:
            metadata["CreationDate"] = None
            with _plain_fonts(subset):
                FigureCanvasPdf(figure).print_pdf(drawn, metadata=metadata)
        with replacing(f"{stem}.{ending}") as temporary:
            Path(temporary).write_bytes(drawn.getvalue())


@contextmanager
def _plain_fonts(subset):
    """Load fonts without the tables PLACING, which would take half of the time of a PDF."""
    load_font = subset.load_font

    def load(*arguments, **options):
        font = load_font(*arguments, **options)
        for tag in PLACING & {*font.keys()}:
            del font[tag]
        return font

    subset.load_font = load
    try:
        yield
    finally:
        subset.load_font = load_font
