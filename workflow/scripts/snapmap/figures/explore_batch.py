"""The part of the page on devices as made: how many snap, and which value that depends on."""

import html
from itertools import product

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..tolerances.statistics import percents
from .scales import value_text
from .tolerances import LINES, each_share, words_of

NOMINAL, LATCHED = "#d55e00", "#0072b2"
COLOURS = ("#000000", "#d55e00", "#56b4e9", "#0072b2", "#009e73", "#cc79a7", "#999999")
DASHES = {":": "dot", "--": "dash", "-": "solid"}
SECTION = """<section class="wide" aria-labelledby="made">
  <h2 id="made">Devices as made</h2>
  <p>{words}</p>
  <div class="pair">
    {probability}
    {sensitivity}
  </div>
  {requirements}
</section>"""


def batch_section(found: xr.Dataset, figure) -> str:
    """Write a section of the page; found: thresholds of devices as made.

    figure: makes HTML of a figure, given its name and height
    """
    missing = int((found.bistable == 0).sum())
    words = (
        f"{found.sizes['sample']} devices were drawn whose values scatter. Lines: where 1, 10, 50, "
        "90 and 99\u00a0% of them snap. The other figure has the share of the threshold's variance "
        "owed to each value."
    )
    if missing:
        words += f" {missing} of them have no second stable shape and never snap."
    return SECTION.format(
        words=words,
        probability=figure(_choosing(found, _shares, _layout_of_shares(found)), "made-probability"),
        sensitivity=figure(_choosing(found, _owed, _layout_of_owed()), "made-sensitivity"),
        requirements=_requirements(found),
    )


def _choosing(found, curves, layout):
    """A figure of curves for each point of all axes but f0 and N, one shown at a time."""
    others = [key for key in found.N_nominal.dims if key != "f0"]
    places = list(product(*(range(found.sizes[key]) for key in others)))
    each = [curves(found.isel(dict(zip(others, place, strict=True)))) for place in places]
    shown = np.repeat(np.arange(len(each)), [len(some) for some in each])
    figure = go.Figure([curve for some in each for curve in some])
    for curve, number in zip(figure.data, shown, strict=True):
        curve.visible = bool(number == 0)
    buttons = []
    for number, place in enumerate(places):
        at = found.isel(dict(zip(others, place, strict=True)))
        label = ", ".join(_plain(key, at[key].item()) for key in others)
        buttons.append(
            {"label": label, "method": "restyle", "args": ["visible", (shown == number).tolist()]}
        )
    menu = {"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom"}
    return figure.update_layout(layout, updatemenus=[menu] if len(buttons) > 1 else [])


def _plain(key, value):
    """A value of an axis without typesetting."""
    text = value_text(key, value)
    for sign, plain in (("$^{-1}$", "⁻¹"), ("$^{-3}$", "⁻³"), ("$", ""), ("_0", "")):
        text = text.replace(sign, plain)
    return text


def _shares(found):
    f0 = found.f0.values.tolist()
    field = go.Heatmap(
        x=f0,
        y=found.N.values.tolist(),
        z=found.probability.transpose("N", "f0").values.tolist(),
        zmin=0,
        zmax=1,
        colorscale=[[0, "#ffffff"], [1, "#777777"]],
        colorbar={"title": "share", "tickformat": ".0%"},
        hovertemplate="%{z:.1%} snap at N = %{y:.4g}, %{x:.4g} Hz<extra></extra>",
    )
    lines = [
        _line(
            f0, found.N_quantile.sel(quantile=share), "#000000", f"{share:.0%} snap", DASHES[look]
        )
        for share, look in LINES.items()
    ]
    nominal = _line(f0, found.N_nominal, NOMINAL, "nominal device", "solid")
    return [field, *lines, nominal]


def _owed(found):
    f0 = found.f0.values.tolist()
    curves = []
    for number, value in enumerate(found.value.values.tolist()):
        colour, name = COLOURS[number % len(COLOURS)], words_of(value).replace("$", "")
        for order, dash in (("total", "solid"), ("first", "dot")):
            index = found.sensitivity.sel(value=value, order=order)
            words = name if order == "total" else f"{name} alone"
            curves.append(_line(f0, index, colour, words, dash, "lines+markers"))
    return curves


def _line(x, values, colour, name, dash, mode="lines"):
    y = [None if np.isnan(value) else value for value in values.values.tolist()]
    look = {"color": colour, "width": 1.5, "dash": dash}
    shown = f"{html.escape(name)}: %{{y:.4g}}<extra></extra>"
    return go.Scatter(x=x, y=y, mode=mode, line=look, name=name, hovertemplate=shown)


def _layout_of_shares(found):
    N = found.N.values
    return _layout() | {"yaxis": {"title": "N (multiples of g)", "range": [N[0], N[-1]]}}


def _layout_of_owed():
    return _layout() | {"yaxis": {"title": "share of the variance", "range": [-0.05, 1.1]}}


def _layout():
    return {
        "xaxis": {"title": "pulse frequency f<sub>0</sub> (Hz)", "type": "log", "nticks": 3},
        "legend": {"orientation": "h", "y": -0.25},
        "margin": {"l": 60, "r": 12, "t": 40, "b": 50},
    }


def _requirements(found):
    """A table of the shares that meet each requirement, and all."""
    if "requirement" not in found.dims:
        return ""
    rows = []
    others = found["yield"].dims
    for name, values, ends in each_share(found):
        for place in product(*(range(found.sizes[key]) for key in others)):
            at = dict(zip(others, place, strict=True))
            where = ", ".join(_plain(key, found[key].values[i].item()) for key, i in at.items())
            cells = name, where, percents(values.isel(at)), percents(*ends.isel(at))
            rows.append("".join(f"<td>{html.escape(cell)}</td>" for cell in cells))
    head = "".join(f"<th>{cell}</th>" for cell in ("requirement", "", "met by", "at 95 %"))
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
