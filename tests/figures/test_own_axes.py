"""Figures in a user's own axes: nothing overlaps or is cut off, and settings stay the user's."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.text import Text
from small_results import make_cells, make_found

import snapmap
from snapmap.applications.boundary.figure import draw_damage_boundary
from snapmap.figures import maps, scales, style, thresholds

CELLS = make_cells(
    ["2" * 12] * 5 + ["000022220000", "0" * 12, "000000000005"],
    f0=np.geomspace(100, 1e4, 12),
    N=np.linspace(800, 2500, 8),
)
DRAW = {
    "map": lambda ax: snapmap.plot_outcome(CELLS, ax, thresholds=make_found().isel(C=0)),
    "thresholds": lambda ax: thresholds.draw_thresholds(ax, make_found()),
    "boundary": lambda ax: draw_damage_boundary(ax, make_found()),
    "field": lambda ax: thresholds.draw_threshold_map(ax, make_found(), "f0", "C"),
}
SETTINGS = {"default": {}, "serif": {"font.family": "serif", "font.size": 8}}


def boxes(ax):
    """The boxes in pixels of what lies around axes: labels, titles, names of ticks, legends."""
    figure = ax.figure
    figure.draw_without_rendering()
    legends = [*figure.legends, *filter(None, [ax.get_legend()])]
    (legend,) = [made.get_window_extent() for made in legends]
    each = [ax, *ax.child_axes]
    ticks = [axis.get_tightbbox() for own in each for axis in (own.xaxis, own.yaxis)]
    return legend, [ax.title.get_window_extent(), *filter(None, ticks)]


@pytest.fixture(autouse=True)
def closed():
    with mpl.rc_context(mpl.rcParamsDefault | {"backend": "agg"}):
        yield
        plt.close("all")


@pytest.mark.parametrize("layout", [None, "constrained"])
@pytest.mark.parametrize("settings", SETTINGS)
@pytest.mark.parametrize("name", DRAW)
def test_a_figure_of_a_column_has_its_legend_beside_its_labels_and_nothing_cut_off(
    name, settings, layout
):
    plt.rcParams.update(SETTINGS[settings])
    before = dict(plt.rcParams)
    figure, ax = plt.subplots(figsize=(3.4, 2.6), layout=layout)
    DRAW[name](ax)
    legend, others = boxes(ax)
    for box in (legend, *others):
        assert box.x0 >= -0.5 and box.x1 <= figure.bbox.x1 + 0.5
        assert box.y0 >= -0.5 and box.y1 <= figure.bbox.y1 + 0.5
    assert legend.y1 <= min(box.y0 for box in others) + 0.5
    assert ax.bbox.height > 0.15 * figure.bbox.height
    assert dict(plt.rcParams) == before
    assert ax.xaxis.label.get_family() == plt.rcParams["font.family"]


@pytest.mark.parametrize("shows", ["snaps", "times"])
def test_a_map_breaks_its_title_and_the_label_of_its_colours_in_a_column(shows):
    cells = CELLS.assign_coords(thickness=1.9, residual_stress=-11.25)
    figure, ax = plt.subplots(figsize=(3.4, 4))
    maps.draw_map(ax, cells, shows=shows)
    figure.draw_without_rendering()
    texts = ax.title, *(each.xaxis.label for each in figure.axes)
    assert len(texts) == 3 if shows == "times" else 2
    for text in texts:
        box = text.get_window_extent()
        assert box.x0 >= -0.5 and box.x1 <= figure.bbox.x1 + 0.5


def test_panels_of_a_figure_have_their_legends_below_them():
    figure, axes = plt.subplots(2, 2, figsize=(7, 5.6))
    for ax, draw in zip(axes.flat, DRAW.values(), strict=True):
        draw(ax)
    figure.draw_without_rendering()
    for ax in axes.flat:
        legend = ax.get_legend().get_window_extent()
        assert legend.y1 <= ax.xaxis.get_tightbbox().y0 + 0.5
        assert legend.x0 >= -0.5 and legend.x1 <= figure.bbox.x1 + 0.5
        assert not any(legend.overlaps(other.bbox) for other in axes.flat)


def test_texts_are_escaped_where_they_go_to_latex_and_only_once():
    draw = scales.number, style._escaped
    assert [write(value) for write, value in zip(draw, (12_000.0, "1 % of a_b"), strict=True)] == [
        "12\u2009000",
        "1 % of a_b",
    ]
    plt.rcParams["text.usetex"] = True
    assert scales.number(12_000.0) == r"12\,000"
    assert style._escaped("1 % & #2 of a_b") == r"1 \% \& \#2 of a_b"
    assert style._escaped(style._escaped("1 %")) == r"1 \%"


def test_all_that_a_figure_says_is_plain_for_latex(monkeypatch):
    """Other signs than these would end a run of LaTeX; matplotlib declares the minus."""
    escaped = []
    monkeypatch.setattr(style, "_escaped", lambda text: escaped.append(text) or text)
    for draw in DRAW.values():
        _, ax = plt.subplots()
        draw(ax)
        texts = {text.get_text() for text in ax.figure.findobj(Text)}
        assert all(text in escaped for text in texts if {*text} & {*"%&#"})
        signs = {sign for text in texts for sign in text if not sign.isascii()}
        assert signs <= {*"µ°−×²\u2009"}


def test_a_few_dampers_are_columns_as_wide_as_each_other():
    cells = CELLS.expand_dims(C=[25.0, 200.0]).isel(f0=0).transpose("C", "N")
    edge = make_found().isel(f0=0)
    ax = snapmap.plot_outcome(cells, x="C", thresholds=edge)
    assert ax.get_xlim() == (-0.5, 1.5)
    assert [text.get_text() for text in ax.get_xticklabels()] == ["25", "200"]
    curve = next(line for line in ax.lines if line.get_label() == "threshold")
    assert curve.get_xdata().tolist() == [0, 1]
