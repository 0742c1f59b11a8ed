"""The page to explore a cube: maps over two of its axes, and behind each cell its history."""

import html
import json
from pathlib import Path
from string import Template

import plotly.graph_objects as go
import xarray as xr

from ..device import VALUES
from . import explore_words as words
from . import scales, style
from .explore_cells import cell_data, opening

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
    True: "whether the beam snaps, when it first does, or where it ends",
    False: "whether the beam snaps, or when it first does",
}
"""What the colours of the map say, by whether it is known where the beam stays."""
BAND, BEAM, MASS, TOTAL, AID = "rgba(0, 114, 178, 0.35)", "#0072b2", "#000000", "#d55e00", "#555555"
DASHES = {"dash": "8 4", "dot": "2 2", "dashdot": "8 3 2 3", "longdash": "12 4"}
"""Of plotly's dashes what SVG takes."""
SAMPLE = '<svg width="28" height="12" fill="none" aria-hidden="true">{}</svg>'
LINE = '<path d="M0 6H28" stroke="{}" stroke-width="{}" stroke-dasharray="{}"/>'


def page(cube: xr.Dataset, traces: xr.Dataset, found: xr.Dataset, horizon: float) -> str:
    """Write a cube, its traces and its thresholds as one HTML page that needs nothing else.

    traces: unpacked; where they are thinned, so is the map
    found: thresholds at least at the points of the cube
    horizon: time for which the cells were followed after the pulse, us
    """
    cells = cube.sel({key: traces[key] for key in cube.outcome.dims})
    edges = found.sel({key: traces[key] for key in cube.outcome.dims[:-1]})
    document = json.loads(cube.attrs["config"])
    x, y = words.plane(cells)
    motion = _history(traces)
    data = {
        "axes": [words.axis(cells, key) for key in cells.outcome.dims],
        "x": x,
        "y": y,
        "start": opening(cells, x, y),
        "horizon": float(horizon),
        "devices": words.device_rows(document),
        "vibrations": words.vibrations(document, cells.C.values),
        "varied": [(key, words.words_of(key)) for key in cells.outcome.dims if key in VALUES],
        **cell_data(cells, traces, edges),
    }
    kind = words.kind_of(document)
    return Template(_text("explore.html")).substitute(
        map=_figure(_map(cells, x, y), "map", "470px", include_plotlyjs=True),
        history=_figure(motion, "history", "440px", include_plotlyjs=False),
        lines=_legend(motion),
        colours=COLOURED_BY["well" in cells],
        drawing=_text("device.svg"),
        drawn=kind,
        struck=words.STRUCK[kind],
        data=json.dumps(data, allow_nan=False).replace("</", "<\\/"),
        code=_text("explore.js"),
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


def _map(cells, x, y):
    """The map without cells, colours and lines; the page fills them in as chosen."""
    right, up = (scales.scale_of(key, cells[key].values) for key in (x, y))
    shown = {"zmin": -0.5, "showscale": False, "hovertemplate": "%{text}<extra></extra>"}
    bare = {"hoverinfo": "skip", "showlegend": False}
    always = {"symbol": "line-ew-open", "size": 9, "color": "black"}
    pale = "rgba(255, 255, 255, 0.6)"
    apart = {"symbol": "line-ne-open", "size": 7, "color": "#333333"}
    chosen = {"symbol": "circle-open", "size": 15, "color": "black", "line": {"width": 2}}
    curves = [
        go.Heatmap(x=right.edges.tolist(), y=up.edges.tolist(), **shown),
        # From where all snap; the band of error about where the first snap; and where they do.
        _curve("black", 1, mode="lines+markers", marker=always, **bare),
        _curve(pale, 3, mode="lines", fill="toself", fillcolor=pale, **bare),
        _curve("black", 1.5, mode="lines+markers", marker={"size": 3, "color": "black"}, **bare),
        # What another step had end elsewhere, and the chosen cell with a halo.
        go.Scatter(mode="markers", marker=apart, **bare),
        go.Scatter(
            mode="markers", marker={**chosen, "color": "white", "line": {"width": 5}}, **bare
        ),
        go.Scatter(mode="markers", marker=chosen, **bare),
    ]
    axes = {"xaxis": words.layout(right), "yaxis": words.layout(up), "margin": MARGIN}
    if x == "f0":
        # An axis that no curve is drawn on is not shown.
        curves.append(go.Scatter(x=[None], y=[None], xaxis="x2", **bare))
        axes |= {"xaxis2": words.layout(right) | words.durations(right), "margin_t": 60}
    return go.Figure(curves).update_layout(axes)


def _curve(colour, width, dash=None, **look):
    return go.Scatter(line={"color": colour, "width": width, "dash": dash}, **look)


def _history(traces):
    """Two axes, of positions and of energies; the curves are as `explore_cells.TRACED`."""
    line = {"mode": "lines", "hovertemplate": "%{y:.3g} at %{x:.3g} ms", "x": [0], "y": [0]}
    on_energy, band = {**line, "yaxis": "y2"}, {"fill": "tonexty", "fillcolor": BAND}
    curves = [
        _curve(BEAM, 0.7, name="w(L/2), least", **line),
        _curve(BEAM, 0.7, name="midpoint w(L/2)", **line, **band),
        _curve(MASS, 1.5, name="mass z<sub>M</sub>", **line),
        _curve(TOTAL, 1.5, name="energy", **on_energy),
        _curve(BEAM, 1, name="beam's energy", **on_energy),
    ]
    w_2 = float(traces.second_equilibrium.min())
    wide, high = {"xref": "x domain", "x0": 0, "x1": 1}, {"yref": "paper", "y0": 0, "y1": 1}
    instant = {"xref": "x", "x0": 0, "x1": 0, **high}
    shapes = [
        _mark("second shape w<sub>2</sub>", "dash", yref="y", y0=w_2, y1=w_2, **wide),
        _mark("saddle", "solid", yref="y2", y0=1.0, y1=1.0, **wide),
        _mark("end of the pulse", "dot", **instant),
        _mark("snap", "dashdot", **instant),
        _mark("settled", "longdash", **instant),
    ]
    return go.Figure(curves).update_layout(
        xaxis={"title": "time after the start of the pulse (ms)", "anchor": "y2"},
        yaxis={"title": "position (µm)", "domain": [0.45, 1], "zeroline": False},
        yaxis2={"title": "energy / saddle's", "domain": [0, 0.4], "zeroline": False},
        yaxis_autorangeoptions={"include": [1.15 * w_2, -1.15 * w_2]},
        yaxis2_autorangeoptions={"include": [0, 1.2]},
        shapes=shapes,
        showlegend=False,
        margin=MARGIN,
    )


def _mark(name, dash, **place):
    line = {"color": AID, "width": 1.2, "dash": dash}
    return {"type": "line", "line": line, "opacity": 1, "name": name, **place}


def _legend(figure):
    """Items of a list of the lines of `_history`; it wraps on a phone, where plotly's does not."""
    items = []
    for line in (*figure.data[1:], *figure.layout.shapes):
        parts = [LINE.format(line.line.color, line.line.width, DASHES.get(line.line.dash, "none"))]
        if "fill" in line and line.fill:
            parts.append(LINE.format(BAND, 9, "none"))
        items.append(f"<li>{SAMPLE.format(''.join(parts))} {line.name}</li>")
    return "".join(items)


def _thinning(cube, cells):
    kept = [
        f"{cells.sizes[key]} of {cube.sizes[key]} {key}"
        for key in cube.outcome.dims
        if cells.sizes[key] < cube.sizes[key]
    ]
    text = " and ".join(filter(None, [", ".join(kept[:-1]), *kept[-1:]]))
    return f"Shown are {text} of the cube. " if kept else ""
