"""The page to explore a cube: maps over two of its axes, and behind each cell its history."""

import html
import json
from pathlib import Path
from string import Template

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..device import VALUES
from . import scales, style
from .explore_axes import axis, durations, layout, plane
from .explore_batch import batch_section
from .explore_cells import cell_data, opening, states
from .explore_device import device_rows, words_of

HERE = Path(__file__).parent
BAND, BEAM, MASS, TOTAL, AID = "rgba(0, 114, 178, 0.35)", "#0072b2", "#000000", "#d55e00", "#555555"
PLAIN = {
    "template": "simple_white",
    "font": {"family": "system-ui, sans-serif", "size": 12},
    "hoverlabel": {"bgcolor": "white", "align": "left"},
}
MARGIN = {"l": 60, "r": 12, "t": 30, "b": 50}
BUTTONS = {
    "responsive": True,
    "displaylogo": False,
    "showSendToCloud": False,  # a button that uploads the study
    "plotlyServerURL": "",
    "doubleClick": "reset",  # also what two quick clicks on two cells do
    "modeBarButtonsToRemove": ["select", "lasso", "autoScale"],
}

COLOURED_BY = {
    True: "whether the beam is tripped in the end, dark where that is proven",
    False: "whether the beam snaps",
}
"""What the colours of the map say, by whether it is known where the beam stays."""


def page(
    cube: xr.Dataset,
    traces: xr.Dataset,
    found: xr.Dataset,
    horizon: float,
    made: xr.Dataset | None = None,
) -> str:
    """Write a cube, its traces and its thresholds as one HTML page that needs nothing else.

    traces: unpacked; where they are thinned, so is the map
    found: thresholds at least at the points of the cube
    horizon: time for which the cells were followed after the pulse, us
    made: thresholds of devices as made, if there are any
    """
    cells = cube.sel({key: traces[key] for key in cube.outcome.dims})
    edges = found.sel({key: traces[key] for key in cube.outcome.dims[:-1]})
    document = json.loads(cube.attrs["config"])
    x, y = plane(cells)
    data = {
        "axes": [axis(cells, key) for key in cells.outcome.dims],
        "x": x,
        "y": y,
        "start": opening(cells, x, y),
        "horizon": float(horizon),
        "devices": device_rows(document),
        "varied": [(key, words_of(key)) for key in cells.outcome.dims if key in VALUES],
        **cell_data(cells, traces, edges),
    }
    return Template(_text("explore.html")).substitute(
        map=_figure(_map(cells, x, y), "map", "470px", include_plotlyjs=True),
        history=_figure(_history(traces), "history", "480px", include_plotlyjs=False),
        colours=COLOURED_BY["well" in cells],
        drawing=_text("device.svg"),
        data=json.dumps(data, allow_nan=False).replace("</", "<\\/"),
        code=_text("explore.js"),
        made="" if made is None else batch_section(made, _figure_of_batch),
        thinned=_thinning(cube, cells),
        model=html.escape(document["model"]["name"]),
        guide=", ".join(style.guides(document)) or "some guided, some free to tilt",
        version=html.escape(cube.attrs["code_version"]),
    )


def _text(name):
    return (HERE / name).read_text(encoding="utf-8")


def _figure(figure, name, height, include_plotlyjs):
    place = {"full_html": False, "div_id": name, "default_height": height}
    figure.update_layout(PLAIN)
    return figure.to_html(config=BUTTONS, include_plotlyjs=include_plotlyjs, **place)


def _figure_of_batch(figure, name):
    return _figure(figure, name, "432px", include_plotlyjs=False)


def _map(cells, x, y):
    """The map without its cells and lines, which the page fills in for the other axes' values."""
    right, up = (scales.scale_of(key, cells[key].values) for key in (x, y))
    colours = [state.colour for state in states(cells)]
    steps = np.repeat(np.arange(len(colours) + 1) / len(colours), 2)[1:-1]
    heatmap = go.Heatmap(
        x=right.edges.tolist(),
        y=up.edges.tolist(),
        zmin=-0.5,
        zmax=len(colours) - 0.5,
        colorscale=list(zip(steps, np.repeat(colours, 2).tolist(), strict=True)),
        showscale=False,
        hovertemplate="%{text}<extra></extra>",
    )
    figure = go.Figure([heatmap, *_thresholds(), *_marks()])
    figure.update_layout(xaxis=layout(right), yaxis=layout(up), margin=MARGIN)
    if x == "f0":
        # An axis that no curve is drawn on is not shown.
        figure.add_scatter(x=[None], y=[None], xaxis="x2", showlegend=False, hoverinfo="skip")
        figure.update_layout(xaxis2=layout(right) | durations(right), margin_t=76)
    return figure


def _thresholds():
    """Where all snap from, and where the first snap, with its band of error."""
    bare = {"hoverinfo": "skip", "showlegend": False}
    always = {"color": "black", "width": 1, "dash": "dot"}
    pale = "rgba(255, 255, 255, 0.6)"  # so that the line stands out from dark cells, too
    error = {"fill": "toself", "fillcolor": pale, "line": {"width": 3, "color": pale}}
    first = {"line": {"color": "black", "width": 1.5}, "marker": {"size": 3, "color": "black"}}
    yield go.Scatter(**bare, mode="lines", line=always, opacity=0.7)
    yield go.Scatter(**bare, mode="lines", **error)
    yield go.Scatter(**bare, mode="lines+markers", **first)


def _marks():
    """What another step did not reproduce, and the chosen cell with a halo."""
    bare = {"mode": "markers", "hoverinfo": "skip", "showlegend": False}
    apart = {"symbol": "line-ne-open", "size": 5, "color": "#333333"}
    chosen = {"symbol": "circle-open", "size": 15, "color": "black", "line": {"width": 2}}
    halo = {**chosen, "color": "white", "line": {"width": 5}}
    return [go.Scatter(**bare, marker=marker) for marker in (apart, halo, chosen)]


def _history(traces):
    """The two axes of a cell's history, which the page fills in for the chosen cell."""
    line = {"mode": "lines", "hovertemplate": "%{y:.3g} at %{x:.3g} ms", "x": [0], "y": [0]}
    edge, band = {"color": BEAM, "width": 0.7}, {"fill": "tonexty", "fillcolor": BAND}
    on_energy = {**line, "yaxis": "y2"}
    curves = [
        go.Scatter(**line, line=edge, name="w(L/2), least", showlegend=False),
        go.Scatter(**line, line=edge, name="midpoint w(L/2)", **band),
        go.Scatter(**line, line={"color": MASS, "width": 1.5}, name="mass z<sub>M</sub>"),
        go.Scatter(**on_energy, line={"color": TOTAL, "width": 1.5}, name="energy"),
        go.Scatter(**on_energy, line={"color": BEAM, "width": 1}, name="beam's energy"),
    ]
    w_2 = float(traces.second_equilibrium.min())
    return go.Figure(curves).update_layout(
        xaxis={"title": "time after the start of the pulse (ms)", "anchor": "y2"},
        yaxis={"title": "position (µm)", "domain": [0.45, 1], "zeroline": False},
        yaxis2={"title": "energy / saddle's", "domain": [0, 0.4], "zeroline": False},
        yaxis_autorangeoptions={"include": [1.15 * w_2, -1.15 * w_2]},
        yaxis2_autorangeoptions={"include": [0, 1.2]},
        shapes=[
            _level("y", w_2, "second shape w<sub>2</sub>", "dash"),
            _level("y2", 1.0, "saddle", "solid"),
            _instant("end of the pulse", "dot"),
            _instant("snap", "dashdot"),
            _instant("settled", "longdash"),
        ],
        legend={"orientation": "h", "traceorder": "normal", "y": 1.02, "yanchor": "bottom"},
        legend_entrywidth=88,
        legend_font_size=11,
        margin=MARGIN,
    )


def _level(axis, y, name, dash):
    place = {"xref": "x domain", "x0": 0, "x1": 1, "yref": axis, "y0": y, "y1": y}
    return _mark(name, dash, place)


def _instant(name, dash):
    place = {"xref": "x", "x0": 0, "x1": 0, "yref": "paper", "y0": 0, "y1": 1}
    return _mark(name, dash, place)


def _mark(name, dash, place):
    line = {"color": AID, "width": 1.2, "dash": dash}
    return {"type": "line", "line": line, "opacity": 1, "name": name, "showlegend": True, **place}


def _thinning(cube, cells):
    kept = [
        f"{cells.sizes[key]} of {cube.sizes[key]} {key}"
        for key in cube.outcome.dims
        if cells.sizes[key] < cube.sizes[key]
    ]
    *most, last = kept or [""]
    words = f"{', '.join(most)} and {last}" if most else last
    return f"Shown are {words} of the cube. " if kept else ""
