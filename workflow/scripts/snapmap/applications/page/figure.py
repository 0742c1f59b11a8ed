"""The page to explore a cube: maps over two of its axes, and any shock followed by the page."""

import base64
import html
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import to_hex
from plotly.offline import get_plotlyjs

from ...config.devices import read_device
from ...config.shocks import shocks_of
from ...config.vibrations import vibrations
from ...device.device import STOPS, VALUES
from ...figures import captions, scales, states
from ...files.text import leaves
from ...pulse.shocks import HANDOUT_SHOCK
from ...solver.outcome import OUTCOMES, WHOLE_SWING
from ...solver.settings import FIRST, SECOND, STARTS
from ...study.axes import KIND_OF, NAMES, SHOCK_AXES
from ...study.provenance import config_of
from ...study.study import Study
from ...sweeps.cube import thin
from ...values.units import is_plain, of_file, spelling
from ..requirements.verdict import Verdict
from .forms import LIMITS, NUMBERS, forms, pulses

HERE = Path(__file__).parent
MIXED = "some guided, some free to tilt"
STRUCK = {
    "": "is struck by a mass when the frame is shaken by one pulse of acceleration",
    "alone": "is shaken with its frame by one pulse of acceleration",
    "alone pushed": "is pushed at its midpoint by one pulse of force, of which N is the peak",
}
"""Words for what the pulse does, by the kind of the drawing."""
WORDS = {
    "unsnapped": "no snap, end not known",
    "never": "settles without a snap",
    "snapped": "snaps, end not known",
    "latched": "snaps and settles there",
    "returned": "snaps and settles back",
    "failed": "failed",
    "absent": "no second stable shape",
}
"""Words for each outcome, in the order of the codes."""
GREY = "#999999"
"""Colour of absent cells, which printed maps leave white and hatched."""
RAMP = [to_hex(colour) for colour in states.TIME_COLOURS(np.linspace(0, 1, 9))]
"""Colours of snap times, from the first to the last."""
SYMBOLS = {"span": "L", "rise": "δ", "thickness": "t", "mass": "M", "spring": "K"}
"""Symbols in the drawing of the device."""
OWN = {
    "beam.quality_factor": "quality factor of the beam",
    "quality_factor": "quality factor of the mass",
}
"""Words for values that only a config has."""
EDGES = ("N_first", "N_error", "N_always")
TOO_LONG = "This shock has too many samples to be followed here; histories in the config follow it."
OF_LAWS = "This page does not know the laws of the study, so it follows no shock."
"""Reasons why the page does not follow a shock."""
TITLE = "Which shock trips the sensor?"
"""Title of a study without one."""


def page(
    cube: xr.Dataset,
    thresholds: xr.Dataset,
    shown: Mapping[str, Any],
    verdicts: Sequence[Verdict] = (),
) -> str:
    """Write a cube and its thresholds as one HTML page that needs nothing else.

    thresholds: they include the points of the cube
    shown: what the cube does not hold, as `Page.figures` gives it:
        horizon: time followed after the pulse, us
        written: sections of the devices by name, as the user has them
        title: of the study; pulse: its section, as in `Config`; empty for the handout's
        required: shocks to mark: name, f0 (Hz), N, and shape and direction of each of its pulses
    verdicts: of which the page tells the worst of each of these shocks
    """
    cells, document = thin(cube), config_of(cube.attrs)
    dims, devices = cells.outcome.dims, _devices(document)
    thresholds = thresholds.sel({key: cells[key] for key in dims[:-1]})
    data = _data(cells, thresholds, document, shown, verdicts)
    sizes = {key: (cells.sizes[key], cube.sizes[key]) for key in dims}
    kept = [f"{few} of {many} {key}" for key, (few, many) in sizes.items() if few < many]
    thinned = " and ".join(filter(None, [", ".join(kept[:-1]), *kept[-1:]]))
    model, kind = document["model"], _kind_of(devices)
    return Template(_text("explore.html")).substitute(
        plotly=get_plotlyjs(),
        title=html.escape(shown["title"] or TITLE),
        ends=", or where it ends" if "well" in cells else "",
        drawing=_text("device.svg"),
        drawn=" ".join([kind, *_lacking(devices, dims, document)]),
        struck=STRUCK[kind],
        data=json.dumps(data, allow_nan=False).replace("</", "<\\/"),
        code="\n".join(map(_text, ("simulate.js", "explore.js"))),
        thinned=f"Shown are {thinned} of the cube. " if kept else "",
        unfollowed=" hidden" if "laws" in model else "",
        model=html.escape(
            " with ".join(str(model[key]) for key in ("name", "laws") if key in model)
        ),
        guide=", ".join([*(captions.guides(document) or [MIXED]), *captions.starts(document)]),
        version=html.escape(cube.attrs["code_version"]),
    )


def _devices(document):
    """Sections of the devices of a config by name, "" for a single one."""
    return document.get("devices", {"": document.get("device", {})})


def _data(cells, thresholds, document, shown, verdicts):
    """What the script of the page reads; arguments as those of `page`."""
    dims, devices, (x, y) = cells.outcome.dims, _devices(document), _plane(cells)
    has_laws = "laws" in document["model"]
    dampers = [None if has_laws else [C] for C in cells.C.values.tolist()]
    return {
        "axes": [_axis(cells, key) for key in dims],
        "x": x,
        "y": y,
        "start": _opening(cells, x, y),
        "horizon": float(shown["horizon"]),
        "shapes": STARTS[::-1] if captions.starts(document) else STARTS,
        "devices": {
            html.escape(name): [*_rows(shown["written"][name or "device"])] for name in devices
        },
        "vibrations": {
            html.escape(name): [_vibration(device, C) for C in dampers]
            for name, device in devices.items()
        },
        "varied": [(key, _named(key)) for key in dims if key in VALUES],
        "views": _views(cells),
        "wide": states.WIDE,
        "outcomes": [{"name": name, "words": WORDS[name]} for name in OUTCOMES],
        "whole": WHOLE_SWING,
        "required": [
            (html.escape(name), *place, html.escape(_worst(name, verdicts)))
            for name, *place in shown["required"]
        ],
        "unfollowed": OF_LAWS if has_laws else TOO_LONG,
        "arrays": {key: _pack(values) for key, values in _arrays(cells, thresholds).items()},
        **_simulation(cells, document, shown["pulse"]),
    }


def _worst(name, verdicts):
    """Write the worst verdict on a required shock, and how the beam ends there; "" without one."""
    of_shock = [verdict for verdict in verdicts if verdict.requirement == name]
    if not of_shock:
        return ""
    worst = max(of_shock, key=lambda verdict: verdict.badness)
    return f"{worst.verdict}: {worst.end_text}, at worst ({worst.corner})"


def _simulation(cells, document, pulse):
    """Data with which the page follows shocks."""
    axes = {key: cells[key].values for key in cells.outcome.dims}
    names = {key: axes.pop(key).tolist() for key in NAMES if key in axes}
    shocks = shocks_of(pulse) if pulse else HANDOUT_SHOCK
    devices = {name: read_device(section) for name, section in _devices(document).items()}
    device = devices.get("", devices)
    study = Study(device, pulse=shocks.pulse, direction=shocks.direction, skip=True).part(names)
    grid, start = study.set_out(axes), captions.starts(document)
    table, known = forms(grid, SECOND if start else FIRST), pulses(study)
    for pulse in known:
        pieces = None if "laws" in document["model"] else pulse["pieces"]
        pulse["pieces"] = None if pieces is None else _pack(pieces, np.float64)
    return {
        "side": -1 if start else 1,
        "names": NUMBERS,
        "limits": LIMITS,
        "width": table.shape[1],
        "forms": _pack(table, np.float64),
        "deviceOf": grid.device_of.ravel().tolist(),
        "pulses": known,
    }


def _text(name):
    return (HERE / name).read_text(encoding="utf-8")


def _plane(cells):
    """Names of the axes to the right and upward: f0 and N, or the longest others in their place."""
    several = [key for key in cells.outcome.dims if cells.sizes[key] > 1]
    longest = sorted(several, key=cells.sizes.get, reverse=True)
    x = next((key for key in ("f0", *longest) if key in several and key != "N"), "f0")
    y = next((key for key in ("N", *longest) if key in several and key != x), "N")
    return x, y


def _axis(cells, key):
    """An axis for the page: places of its values, texts, unit and scale."""
    words, scale = scales.WORDS[key], scales.scale_of(key, cells[key].values)
    unit = spelling(of_file(cells[key].attrs["units"])).page if key in KIND_OF else ""
    every = -(-scale.values.size // scales.SEVERAL)
    label = scales.axis_label(key, cells.attrs) if key == "N" else scales.LABELS[key]
    lead = f"{words} ".lstrip() if key in NAMES else f"{_typeset(words)} = "
    return {
        "name": key,
        "label": _typeset(label),
        "unit": unit,
        "lead": lead,
        "values": scale.places.tolist(),
        "edges": scale.edges.tolist(),
        "texts": [_say(value, unit) for value in scale.values.tolist()],
        "type": "log" if scale.is_log else "linear",
        # Names and single values have a tick each.
        "ticked": every if scale.is_counted or scale.values.size == 1 else 0,
        "bare": [_say(value) for value in scale.values.tolist()],
        "numbers": cells[key].values.tolist() if key in SHOCK_AXES else [],
    }


def _say(value, unit=""):
    """Write a number with four digits and a unit, or a name, as HTML."""
    if isinstance(value, str) or np.isinf(value):
        return html.escape(scales.number(value))
    digits = {"precision": 4, "fractional": False, "trim": "-"}
    tiny = 0 < abs(value) < 1e-4
    text = f"{value:.4g}" if tiny else np.format_float_positional(value, **digits)
    return f"{text}\u00a0{unit}" if unit else text


def _typeset(text):
    """Write a text with formulas in dollars as HTML."""
    return re.sub(r"_(\w)", r"<sub>\1</sub>", text.replace("$", ""))


def _kind_of(devices):
    """The key of STRUCK: whether all devices are a beam alone, and pushed at the midpoint."""
    if any(device.get("mass") != "none" for device in devices.values()):
        return ""
    return "alone pushed" if all("force" in device for device in devices.values()) else "alone"


def _lacking(devices, dims, document):
    """Classes of the drawing: parts that no device or axis has, and a start in the second shape."""
    named = {*dims}.union(*devices.values())
    parts = {"stops": {*STOPS}, "gap": {"gap"}}
    lacking = [f"without-{part}" for part, names in parts.items() if not names & named]
    return [*lacking, "second"] if captions.starts(document) else lacking


def _rows(section):
    """Yield key, words, and value with its unit for each row of the table of a device."""
    for path, text in leaves(section):
        number, _, unit = text.partition(" ")
        if is_plain(number) and unit:
            text = f"{number}\u00a0{spelling(unit).page}"
        yield path.rpartition(".")[2], _named(path), html.escape(text)


def _vibration(device: Mapping, C: Sequence[float] | None):
    """Rows of the natural vibrations of beam and mass: name, frequency and quality factor."""
    return [
        [html.escape(text.replace("uN*us/um", "µN µs/µm")) for text in row]
        for row in vibrations(read_device(device), C)
    ]


def _named(path):
    """Write the words for a value of the device, with its symbol, as HTML."""
    name = path.rpartition(".")[2]
    words = OWN.get(path) or scales.WORDS.get(name) or name.replace("_", " ")
    return f"{html.escape(words)} <i>{SYMBOLS[name]}</i>" if name in SYMBOLS else html.escape(words)


def _views(cells):
    """Describe the views of the map: whether cells snap, when, and, if known, where they end.

    A view has a name and words; states, and the name of the array of their codes; and a colour
    scale for plotly. In the view of times RAMP replaces the colour of `snaps`.
    """
    times = (states.WAITING, *states.SNAPS[1:])
    shown = [("snap", "snaps", "snap", states.SNAPS), ("time", "time", "snap", times)]
    if "well" in cells:
        shown.append(("end", "where it ends", "end", states.STATES))
    views = []
    for name, words, code, (*known, absent) in shown:
        known = [*known, absent._replace(colour=GREY)]
        colours = [[state.colour] * 2 for state in known]
        view = {"name": name, "words": words, "code": code}
        if name == "time":
            colours[1] = view["ramp"] = RAMP
        view["scale"] = [
            ((place + share) / len(colours), colour)
            for place, ramp in enumerate(colours)
            for share, colour in zip(np.linspace(0, 1, len(ramp)).tolist(), ramp, strict=True)
        ]
        views.append(view | {"states": [state._asdict() for state in known]})
    return views


def _opening(cells, x, y):
    """Choose the first cell, by its place on each axis: at a threshold, near the middle of x and y.

    If possible, the cell snaps, the cell below it does not, and another step ends alike.
    """
    dims, snaps = cells.outcome.dims, np.isfinite(cells.t_snap.values)
    known = ~np.isin(cells.outcome.values, (OUTCOMES.index("failed"), OUTCOMES.index("absent")))
    along = np.moveaxis(known & ~snaps, dims.index(y), 0)
    below = np.moveaxis(np.concatenate([np.zeros_like(along[:1]), along[:-1]]), 0, dims.index(y))
    first = snaps & below
    sure = states.end_states(cells).values != states.ELSEWHERE if "well" in cells else known
    choice = next(mask for mask in (first & sure, first, known, ~known) if mask.any())
    places, size = np.argwhere(choice), np.array(choice.shape)
    off = ((places - (size - 1) / 2) / size) ** 2
    drawn = np.isin(dims, (x, y))
    nearest = np.lexsort([off[:, drawn].sum(axis=1), off[:, ~drawn].sum(axis=1)])[0]
    return places[nearest].tolist()


def _arrays(cells, thresholds):
    """Arrays over the cells, (*axes), and thresholds, (*axes without N), by name."""
    dims = cells.outcome.dims
    unknown = xr.full_like(cells.t_snap, np.nan)
    columns = {
        "snap": states.snap_states(cells),
        **({"end": states.end_states(cells)} if "well" in cells else {}),
        "outcome": cells.outcome,
        "well": cells.get("well", xr.zeros_like(cells.outcome)),
        "t_snap": cells.t_snap,
        "t_settled": cells.t_settled,
        "share": cells.get("well_share", xr.ones_like(cells.t_snap)),
        "work_error": cells.get("work_error", unknown),
        "t_snap_error": cells.get("t_snap_error", unknown),
        **{key: thresholds[key].transpose(*dims[:-1]) for key in EDGES},
    }
    return {key: column.values for key, column in columns.items()}


def _pack(values, number=None):
    """Pack an array as text: codes in a byte each, numbers in four or as the type `number`."""
    number = number or (np.float32 if values.dtype.kind == "f" else np.uint8)
    packed = zlib.compress(np.ascontiguousarray(values, number).tobytes(), level=6)
    return {"kind": number.__name__, "bytes": base64.b64encode(packed).decode()}
