"""The shallow beam beside OpenSees' exact geometry: forces of the path, a threshold, a motion."""

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from snapmap import Study, simulate, statics, threshold
from snapmap.device.device import Device
from snapmap.solver.options import Cosines

from ..common import few, is_small, with_beam
from ..tables import Table
from .opensees import SNAPPED, HalfBeam, load

STEEPER = 1, 3, 6
"""Rise over span, over that of the device."""
PATH_ELEMENTS, SHOCK_ELEMENTS = ((20, 40, 80),) * 2 if is_small() else ((40, 80, 160), (20, 40, 80))
BENT, FAR = (1e-3, 1e-4), 1.95
"""Imperfections, over the rise, by which a path branches; its end, in rises."""
F0, C, ABOVE = 1500.0, 25.0, 1100.0
"""Shock, Hz and uN us/um; N of a motion that snaps."""
STEP, FINER, RESOLVED = 1.0, 4, 1e-2 if is_small() else 1e-5
"""Time step, us; how much shorter that of a motion is; relative width of a bisected threshold."""
HEAD = ["rise/span", "what", "OpenSees", "its meshes differ by", "snapmap", "difference"]


def structure_table(device: Device) -> Table:
    """Make the table of the device and of steeper ones, where OpenSees is installed."""
    try:
        load()
    except ImportError as error:
        return Table("peers_opensees", HEAD, [[str(error)]])
    rows = []
    for steeper in few(STEEPER):
        one = similar(device, steeper)
        slope = f"1/{one.beam.span / one.beam.rise:.0f}"
        for what, theirs, ours in compared(one, steeper):
            value, apart = limit(theirs)
            numbers = f"{value:.5g}", f"{apart:.0e}", f"{ours:.5g}", f"{ours / value - 1:+.2%}"
            rows.append([slope, what, *numbers])
    return Table("peers_opensees", HEAD, rows)


def similar(device: Device, steeper: int) -> Device:
    """Return a steeper device that the shallow equations do not tell from it, at other f0 and C."""
    factors = {"mass": steeper} | dict.fromkeys(("spring", "contact", "gravity"), steeper**3)
    beam = {key: steeper * getattr(device.beam, key) for key in ("rise", "thickness")}
    values = {key: factor * getattr(device, key) for key, factor in factors.items()}
    return with_beam(replace(device, **values), **beam)


def compared(device: Device, steeper: int) -> Iterator[tuple[str, list[float], float]]:
    """Yield names of values, those of OpenSees on three meshes, and ours, in EI rise/L^3 or us."""
    beam, f0, damping = device.beam, steeper * F0, steeper**2 * C
    unit, path = beam.stiffness_unit * beam.rise, statics(device)
    corners = [unbent(beam, elements) / unit for elements in PATH_ELEMENTS]
    for i, name in enumerate(("largest force", "least force")):
        yield name, [pair[i] for pair in corners], path[name.replace(" ", "_")].item() / unit
    study = Study(device, Cosines(modes=5))
    N = threshold(study, [f0], [damping]).N_first.item()
    shock = f0 * 1e-6, damping, STEP / steeper
    yield "threshold N", [snap_threshold(device, N, n, shock) for n in SHOCK_ELEMENTS], N
    run = simulate(study, ABOVE, f0, damping)
    ours = passes(run.time.values, beam.rise - run.w_mid.values, 4 / 3 * beam.rise)
    times = [saddle_time(device, n, shock) for n in SHOCK_ELEMENTS]
    yield f"time of the saddle, N = {ABOVE:g}, us", times, ours


def unbent(beam, elements: int) -> np.ndarray:
    """Return the largest and the least force of a path, without imperfection, uN."""
    # ASSUME: near a branching point they move with the 2/3 power of the imperfection (Koiter).
    more, less = (folds(*HalfBeam(beam, elements, bent).path(FAR)) for bent in BENT)
    return less + (less - more) / ((BENT[0] / BENT[1]) ** (2 / 3) - 1)


def folds(x: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return the first maximum of a path's force and the minimum after it."""
    rises = np.diff(force) > 0
    top = np.argmin(rises)
    return np.array([vertex(x, force, i) for i in (top, top + np.argmax(rises[top:]))])


def vertex(x: np.ndarray, y: np.ndarray, i: int) -> float:
    """Return the extreme of the parabola through three points."""
    a, b, _ = np.polyfit(x[i - 1 : i + 2] - x[i], y[i - 1 : i + 2], 2)
    return y[i] - b * b / (4 * a)


def snap_threshold(device: Device, N: float, elements: int, shock: tuple) -> float:
    """Find the lowest N that snaps in OpenSees by bisection about ours; shock: f0, C, step."""
    low, high = 0.85 * N, 1.1 * N
    while high - low > RESOLVED * N:
        middle = (low + high) / 2
        _, way = HalfBeam(device.beam, elements).motion(device, (middle, *shock[:2]), shock[2])
        snaps = way[-1] > SNAPPED * device.beam.rise
        low, high = (low, middle) if snaps else (middle, high)
    return (low + high) / 2


def saddle_time(device: Device, elements: int, shock: tuple) -> float:
    """Return the time at which OpenSees' midpoint passes the saddle at N = ABOVE, us."""
    f0, damping, step = shock
    run = HalfBeam(device.beam, elements).motion(device, (ABOVE, f0, damping), step / FINER)
    return passes(*run, 4 / 3 * device.beam.rise)


def passes(t: np.ndarray, way: np.ndarray, place: float) -> float:
    """Return when a way first comes to a place."""
    i = np.argmax(way > place)
    return float(np.interp(place, way[i - 1 : i + 1], t[i - 1 : i + 1]))


def limit(values: list[float]) -> tuple[float, float]:
    """Return what values on three meshes, each twice as fine, tend to as h^2, and how surely."""
    coarser, finer = ((4 * fine - coarse) / 3 for coarse, fine in pairwise(values))
    return finer, abs(finer / coarser - 1)
