"""Speed against error as a work-precision diagram, for docs/accuracy.md.

./run python -m studies accuracy [--device SECTION] [--small]

The study `peers` has other solvers.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from snapmap.device.device import Device
from snapmap.files.text import DASH
from snapmap.solver.adaptive import build_adaptive
from snapmap.solver.cells import to_cells
from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Cosines, Elements, Reference
from snapmap.solver.settings import Run

from .common import (
    asking,
    clean_rows,
    command_device,
    cpu_seconds,
    few,
    is_small,
    number,
    ratio,
    threshold_near,
)
from .peers.equations import Follow
from .tables import Table, write

SPEEDS = {"slow": (0.02, 0.1), "fast": (0.5, 6.0)}
"""Ranges of pulse frequencies, over the device's own frequency."""
F0_COUNT, DAMPINGS = 20, (0.05, 0.2, 0.8)
"""Number of frequencies of each speed; dampings over sqrt(K M)."""
FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25)
"""Time steps, over the default steps of thresholds."""
MODELS = {
    "3 cosines": Cosines(modes=3),
    "5 cosines": Cosines(modes=5),
    "11 cosines": Cosines(modes=11),
    "5 elements": Elements(),
}
HANDOUT, PLAIN = "5 elements", "plain loop, 5 elements"
REFERENCE, COARSER = 16, 12
"""Numbers of cosines of the reference, and of a coarser model that shows its error."""
FINE = 0.125
"""Steps of the reference over the default ones; twice as long steps show their error."""
AGREED, RESOLVED, NEAR = 1e-4, 1e-3 if is_small() else 1e-7, 1.04
"""Largest error of the reference in a posed row; tolerance of thresholds; factor on a row's N
within which they are searched."""
MAP = np.linspace(0.6, 1.8, 33)
"""Amplitudes of the timed cells, over the threshold; slow solvers get every fourth."""
STRIDE = 6
"""Stride through the posed rows for the plain loop."""
ROUNDS, ERRORS = 3, ("median", "90 %", "largest")
SETTINGS = Run(repeat=False).but(until="edge")


class Posed(NamedTuple):
    """Rows whose references agree: f0 (Hz), C (uN us/um), threshold N and its relative error."""

    f0: np.ndarray
    C: np.ndarray
    N: np.ndarray
    error: np.ndarray

    def every(self, stride: int) -> "Posed":
        """Return every `stride`-th row."""
        return Posed(*(column[::stride] for column in self))


class Entry(NamedTuple):
    """A solver at one setting.

    edge, timed: functions that follow cells, for the threshold, and for the timed map
    """

    name: str
    setting: str
    edge: Follow
    timed: Follow
    stride: int = 1


def main() -> None:
    device = command_device()
    points = pd.DataFrame(
        point for speed, ends in SPEEDS.items() for point in measure(device, speed, ends)
    )
    write("accuracy", all_points(points), default_points(points), gains(points))


def measure(device: Device, speed: str, ends: tuple[float, float]) -> Iterator[dict]:
    """Yield a point for each entry: the spread of its error over the posed rows, and its speed."""
    posed = find_posed(device, few(np.geomspace(*ends, F0_COUNT)[::-1], 1), few(DAMPINGS))
    for entry in entries(device):
        rows, is_slow = posed.every(entry.stride), entry.stride > 1
        error = abs(edge(device, entry.edge, rows) / rows.N - 1)
        N = rows.N[:, np.newaxis] * few(MAP[:: 4 if is_slow else 1], 5)
        rounds = 1 if is_slow else few(ROUNDS)
        f0, C = rows.f0[:, np.newaxis], rows.C[:, np.newaxis]
        cells = to_cells(device, 0, N, f0, C, SETTINGS.horizon)
        seconds = cpu_seconds(partial(entry.timed, cells), rounds)
        known = error[np.isfinite(error)]
        median, most = np.quantile(known, [0.5, 0.9]) if known.size else (np.nan, np.nan)
        yield {
            "pulses": speed,
            "model": entry.name,
            "setting": entry.setting,
            "rows": rows.N.size,
            "none near": error.size - known.size,
            "median": median,
            "90 %": most,
            "largest": known.max() if known.size else np.nan,
            "simulations/s": N.size / seconds,
            "reference": np.quantile(posed.error, 0.9),
        }


def entries(device: Device) -> Iterator[Entry]:
    """Yield our models at each step, then the handout's plain loop."""
    ladder = few(FACTORS, 2)
    for factor in ladder:
        levels = build_adaptive(device).with_step(factor)
        yield Entry("auto", f"{factor:g}", by_model(levels.top), by_model(levels))
    for name, chosen in few(MODELS, 2).items():
        for factor in ladder:
            follow = by_model(build_model(device, chosen).with_step(factor))
            yield Entry(name, f"{factor:g}", follow, follow)
    plain = by_model(build_model(device, Reference()))
    yield Entry(PLAIN, "0.8 of its limit", plain, plain, STRIDE)


def by_model(model: Model) -> Follow:
    """Follow cells as thresholds do."""
    return lambda cells: model.follow(cells, SETTINGS).t_snap


def edge(device: Device, follow: Follow, rows: Posed) -> np.ndarray:
    """Find the threshold of each row, (rows,); NaN if it is not within NEAR of N."""
    ask = asking(device, follow, rows[:2], SETTINGS.horizon)
    return threshold_near(ask, rows.N, NEAR, RESOLVED)


def find_posed(device: Device, speeds: np.ndarray, dampings: tuple[float, ...]) -> Posed:
    """Find rows that are not ragged, and in which references of other modes and steps agree.

    speeds: pulse frequencies over the device's own frequency; dampings: over sqrt(K M)
    """
    f0 = speeds * device.own_frequency / (2 * np.pi) * 1e6
    C = np.array(dampings) * np.sqrt(device.spring * device.mass)
    rows = clean_rows(device, f0, C)
    near = Posed(*rows, np.zeros(rows.shape[1]))

    def refer(modes, factor):
        model = build_model(device, Cosines(modes=modes)).with_step(factor)
        return edge(device, by_model(model), near)

    many, fewer = (5, 3) if is_small() else (REFERENCE, COARSER)
    finest = refer(many, FINE)
    of_modes = abs(finest / refer(fewer, FINE) - 1) / ((many / fewer) ** 3 - 1)
    of_steps = abs(finest / refer(many, 2 * FINE) - 1) / 3
    error = of_modes + of_steps + RESOLVED
    posed = error < (np.inf if is_small() else AGREED)
    return Posed(*(column[posed] for column in near._replace(N=finest, error=error)))


def all_points(points: pd.DataFrame) -> Table:
    """Make a table of all points; errors in per cent, that of the reference in the last column."""
    head = ["pulses", "model", "step or tolerance", "thresholds", *(f"{key}, %" for key in ERRORS)]
    rows = [
        [*(str(p[key]) for key in ("pulses", "model", "setting", "rows")), *written(p, ERRORS)]
        for p in points.to_dict("records")
    ]
    return Table("accuracy", [*head, "simulations/s", "reference, %"], rows)


def default_points(points: pd.DataFrame) -> Table:
    """Make a table of the points at the default steps, a row for each model."""
    columns = ["thresholds", "median, %", "90 %, %", "simulations/s"]
    head = ["model", *(f"{speed}: {column}" for speed in SPEEDS for column in columns)]
    default = points[~points.setting.isin([f"{factor:g}" for factor in FACTORS if factor != 1])]
    rows = []
    for name in dict.fromkeys(default.model):
        row = [name]
        for speed in SPEEDS:
            at = default[(default.model == name) & (default.pulses == speed)].to_dict("records")
            for p in at[:1]:
                row += [str(p["rows"]), *written(p, ["median", "90 %"])[:3]]
            row += [DASH] * 4 * (not at)
        rows.append(row)
    return Table("accuracy_default", head, rows)


def written(point: dict, errors: Sequence[str]) -> list[str]:
    """Write errors of a point in per cent, its speed, and the error of the reference."""
    known = (number(100 * point[key]) if point[key] == point[key] else DASH for key in errors)
    return [*known, number(point["simulations/s"]), number(100 * point["reference"])]


def gains(points: pd.DataFrame) -> Table:
    """Make a table of the speed of `auto` over that of others at equal error."""
    rows = [
        [name, *(gain(points[points.pulses == speed], name) for speed in SPEEDS)]
        for name in dict.fromkeys(points.model)
        if name != "auto"
    ]
    return Table("accuracy_gains", ["than", *(f"{speed} pulses" for speed in SPEEDS)], rows)


def gain(points: pd.DataFrame, name: str) -> str:
    """Write the speed of `auto` over that of a model at equal median error, over their errors."""
    auto, other = (front(points[points.model == model]) for model in ("auto", name))
    if not (auto.size and other.size):
        return DASH
    low = max(auto[0, 0], other[0, 0])
    high = min(auto[0, -1], other[0, -1]) if other.shape[1] > 1 else low
    errors = np.log(np.geomspace(low, max(low, high), 9))
    times = np.exp(np.interp(errors, *np.log(auto))) / np.exp(np.interp(errors, *np.log(other)))
    return ratio(np.median(times))


def front(points: pd.DataFrame) -> np.ndarray:
    """Return errors, ascending, and the highest speed with at most that error, (2, points)."""
    known = points.dropna(subset="median").sort_values("median")
    errors = known["median"].clip(lower=RESOLVED)  # smaller ones are below the refinement
    return np.array([errors, known["simulations/s"].cummax()])
