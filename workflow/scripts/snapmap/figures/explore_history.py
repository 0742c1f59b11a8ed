"""The figure of a cell's history, which the page fills in, and its legend."""

import plotly.graph_objects as go
import xarray as xr

BAND, BEAM, MASS, TOTAL, AID = "rgba(0, 114, 178, 0.35)", "#0072b2", "#000000", "#d55e00", "#555555"
DASHES = {"dash": "8 4", "dot": "2 2", "dashdot": "8 3 2 3", "longdash": "12 4"}
"""Of plotly's dashes what SVG takes."""
SAMPLE = '<svg width="28" height="12" fill="none" aria-hidden="true">{}</svg>'
LINE = '<path d="M0 6H28" stroke="{}" stroke-width="{}" stroke-dasharray="{}"/>'


def history(traces: xr.Dataset) -> go.Figure:
    """Two axes, of positions and of energies; the curves are as `explore_cells.TRACED`."""
    line = {"mode": "lines", "hovertemplate": "%{y:.3g} at %{x:.3g} ms", "x": [0], "y": [0]}
    edge, band = {"color": BEAM, "width": 0.7}, {"fill": "tonexty", "fillcolor": BAND}
    on_energy = {**line, "yaxis": "y2"}
    curves = [
        go.Scatter(**line, line=edge, name="w(L/2), least"),
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
        showlegend=False,
    )


def legend(figure: go.Figure) -> str:
    """Items of a list of the lines of `history`, which wraps on a phone where plotly's does not."""
    lines = *figure.data[1:], *figure.layout.shapes
    return "".join(f"<li>{_sample(line)} {line.name}</li>" for line in lines)


def _sample(line):
    look = line.line
    parts = [LINE.format(look.color, look.width, DASHES.get(look.dash, "none"))]
    if "fill" in line and line.fill:
        parts.append(LINE.format(BAND, 9, "none"))
    return SAMPLE.format("".join(parts))


def _level(axis, y, name, dash):
    place = {"xref": "x domain", "x0": 0, "x1": 1, "yref": axis, "y0": y, "y1": y}
    return _mark(name, dash, place)


def _instant(name, dash):
    place = {"xref": "x", "x0": 0, "x1": 0, "yref": "paper", "y0": 0, "y1": 1}
    return _mark(name, dash, place)


def _mark(name, dash, place):
    line = {"color": AID, "width": 1.2, "dash": dash}
    return {"type": "line", "line": line, "opacity": 1, "name": name, **place}
