"""The page to explore a cube: the map of any C, and behind each cell its history."""

import base64
import html
import json
import zlib
from pathlib import Path
from string import Template

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..quantity import read
from .maps import COLOURS, WORDS, arithmetic_edges, geometric_edges

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
TRACED = ("w_low", "w_high", "z_mass", "energy", "beam_energy")
FACTS = ("t_snap", "t_settled")


def page(cube: xr.Dataset, traces: xr.Dataset) -> str:
    """Write a cube and its packed traces as one HTML page that needs nothing else.

    traces: as `traces.trace` gives them; where they are thinned, so is the map
    """
    cells = cube.sel({key: traces[key] for key in ("C", "f0", "N")})
    document = json.loads(cube.attrs["config"])
    return Template(_text("explore.html")).substitute(
        map=_figure(_map(cells), "map", "432px", include_plotlyjs=True),
        history=_figure(_history(traces), "history", "480px", include_plotlyjs=False),
        data=json.dumps(_data(cells, traces, document), allow_nan=False).replace("</", "<\\/"),
        code=_text("explore.js"),
        thinned=_thinning(cube, cells),
        model=html.escape(document["model"]["name"]),
        version=html.escape(cube.attrs["code_version"]),
    )


def _text(name):
    return (HERE / name).read_text(encoding="utf-8")


def _figure(figure, name, height, include_plotlyjs):
    place = {"full_html": False, "div_id": name, "default_height": height}
    figure.update_layout(PLAIN)
    return figure.to_html(config=BUTTONS, include_plotlyjs=include_plotlyjs, **place)


def _map(cells):
    """The map without its cells, which the page fills in for the chosen C."""
    x, y = geometric_edges(cells.f0.values), arithmetic_edges(cells.N.values)
    colours = list(COLOURS.values())
    steps = np.repeat(np.arange(len(colours) + 1) / len(colours), 2)[1:-1]
    heatmap = go.Heatmap(
        x=x.tolist(),
        y=y.tolist(),
        zmin=-0.5,
        zmax=len(colours) - 0.5,
        colorscale=list(zip(steps, np.repeat(colours, 2).tolist(), strict=True)),
        showscale=False,
        hovertemplate="%{text}<extra></extra>",
    )
    bare = {"mode": "markers", "hoverinfo": "skip", "showlegend": False}
    apart = {"symbol": "line-ne-open", "size": 5, "color": "#333333"}
    chosen = {"symbol": "circle-open", "size": 15, "color": "black", "line": {"width": 2}}
    halo = {**chosen, "color": "white", "line": {"width": 5}}
    marks = [go.Scatter(**bare, marker=marker) for marker in (apart, halo, chosen)]
    frequency = {"title": "pulse frequency f<sub>0</sub> (Hz)", "type": "log"}
    amplitude = {"title": "pulse amplitude N (multiples of g)"}
    return go.Figure([heatmap, *marks]).update_layout(
        xaxis={**frequency, "range": np.log10(x[[0, -1]]).tolist(), "exponentformat": "none"},
        yaxis={**amplitude, "range": y[[0, -1]].tolist()},
        margin=MARGIN,
    )


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
    w_2 = traces.attrs["second_equilibrium"]
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
        legend_entrywidth=100,
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


def _data(cells, traces, document):
    """All that the page knows of the cells, as JSON; arrays (C, f0, N) or (C, f0, N, bin)."""
    outcome = cells.outcome
    reproduced = cells.reproduced if "reproduced" in cells else xr.ones_like(outcome)
    packed = {key: traces[key].transpose("C", "f0", "N", "bin") for key in TRACED}
    arrays = {"outcome": outcome, "reproduced": reproduced, **packed}
    facts = {key: cells[key] for key in FACTS} | {"bin_length": traces.bin_length}
    return {
        "axes": {key: cells[key].values.tolist() for key in ("C", "f0", "N")},
        "outcomes": [
            {"name": name, "words": WORDS[name], "colour": COLOURS[name]}
            for name in outcome.attrs["flag_meanings"].split()
        ],
        "bins": traces.sizes["bin"],
        "missing": int(packed["energy"].attrs["_FillValue"]),
        "packing": {
            key: [float(array.attrs[name]) for name in ("scale_factor", "add_offset")]
            for key, array in packed.items()
        },
        "horizon": read(document["sweep"]["horizon"], "duration"),
        "arrays": {key: _pack(array, np.uint8) for key, array in arrays.items()}
        | {key: _pack(array, np.float32) for key, array in facts.items()},
    }


def _pack(array, kind):
    whole = zlib.compress(np.ascontiguousarray(array.values.astype(kind)).tobytes(), level=9)
    return {"kind": kind.__name__, "bytes": base64.b64encode(whole).decode()}


def _thinning(cube, cells):
    if cells.sizes == cube.sizes:
        return ""
    kept = (f"{cells.sizes[key]} of {cube.sizes[key]} {key}" for key in ("f0", "N"))
    return f"Shown are {' and '.join(kept)} of the cube. "
