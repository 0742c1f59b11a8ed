"""Figures in a user's own axes: nothing overlaps or is cut off, and settings stay the user's."""

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.text import Text
from small_results import make_cells, make_found, make_history

import snapmap
from snapmap.applications.boundary.figure import draw_damage_boundary
from snapmap.applications.histories.figure import draw_history
from snapmap.figures import maps, scales, style, thresholds

ROWS = ["2" * 12] * 5 + ["000022220000", "0" * 12, "000000000005"]
CELLS = make_cells(ROWS, f0=np.geomspace(100, 1e4, 12), N=np.linspace(800, 2500, 8))
DRAW = {
    "map": lambda ax: snapmap.plot_outcome(CELLS, ax, thresholds=make_found().isel(C=0)),
    "thresholds": lambda ax: thresholds.draw_thresholds(ax, make_found()),
    "boundary": lambda ax: draw_damage_boundary(ax, make_found()),
    "field": lambda ax: thresholds.draw_threshold_map(ax, make_found(), "f0", "C"),
}
SEABORN = {key: 12 for key in ("font.size", "axes.labelsize", "axes.titlesize")}
SEABORN |= {f"{key}.labelsize": 11 for key in ("xtick", "ytick")} | {"legend.fontsize": 11}
JOURNAL = {"font.family": "serif", "font.size": 8, "axes.prop_cycle": mpl.cycler(color="rgb")}
PAGE, COLUMN = {"nrows": 2, "ncols": 2, "figsize": (7, 6)}, {"figsize": (3.4, 2.6)}
LAYOUTS = {
    "tight": ({}, COLUMN, lambda figure: figure.tight_layout()),
    "adjusted": (JOURNAL, COLUMN, lambda figure: figure.subplots_adjust(0.2, 0.2, 0.75)),
    "four": ({}, PAGE, lambda figure: figure.tight_layout()),
    "constrained": (JOURNAL, PAGE | {"layout": "constrained"}, lambda figure: None),
    "seaborn": (SEABORN, {"figsize": (6.4, 4.8)}, lambda figure: figure.tight_layout()),
    "journal": (JOURNAL, COLUMN | {"layout": "constrained"}, lambda figure: None),
}
"""Settings, a user's own figure, and what they do with it after our plots."""


def drawn_texts(figure, monkeypatch):
    """All texts that a figure draws, with their boxes in pixels."""
    seen, draw = [], Text.draw

    def note(self, renderer):
        draw(self, renderer)
        if self.get_visible() and self.get_text().strip():
            seen.append((self, self.get_window_extent(renderer)))

    monkeypatch.setattr(Text, "draw", note)
    figure.draw_without_rendering()
    return seen


def require_legible(figure, monkeypatch):
    """No text lies over another, outside the page, or is too small."""
    texts = drawn_texts(figure, monkeypatch)
    page = figure.bbox.padded(0.5)
    for i, (text, box) in enumerate(texts):
        assert page.contains(box.x0, box.y0) and page.contains(box.x1, box.y1), text
        assert text.get_fontsize() >= style.SMALLEST, text
        for other, beside in texts[:i]:
            assert not box.padded(-1).overlaps(beside.padded(-1)), (text, other)


@pytest.fixture(autouse=True)
def closed():
    with mpl.rc_context(mpl.rcParamsDefault | {"backend": "agg"}):
        yield
        plt.close("all")


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("name", DRAW)
def test_in_a_users_own_layout_no_text_lies_over_another_or_is_cut_off(name, layout, monkeypatch):
    """No letter is too small, and the legend is that of the axes, inside them."""
    settings, made, adjust = LAYOUTS[layout]
    plt.rcParams.update(settings)
    before = dict(plt.rcParams)
    figure, axes = plt.subplots(**made)
    engine = figure.get_layout_engine()
    axes = np.ravel(axes).tolist()
    for ax in axes:
        DRAW[name](ax)
    assert figure.get_layout_engine() is engine and dict(plt.rcParams) == before
    adjust(figure)
    require_legible(figure, monkeypatch)
    for ax in axes:
        if legend := ax.get_legend():
            box = legend.get_window_extent()
            assert ax.bbox.contains(box.x0, box.y0) and ax.bbox.contains(box.x1, box.y1)
    assert not figure.legends


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_history_is_legible_in_a_column_of_any_layout(layout, monkeypatch):
    settings, made, adjust = LAYOUTS[layout]
    plt.rcParams.update(settings)
    figure, axes = plt.subplots(3, sharex=True, figsize=(3.4, 4.2), layout=made.get("layout"))
    history = make_history(10, 0, -8, -12, -5, -12, t_snap=22.5)
    draw_history(axes, history.assign(contact_force=abs(history.z_mass), gravity=1e-4))
    adjust(figure)
    require_legible(figure, monkeypatch)
    assert axes[0].get_legend() and not figure.legends


@pytest.mark.parametrize("f0", [CELLS.f0.values, np.geomspace(1e4, 2e4, 12)])
def test_on_a_page_of_many_maps_no_text_lies_over_another(monkeypatch, f0):
    names = {"device": "number {}", "shape": "shape {}", "direction": "{}z"}
    named = [{key: name.format(i) for key, name in names.items()} for i in range(12)]
    cells = [CELLS.assign_coords(each | {"C": 7.5 + i, "f0": f0}) for i, each in enumerate(named)]
    monkeypatch.setattr(style, "save", lambda figure, *_: style.lay_out(figure))
    with style.saved("maps", CELLS.attrs, 3.6, 2) as figure:
        maps.draw_maps(figure, [(part, make_found().isel(C=0), ()) for part in cells], "f0", "N")
    require_legible(figure, monkeypatch)


def test_a_legend_and_colours_are_as_asked_and_ours_whatever_the_users_cycle_is():
    plt.rcParams.update(JOURNAL)
    _, (left, right) = plt.subplots(1, 2)
    snapmap.plot_outcome(CELLS, left, legend=False, colours={"snaps": "gold"})
    assert left.get_legend() is None
    assert "#ffd700" in map(mpl.colors.to_hex, left.collections[0].cmap.colors)
    ax = snapmap.plot_outcome(CELLS, right, legend={"loc": "lower left", "fontsize": 7})
    assert ax.get_legend().get_texts()[0].get_fontsize() == 7
    with pytest.raises(ValueError, match="'snap' is none of the states does not snap, snaps"):
        snapmap.plot_outcome(CELLS, colours={"snap": "gold"})
    ax = thresholds.draw_thresholds(plt.subplots()[1], make_found())
    assert {"black", style.VERMILION} <= {line.get_color() for line in ax.lines}


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


def test_texts_are_escaped_where_they_go_to_latex_and_only_once():
    assert scales.number(12_000.0) == "12\u2009000" and style._escaped("1 % of a_b") == "1 % of a_b"
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
