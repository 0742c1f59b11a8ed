"""The page to explore a cube: maps over two of its axes, and behind each cell its history."""

import base64
import html
import json
import zlib
from pathlib import Path
from string import Template

import numpy as np
import plotly.graph_objects as go
import xarray as xr

from ..axes import DEVICE, DIRECTION, SHAPE
from ..solver.outcome import ABSENT, FAILED
from . import scales, style
from .explore_batch import batch_section
from .maps import COLOURS, WORDS

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
NO_HATCH = {"absent": "#999999"}
"""In place of the white that maps in print hatch."""
NAMES = scales.WORDS | {
    "density": ("density", "ng/µm³"),
    "damping": ("damping of the beam", "1/µs"),
    SHAPE: ("shape of the pulse", ""),
    DIRECTION: ("direction of the shock", ""),
    "C": ("damping of the mass C", "µN\u00a0µs/µm"),
    "f0": ("pulse frequency f<sub>0</sub>", "Hz"),
    "N": ("pulse amplitude N (multiples of g)", ""),
}
"""Of each axis what it is called, and the unit."""
LEADS = {
    DEVICE: "device ",
    SHAPE: "",
    DIRECTION: "along ",
    "C": "C = ",
    "f0": "f<sub>0</sub> = ",
    "N": "N = ",
}
"""What stands before a value of an axis, if not its name."""


def page(
    cube: xr.Dataset, traces: xr.Dataset, horizon: float, made: xr.Dataset | None = None
) -> str:
    """Write a cube and its packed traces as one HTML page that needs nothing else.

    traces: as `envelopes.trace` gives them; where they are thinned, so is the map
    horizon: time for which the cells were followed after the pulse, us
    made: thresholds of devices as made, if there are any
    """
    cells = cube.sel({key: traces[key] for key in cube.outcome.dims})
    document = json.loads(cube.attrs["config"])
    x, y = _plane(cells)
    data = _data(cells, traces, x, y) | {"horizon": float(horizon)}
    return Template(_text("explore.html")).substitute(
        map=_figure(_map(cells, x, y), "map", "432px", include_plotlyjs=True),
        history=_figure(_history(traces), "history", "480px", include_plotlyjs=False),
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


def _plane(cells):
    """Names of the axes to the right and upward: f0 and N, or else the longest others."""
    several = [key for key in cells.outcome.dims if cells.sizes[key] > 1]
    longest = sorted(several, key=cells.sizes.get, reverse=True)
    x = next((key for key in ("f0", *longest) if key in several and key != "N"), "f0")
    y = next((key for key in ("N", *longest) if key in several and key != x), "N")
    return x, y


def _axis(cells, key):
    """An axis as the page knows it: where its values stand, and their texts."""
    label, unit = NAMES[key]
    values = cells[key].values
    return {
        "name": key,
        "label": label,
        "lead": LEADS.get(key, f"{label} = "),
        "values": scales.scale_of(key, values).places.tolist(),
        "texts": [_say(value, unit) for value in values.tolist()],
    }


def _say(value, unit=""):
    if isinstance(value, str) or np.isinf(value):
        return html.escape(scales.number(value))
    tiny = 0 < abs(value) < 1e-4
    digits = {"precision": 4, "fractional": False, "trim": "-"}
    text = f"{value:.4g}" if tiny else np.format_float_positional(value, **digits)
    return f"{text}\u00a0{unit}" if unit else text


def _layout(scale):
    """The layout of an axis of the map; values that are no numbers, or one alone, are ticked."""
    label, unit = NAMES[scale.key]
    title = f"{label} ({unit})" if unit else label
    ends = np.log10(scale.edges[[0, -1]]) if scale.is_log else scale.edges[[0, -1]]
    kind = {"type": "log" if scale.is_log else "linear", "exponentformat": "none"}
    layout = {"title": title, "range": ends.tolist(), **kind}
    if scale.is_counted or scale.values.size == 1:
        every = -(-scale.values.size // scales.SEVERAL)
        texts = [_say(value) for value in scale.values[::every].tolist()]
        layout |= {"tickvals": scale.places[::every].tolist(), "ticktext": texts}
    return layout


def _colours(cells):
    """The colour of each outcome by its name, in the order of the codes."""
    names = cells.outcome.attrs["flag_meanings"].split()
    return {name: (COLOURS | NO_HATCH)[name] for name in names}


def _map(cells, x, y):
    """The map without its cells, which the page fills in for the chosen values of other axes."""
    right, up = (scales.scale_of(key, cells[key].values) for key in (x, y))
    colours = list(_colours(cells).values())
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
    bare = {"mode": "markers", "hoverinfo": "skip", "showlegend": False}
    apart = {"symbol": "line-ne-open", "size": 5, "color": "#333333"}
    chosen = {"symbol": "circle-open", "size": 15, "color": "black", "line": {"width": 2}}
    halo = {**chosen, "color": "white", "line": {"width": 5}}
    marks = [go.Scatter(**bare, marker=marker) for marker in (apart, halo, chosen)]
    figure = go.Figure([heatmap, *marks])
    return figure.update_layout(xaxis=_layout(right), yaxis=_layout(up), margin=MARGIN)


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


def _data(cells, traces, x, y):
    """All that the page knows of the cells, as JSON; arrays (*axes) or (*axes, bin)."""
    outcome, dims = cells.outcome, cells.outcome.dims
    reproduced = cells.reproduced if "reproduced" in cells else xr.ones_like(outcome)
    packed = {key: traces[key].transpose(*dims, "bin") for key in TRACED}
    arrays = {"outcome": outcome, "reproduced": reproduced, **packed}
    facts = {key: cells[key] for key in FACTS} | {
        "bin_length": traces.bin_length.transpose(*dims),
        "second": traces.second_equilibrium.broadcast_like(outcome).transpose(*dims),
    }
    return {
        "axes": [_axis(cells, key) for key in dims],
        "x": x,
        "y": y,
        "start": _opening(cells, x, y),
        "outcomes": [
            {"name": name, "words": WORDS[name], "colour": colour}
            for name, colour in _colours(cells).items()
        ],
        "bins": traces.sizes["bin"],
        "missing": int(packed["energy"].attrs["_FillValue"]),
        "packing": {
            key: [float(array.attrs[name]) for name in ("scale_factor", "add_offset")]
            for key, array in packed.items()
        },
        "arrays": {key: _pack(array, np.uint8) for key, array in arrays.items()}
        | {key: _pack(array, np.float32) for key, array in facts.items()},
    }


def _opening(cells, x, y):
    """Place on each axis of the cell to begin with: at a change of label, near the middle."""
    dims, snaps = cells.outcome.dims, np.isfinite(cells.t_snap.values)
    known = ~np.isin(cells.outcome.values, (FAILED, ABSENT))
    label = np.where(known, snaps.astype(float), np.nan)
    changes = np.zeros(label.shape, bool)
    for axis in map(dims.index, (x, y)):
        differ = abs(np.diff(label, axis=axis)) == 1
        beside = [[(0, 0)] * label.ndim for _ in range(2)]
        beside[0][axis], beside[1][axis] = (0, 1), (1, 0)
        changes |= np.pad(differ, beside[0]) | np.pad(differ, beside[1])
    choice = next(some for some in (changes & snaps, known, ~known) if some.any())
    places = np.argwhere(choice)
    size = np.array(label.shape)
    off = ((places - (size - 1) / 2) / size) ** 2
    drawn = np.isin(dims, (x, y))
    nearest = np.lexsort([off[:, drawn].sum(axis=1), off[:, ~drawn].sum(axis=1)])[0]
    return places[nearest].tolist()


def _pack(array, kind):
    whole = zlib.compress(np.ascontiguousarray(array.values.astype(kind)).tobytes(), level=9)
    return {"kind": kind.__name__, "bytes": base64.b64encode(whole).decode()}


def _thinning(cube, cells):
    kept = [
        f"{cells.sizes[key]} of {cube.sizes[key]} {key}"
        for key in cube.outcome.dims
        if cells.sizes[key] < cube.sizes[key]
    ]
    *most, last = kept or [""]
    words = f"{', '.join(most)} and {last}" if most else last
    return f"Shown are {words} of the cube. " if kept else ""
