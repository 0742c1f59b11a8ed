"""The page to explore a cube: maps over two of its axes, and behind each cell its history."""

import html
import json
from pathlib import Path
from string import Template

import plotly.graph_objects as go
import xarray as xr

from ..device import VALUES
from . import scales, style
from .explore_axes import axis, durations, layout, plane
from .explore_batch import batch_section
from .explore_cells import cell_data, opening
from .explore_device import STRUCK, device_rows, kind_of, vibrations, words_of
from .explore_history import history, legend

HERE = Path(__file__).parent
PLAIN = {
    "template": "simple_white",
    "font": {"family": "system-ui, sans-serif", "size": 12},
    "hoverlabel": {"bgcolor": "white", "align": "left"},
    "separators": ".\u2009",  # of decimals and of thousands
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
    True: "whether the beam snaps, when it first does, or where it ends, dark where that is proven",
    False: "whether the beam snaps, or when it first does",
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
    motion = history(traces).update_layout(margin=MARGIN)
    data = {
        "axes": [axis(cells, key) for key in cells.outcome.dims],
        "x": x,
        "y": y,
        "start": opening(cells, x, y),
        "horizon": float(horizon),
        "devices": device_rows(document),
        "vibrations": vibrations(document, cells.C.values),
        "varied": [(key, words_of(key)) for key in cells.outcome.dims if key in VALUES],
        **cell_data(cells, traces, edges),
    }
    kind = kind_of(document)
    return Template(_text("explore.html")).substitute(
        map=_figure(_map(cells, x, y), "map", "470px", include_plotlyjs=True),
        history=_figure(motion, "history", "440px", include_plotlyjs=False),
        lines=legend(motion),
        colours=COLOURED_BY["well" in cells],
        drawing=_text("device.svg"),
        drawn=kind,
        struck=STRUCK[kind],
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
    """The map without cells, colours and lines; the page fills them in as chosen."""
    right, up = (scales.scale_of(key, cells[key].values) for key in (x, y))
    heatmap = go.Heatmap(
        x=right.edges.tolist(),
        y=up.edges.tolist(),
        zmin=-0.5,
        showscale=False,
        hovertemplate="%{text}<extra></extra>",
    )
    figure = go.Figure([heatmap, *_thresholds(), *_marks()])
    figure.update_layout(xaxis=layout(right), yaxis=layout(up), margin=MARGIN)
    if x == "f0":
        # An axis that no curve is drawn on is not shown.
        figure.add_scatter(x=[None], y=[None], xaxis="x2", showlegend=False, hoverinfo="skip")
        figure.update_layout(xaxis2=layout(right) | durations(right), margin_t=90)
    return figure


def _thresholds():
    """Where all snap from, and where the first snap, with its band of error."""
    bare = {"hoverinfo": "skip", "showlegend": False}
    always = {"line": {"color": "black", "width": 1}}
    always["marker"] = {"symbol": "line-ew-open", "size": 9, "color": "black"}
    pale = "rgba(255, 255, 255, 0.6)"
    error = {"fill": "toself", "fillcolor": pale, "line": {"width": 3, "color": pale}}
    first = {"line": {"color": "black", "width": 1.5}, "marker": {"size": 3, "color": "black"}}
    yield go.Scatter(**bare, mode="lines+markers", **always)
    yield go.Scatter(**bare, mode="lines", **error)
    yield go.Scatter(**bare, mode="lines+markers", **first)


def _marks():
    """What another step had end elsewhere, and the chosen cell with a halo."""
    bare = {"mode": "markers", "hoverinfo": "skip", "showlegend": False}
    apart = {"symbol": "line-ne-open", "size": 5, "color": "#333333"}
    chosen = {"symbol": "circle-open", "size": 15, "color": "black", "line": {"width": 2}}
    halo = {**chosen, "color": "white", "line": {"width": 5}}
    return [go.Scatter(**bare, marker=marker) for marker in (apart, halo, chosen)]


def _thinning(cube, cells):
    kept = [
        f"{cells.sizes[key]} of {cube.sizes[key]} {key}"
        for key in cube.outcome.dims
        if cells.sizes[key] < cube.sizes[key]
    ]
    *most, last = kept or [""]
    words = f"{', '.join(most)} and {last}" if most else last
    return f"Shown are {words} of the cube. " if kept else ""
