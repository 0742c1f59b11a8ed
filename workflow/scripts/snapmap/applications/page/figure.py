"""The page to explore a cube: maps over two of its axes, and any shock followed by the page."""

import base64
import html
import json
import re
import zlib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.ticker import LogLocator, MaxNLocator

from ...config.devices import read_device
from ...config.points import Point
from ...device.device import VALUES
from ...figures import captions, plane, scales, states
from ...files.text import leaves
from ...pulse.shocks import make_shocks
from ...solver.coefficients import coefficients
from ...solver.kernel import rows as R
from ...solver.models import build_model
from ...solver.options import Cosines
from ...solver.outcome import OUTCOMES
from ...solver.settings import FIRST, SECOND, STARTS, Run
from ...study.axes import KIND_OF, NAMES, SHOCK_AXES, Grid, rows_of
from ...study.provenance import config_of
from ...study.study import Study
from ...sweeps.cube import thin
from ...values.units import is_plain, of_file, spelling
from ..requirements.verdict import Verdict

COSINES = 5
MOST_PIECES = 20_000
"""Most pieces of a pulse that the page follows; a longer record would double its size."""
OF_DEVICE = ("modes", "first", "second", "gravity", "factor", "held")
"""Numbers of a device before those of the kernel: C is `held` + `factor` times that of a shock."""
KERNEL = ("AXIAL", "RESIDUAL", "CONTACT", "M", "K", "TARGET", "BARRIER", "SADDLE", "Z0", "ALPHA")
OF_STOPS = "STOP_TOWARD", "STOP_AWAY", "RESTITUTION", "SIDE"
PLACES = {name: place for place, name in enumerate(OF_DEVICE)}
PLACES |= {name: len(OF_DEVICE) + getattr(R, name) for name in (*KERNEL, *OF_STOPS)}
PLACES["vectors"] = len(OF_DEVICE) + R.SIDE + 1
"""Place of each number, and of the first vector, in a row of `forms`."""


def forms(grid: Grid, start: str) -> tuple[np.ndarray, np.ndarray]:
    """Tabulate the devices of a grid, and the time step of each of its points, us; start: of `Run`.

    The rows of the table, (devices, n), are OF_DEVICE and then `coefficients`, and end in
    zeros if other devices have more modes. Steps are those of a history, NaN without a device.
    """
    model = build_model(grid.device, Cosines(modes=COSINES))
    cells = rows_of(grid).cells(grid.device, grid.axes["N"], horizon=0.0).flat()
    table, steps = np.zeros((len(grid.device), 0)), np.full(cells.device.size, np.nan)
    exists = np.flatnonzero(cells.device >= 0)
    for members, part in model.split(np.arange(len(grid.device))):
        rows = _tabulated(part, start)[members]
        more = max(0, rows.shape[1] - table.shape[1])
        table = np.pad(table, ((0, 0), (0, more)))
        table[members, : rows.shape[1]] = rows
        mine = exists[members[cells.device[exists]]]
        steps[mine] = part.time_steps(cells.take(mine), Run(start=start).but(until="moved"))
    return table, steps.reshape(grid.shape)


def _tabulated(model, start):
    device, barrier = model.device, model.barrier
    # Without a mass, a damper of 1 keeps the equation of y solvable.
    factor = np.where(device.is_alone, 0.0, device.damper_factor)
    own = model.modes, barrier.first, barrier.second, device.gravity, factor, device.is_alone
    columns = [np.broadcast_to(number, len(device)) for number in own]
    known = coefficients(model, model.snap_target(start), start)
    return np.hstack([np.stack(columns, axis=1), known])


def pulses(study: Study) -> list[dict]:
    """Describe each pulse of a study for the page; `pieces` is None if there are too many."""
    return [
        {
            "shape": shocks.pulse.name,
            "direction": shocks.direction,
            "pieces": pulse.pieces if len(pulse.pieces) <= MOST_PIECES else None,
            "ends": pulse.ends,
        }
        for shocks, pulse in zip(study.shocks.each(), study.shocks.pulses, strict=True)
    ]


HERE = Path(__file__).parent
MIXED = "some guided, some free to tilt"
GREY = "#999999"
"""Colour of absent cells, which printed maps leave white and hatched."""
FACES = {True: "black", False: "white", None: "grey"}
"""Colour of a user's own point, by whether it tripped."""
SYMBOLS = {"span": "L", "rise": "δ", "thickness": "t", "mass": "M", "spring": "K"}
"""Symbols in the drawing of the device."""
OWN = {
    "beam.quality_factor": "quality factor of the beam",
    "quality_factor": "quality factor of the mass",
}
"""Words for values that only a config has."""
EDGES = ("N_first", "N_error", "N_always")
SUBS, TICKS = ((1, 2, 5), (1, 3), (1,)), 5
"""Digits that have ticks in a decade, densest choice first, and the most ticks for a phone."""
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
    points: Sequence[Point] = (),
) -> str:
    """Write a cube and its thresholds as one HTML page that needs nothing else.

    thresholds: they include the points of the cube
    shown: what the cube does not hold, as `Page.figures` gives it:
        horizon: time followed after the pulse, us
        written: sections of the devices by name, as the user has them
        title: of the study; pulse: its section, as in `Config`; empty for the handout's
        required: shocks to mark: name, f0 (Hz), N, and shape and direction of each of its pulses
    verdicts: of which the page tells the worst of each of these shocks
    points: a user's own
    """
    cells, document = thin(cube), config_of(cube.attrs)
    dims, devices = cells.outcome.dims, _devices(document)
    thresholds = thresholds.sel({key: cells[key] for key in dims[:-1]})
    data = _data(cells, thresholds, document, shown) | _marks(cells, shown, verdicts, points)
    sizes = {key: (cells.sizes[key], cube.sizes[key]) for key in dims}
    kept = [f"{few} of {many} {key}" for key, (few, many) in sizes.items() if few < many]
    model, starts = document["model"], captions.starts(document)
    return Template(_text("explore.html")).substitute(
        title=html.escape(shown["title"] or TITLE),
        ends=", or where it ends" if "well" in cells else "",
        drawing=_text("device.svg"),
        drawn=" ".join([_kind_of(devices), *(["second"] if starts else [])]),
        data=json.dumps(data, allow_nan=False).replace("</", "<\\/"),
        code="\n".join(map(_text, ("simulate.js", "explore.js"))),
        thinned=f"Shown of the cube: {', '.join(kept)}. " if kept else "",
        unfollowed=" hidden" if "laws" in model else "",
        model=html.escape(
            " with ".join(str(model[key]) for key in ("name", "laws") if key in model)
        ),
        guide=", ".join([*(captions.guides(document) or [MIXED]), *starts]),
        version=html.escape(cube.attrs["code_version"]),
    )


def _devices(document):
    """Sections of the devices of a config by name, "" for a single one."""
    return document.get("devices", {"": document.get("device", {})})


def _data(cells, thresholds, document, shown):
    """What the script of the page reads; arguments as those of `page`."""
    dims, devices, (x, y) = cells.outcome.dims, _devices(document), _plane(cells)
    has_laws = "laws" in document["model"]
    library = (files("plotly") / "package_data" / "plotly.min.js").read_bytes()
    starts = STARTS[::-1] if captions.starts(document) else STARTS
    simulation = _simulation(cells, document, shown["pulse"])
    arrays = _arrays(cells, thresholds) | simulation.pop("arrays")
    return {
        "axes": [_axis(cells, key) for key in dims],
        "x": x,
        "y": y,
        "durations": _durations(cells.f0.values) if x == "f0" else None,
        "at": _opening(cells, y),
        "horizon": float(shown["horizon"]),
        "shapes": starts,
        "devices": {
            html.escape(name): [*_rows(shown["written"][name or "device"])] for name in devices
        },
        "varied": [(key, _named(key)) for key in dims if key in VALUES],
        "views": _views(cells),
        "unfollowed": OF_LAWS if has_laws else TOO_LONG,
        "plotly": _pack(np.frombuffer(library, np.uint8)),
        "arrays": {key: _pack(values) for key, values in arrays.items()},
        **simulation,
    }


def _marks(cells, shown, verdicts, points):
    """Required shocks and a user's own points, if f0 and N span the map; arguments as of `page`."""
    if _plane(cells) != ("f0", "N") or 1 in (cells.f0.size, cells.N.size):
        shown, points = {"required": ()}, ()
    required = [
        _required(cells, number, *shock, _worst(shock[0], verdicts))
        for number, shock in enumerate(shown["required"], start=1)
    ]
    kinds = dict.fromkeys(point.snapped for point in points)
    own = {key: [getattr(point, key) for point in points] for key in ("f0", "N")}
    own["face"] = [FACES[point.snapped] for point in points]
    own["keys"] = [_key(FACES[tripped], plane.POINT_WORDS[tripped]) for tripped in kinds]
    return {"required": required, "points": own}


def _required(cells, number, name, f0, N, pushed, verdict):
    """Describe a required shock: its number on the map, at the edge if it lies beyond; its key."""
    across = [scales.scale_of(key, cells[key].values) for key in ("f0", "N")]
    (left, right), (low, high) = (scale.edges[[0, -1]] for scale in across)
    place = np.clip([f0, N], [left, low], [right, high])
    x, y = (np.log10(at) if of.is_log else at for at, of in zip(place, across, strict=True))
    # The number stands beside its place, towards the middle of the map.
    aside = {"ax": -18 if f0 >= right else 18, "ay": -18 if low >= N else 18}
    words = f"{number}: required shock {name}, N = {_say(N)}, {_say(f0)} Hz"
    words += "" if place.tolist() == [f0, N] else " (beyond the map)"
    words += f"; {verdict}" if verdict else ""
    mark = {"text": str(number), "x": float(x), "y": float(y), **aside}
    return {"pushed": pushed, "mark": mark, "words": html.escape(words)}


def _key(colour, words):
    return f'<i style="background:{colour}"></i>{words}'


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
    shocks = make_shocks(pulse)
    devices = {name: read_device(section) for name, section in _devices(document).items()}
    device = devices.get("", devices)
    study = Study(device, pulse=shocks.pulse, direction=shocks.direction, skip=True).part(names)
    grid = study.set_out(axes)
    table, steps = forms(grid, SECOND if captions.starts(document) else FIRST)
    known = pulses(study)
    for pulse in known:
        pieces = None if "laws" in document["model"] else pulse["pieces"]
        pulse["pieces"] = None if pieces is None else _pack(pieces)
    return {
        "places": PLACES,
        "width": table.shape[1],
        "deviceOf": grid.device_of.ravel().tolist(),
        "pulses": known,
        "arrays": {"forms": table, "dt": steps},
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
    """An axis for the page: places of its values, texts, ticks and scale."""
    words, scale = scales.WORDS[key], scales.scale_of(key, cells[key].values)
    # Old versions of xarray lose attributes of axes on the way.
    kind, written = KIND_OF.get(key), cells[key].attrs.get("units")
    unit = spelling(of_file(written) if written else kind.unit).page if kind else ""
    label = _typeset(scales.axis_label(key, cells.attrs) if key == "N" else scales.LABELS[key])
    values = scale.values.tolist()
    ticks = {"tickvals": _round_between(*scale.edges[[0, -1]], scale.is_log)}
    ticks["ticktext"] = [_say(value) for value in ticks["tickvals"]]
    if scale.is_counted or len(values) == 1:  # names and single values have a tick each
        every = slice(None, None, -(-len(values) // scales.SEVERAL))
        ticks = {"tickvals": scale.places[every].tolist(), "ticktext": [*map(_say, values[every])]}
    return {
        "name": key,
        "label": label,
        "title": f"{label} ({unit})" if unit else label,
        "unit": unit,
        "lead": f"{words} ".lstrip() if key in NAMES else f"{_typeset(words)} = ",
        "values": scale.places.tolist(),
        "edges": scale.edges.tolist(),
        "texts": [_say(value, unit) for value in values],
        "type": "log" if scale.is_log else "linear",
        "ticks": ticks,
        "numbers": values if key in SHOCK_AXES else [],
    }


def _round_between(low, high, is_log=True):
    """List round numbers between the ends of an axis, few enough for a phone."""
    locators = [LogLocator(subs=subs) for subs in SUBS] if is_log and high > 4 * low else []
    locators.append(MaxNLocator(TICKS - 1, steps=[1, 2, 5, 10]))
    for locator in locators:
        ticks = locator.tick_values(low, high)
        ticks = ticks[(low <= ticks) & (ticks <= high)].tolist()
        if len(ticks) <= TICKS:
            break
    return ticks


def _durations(f0):
    """Give the ticks of durations (ms) on an axis of frequencies (Hz)."""
    edges = 1e3 / scales.scale_of("f0", f0).edges
    ticks = _round_between(edges[-1], edges[0]) if f0.size > 1 else (1e3 / f0).tolist()
    return {"tickvals": [1e3 / tick for tick in ticks], "ticktext": [*map(_say, ticks)]}


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
    """Classes of the drawing: whether all devices are a beam alone, and pushed at the midpoint."""
    if any(device.get("mass") != "none" for device in devices.values()):
        return ""
    return "alone pushed" if all("force" in device for device in devices.values()) else "alone"


def _rows(section):
    """Yield key, words, and value with its unit for each row of the table of a device."""
    for path, text in leaves(section):
        number, _, unit = text.partition(" ")
        if is_plain(number) and unit:
            text = f"{number}\u00a0{spelling(unit).page}"
        yield path.rpartition(".")[2], _named(path), html.escape(text)


def _named(path):
    """Write the words for a value of the device, with its symbol, as HTML."""
    name = path.rpartition(".")[2]
    words = OWN.get(path) or scales.WORDS.get(name) or name.replace("_", " ")
    return f"{html.escape(words)} <i>{SYMBOLS[name]}</i>" if name in SYMBOLS else html.escape(words)


def _views(cells):
    """Describe the views of the map: whether cells snap, and, if known, where they end.

    A view has a name, that of the array of its codes, and words; states, each with its key; and a
    colour scale for plotly.
    """
    shown = [("snap", "snaps", states.SNAPS)]
    if "well" in cells:
        shown.append(("end", "where it ends", states.STATES))
    views = []
    for name, words, (*known, absent) in shown:
        known = [*known, absent._replace(colour=GREY)]
        ends = [(place + end, state) for place, state in enumerate(known) for end in (0, 1)]
        scale = [(end / len(known), state.colour) for end, state in ends]
        named = [
            {**state._asdict(), "key": _key(state.colour, html.escape(state.words))}
            for state in known
        ]
        views.append({"name": name, "words": words, "scale": scale, "states": named})
    return views


def _opening(cells, y):
    """Choose the first cell, by its place on each axis: at a threshold, near the middle.

    If possible, the cell snaps, the cell below it does not, and another step ends alike.
    """
    dims, snaps = cells.outcome.dims, cells.t_snap.notnull()
    known = ~cells.outcome.isin([OUTCOMES.index("failed"), OUTCOMES.index("absent")])
    first = snaps & (known & ~snaps).shift({y: 1}, fill_value=False)
    sure = states.end_states(cells) != states.ELSEWHERE if "well" in cells else known
    choice = next(mask for mask in (first & sure, first, known, ~known) if mask.any())
    places = np.argwhere(choice.transpose(*dims).values)
    off = (places + 0.5) / cells.outcome.shape - 0.5
    return places[(off**2).sum(axis=1).argmin()].tolist()


def _arrays(cells, thresholds):
    """Arrays over the cells, (*axes), and thresholds, (*axes without N), by name."""
    dims = cells.outcome.dims
    unknown = xr.full_like(cells.t_snap, np.nan)
    columns = {
        "snap": states.snap_states(cells),
        **({"end": states.end_states(cells)} if "well" in cells else {}),
        # A run that ends at its snap settles in its first shape, or not.
        "well": cells.get("well", cells.t_settled.notnull()),
        "t_snap": cells.t_snap,
        "t_settled": cells.t_settled,
        "share": cells.get("well_share", xr.ones_like(cells.t_snap)),
        "work_error": cells.get("work_error", unknown),
        "t_snap_error": cells.get("t_snap_error", unknown),
        **{key: thresholds[key].transpose(*dims[:-1]) for key in EDGES},
    }
    # Times are as exact as they are told.
    return {
        key: column.values.astype(np.float32 if column.dtype.kind == "f" else np.uint8)
        for key, column in columns.items()
    }


def _pack(values):
    """Pack an array as text."""
    packed = zlib.compress(np.ascontiguousarray(values).tobytes(), level=3)
    return {"kind": values.dtype.name, "bytes": base64.b64encode(packed).decode()}
