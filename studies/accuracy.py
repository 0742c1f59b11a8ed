"""Speed against error as a work-precision diagram: docs/accuracy.md and the README's figure.

./run python -m studies accuracy [--device SECTION] [--small]

Writes results/accuracy.csv, results/accuracy.md and results/figures/accuracy.pdf and .png. SciPy
takes part, too.
"""

from collections.abc import Iterator, Sequence
from datetime import date
from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from snapmap import threshold
from snapmap.device.device import Device
from snapmap.figures import style
from snapmap.files.text import DASH, table
from snapmap.solver.adaptive import build_adaptive
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.models import Model, build_model
from snapmap.solver.settings import Settings
from snapmap.thresholds.search import refine

from .common import command_device, cpu_seconds, few, is_small, machine, number, ratio, results
from .scipy_solver import TOLERANCE, Follow, by_scipy

SPEEDS = {"slow": (0.02, 0.1), "fast": (0.5, 6.0)}
"""Frequencies of pulses over the device's own."""
F0_COUNT, DAMPINGS = 20, (0.05, 0.2, 0.8)
"""How many frequencies of each speed; dampings over sqrt(K M)."""
FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25)
"""Ladder of steps, over those that thresholds take."""
MODELS = {
    "3 cosines": {"name": "cosines", "modes": 3},
    "5 cosines": {"name": "cosines", "modes": 5},
    "11 cosines": {"name": "cosines", "modes": 11},
    "5 elements": {"name": "elements"},
}
HANDOUT, PLAIN = "5 elements", "plain loop, 5 elements"
REFERENCE, COARSER = 16, 12
"""Cosines of the reference, and fewer, to see its error."""
FINE = 0.125
"""Its steps over those that thresholds take; twice as long ones show their error."""
AGREED, RESOLVED, NEAR = 1e-4, 1e-3 if is_small() else 1e-7, 1.04
"""Rows whose references agree so well are posed; thresholds are refined so far; reach, as a factor.
"""
MAP = np.linspace(0.6, 1.8, 33)
"""Amplitudes over the threshold, of the cells whose time counts; of every fourth for the slow."""
STRIDE, FEWER = 6, 30
"""Of the posed rows, every so many-th is followed by those who are slow, and by SciPy, which takes
seconds for a cell of a fast pulse and half a minute for one of a slow pulse: it is left out there.
"""
ROUNDS = 3
SETTINGS = Settings(until="edge", repeat=False)
LOOKS = {"auto": ("C5", "o"), "3 cosines": ("C0", "^"), "5 cosines": ("C1", "s")}
LOOKS |= {"11 cosines": ("C2", "D"), HANDOUT: ("C6", "v"), PLAIN: ("0.4", "P")}
LOOKS |= {"SciPy DOP853": ("0.4", "X")}


class Posed(NamedTuple):
    """Rows with a threshold that the references agree on: f0 (Hz), C (uN us/um), N, own error."""

    f0: np.ndarray
    C: np.ndarray
    N: np.ndarray
    error: np.ndarray

    def every(self, stride: int) -> "Posed":
        """Each `stride`-th of them."""
        return Posed(*(column[::stride] for column in self))


class Entry(NamedTuple):
    """Who follows cells at one setting.

    edge, timed: by whom the threshold is found, and by whom the map's cells are followed
    """

    name: str
    setting: str
    edge: Follow
    timed: Follow
    stride: int = 1
    speeds: tuple[str, ...] = tuple(SPEEDS)


def main() -> None:
    device = command_device()
    points = pd.DataFrame(
        point for speed, ends in SPEEDS.items() for point in measure(device, speed, ends)
    )
    points.to_csv(results("accuracy.csv"), index=False)
    results("accuracy.md").write_text(report(points), encoding="utf-8")
    with style.paper():
        figure = style.double_column(height=3.4)
        draw(figure.subplots(1, len(SPEEDS), sharey=True), points)
        style.save(figure, results("figures/accuracy"), {"title": "Speed against error"})
    print(report(points))


def measure(device: Device, speed: str, ends: tuple[float, float]) -> Iterator[dict]:
    """A point for each entry: the spread of its error over the posed rows, and its speed."""
    posed = find_posed(device, few(np.geomspace(*ends, F0_COUNT)[::-1], 1), few(DAMPINGS))
    for entry in entries(device):
        if speed not in entry.speeds:
            continue
        rows = posed.every(entry.stride)
        error = abs(edge(device, entry.edge, rows) / rows.N - 1)
        N = rows.N[:, np.newaxis] * few(MAP[:: 4 if entry.stride > 1 else 1], 5)
        cells = cells_of(device, rows, N)
        seconds = (
            cpu_seconds(
                partial(entry.timed, cells), ROUNDS if entry.stride == 1 and not is_small() else 1
            )
            / N.size
        )
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
            "simulations/s": 1 / seconds,
            "reference": np.quantile(posed.error, 0.9),
        }


def entries(device: Device) -> Iterator[Entry]:
    """Our models over the ladder of steps, then whom users would take instead."""
    ladder = few(FACTORS, 2)
    for factor in ladder:
        levels = build_adaptive(device).with_step(factor)
        yield Entry("auto", f"{factor:g}", by_model(levels.top), by_model(levels))
    for name, options in few(MODELS, 2).items():
        for factor in ladder:
            follow = by_model(build_model(device, **options).with_step(factor))
            yield Entry(name, f"{factor:g}", follow, follow)
    plain = by_model(build_model(device, "reference"))
    yield Entry(PLAIN, "0.8 of its limit", plain, plain, STRIDE)
    modal = build_model(device, "elements").modal
    follow = flattened(by_scipy(device, modal, "DOP853"))
    yield Entry("SciPy DOP853", f"{TOLERANCE:g}", follow, follow, FEWER, ("fast",))


def by_model(model: Model) -> Follow:
    """Follow cells as thresholds do."""
    return lambda cells: model.follow(cells, SETTINGS).t_snap


def flattened(follow: Follow) -> Follow:
    """The same for cells of any shape."""
    return lambda cells: follow(cells.flat()).reshape(cells.f0.shape)


def cells_of(device: Device, rows: Posed, N: np.ndarray) -> Cells:
    """Cells of amplitudes N, (rows, n)."""
    f0, C = rows.f0[:, np.newaxis], rows.C[:, np.newaxis]
    return to_cells(device, 0, N, f0, C, SETTINGS.horizon)


def edge(device: Device, follow: Follow, rows: Posed) -> np.ndarray:
    """Threshold of each row, if it lies within NEAR of N, (rows,)."""

    def ask(N):
        given = np.isfinite(N)
        asked = Posed(*(np.broadcast_to(x[:, np.newaxis], N.shape)[given] for x in rows))
        t_snap = np.full(N.shape, np.nan)
        t_snap[given] = follow(cells_of(device, asked, N[given][:, np.newaxis]))[:, 0]
        return t_snap

    low, high = rows.N / NEAR, rows.N * NEAR
    snapped = np.isfinite(ask(np.column_stack([low, high])))
    there = ~snapped[:, 0] & snapped[:, 1]
    return refine(ask, *(np.where(there, end, np.nan) for end in (low, high)), RESOLVED)[1]


def find_posed(device: Device, speeds: np.ndarray, dampings: tuple[float, ...]) -> Posed:
    """Rows that are clean, and on which references of other modes and steps agree.

    speeds: frequencies over the device's own; dampings: over sqrt(K M)
    """
    f0 = speeds * device.own_frequency / (2 * np.pi) * 1e6
    C = np.array(dampings) * np.sqrt(device.spring * device.mass)
    rows = threshold(device, f0, C)[["N_first", "ragged"]].stack(row=("C", "f0"))
    rows = rows.isel(row=(rows.ragged.values == 0) & np.isfinite(rows.N_first.values))
    near = Posed(rows.f0.values, rows.C.values, rows.N_first.values, np.zeros(rows.row.size))

    def refer(modes, factor):
        model = build_model(device, "cosines", modes=modes).with_step(factor)
        return edge(device, by_model(model), near)

    many, fewer = (5, 3) if is_small() else (REFERENCE, COARSER)
    finest = refer(many, FINE)
    of_modes = abs(finest / refer(fewer, FINE) - 1) / ((many / fewer) ** 4 - 1)
    of_steps = abs(finest / refer(many, 2 * FINE) - 1) / 3
    error = of_modes + of_steps + RESOLVED
    posed = error < (np.inf if is_small() else AGREED)
    return Posed(*(column[posed] for column in near._replace(N=finest, error=error)))


def report(points: pd.DataFrame) -> str:
    """All points, and how many times as fast `auto` is at equal error, as Markdown."""
    percent = ["median", "90 %", "largest"]
    head = ["pulses", "model", "step or tolerance", "rows", *percent, "simulations/s"]
    rows = [
        [p["pulses"], p["model"], p["setting"], str(p["rows"])]
        + [f"{number(100 * p[key])} %" if p[key] == p[key] else DASH for key in percent]
        + [number(p["simulations/s"])]
        for p in points.to_dict("records")
    ]
    own = points.groupby("pulses", sort=False)["reference"].first()
    facts = "; ".join(f"{speed} {number(100 * error)} %" for speed, error in own.items())
    gains = [
        [name, *(gain(points[points.pulses == speed], name) for speed in SPEEDS)]
        for name in dict.fromkeys(points.model)
        if name != "auto"
    ]
    return (
        f"{machine()}, one thread, CPU time, least of {few(ROUNDS)}; {date.today()}; "
        f"`./run python -m studies accuracy`.\n"
        f"Error of the reference (90 % of rows): {facts}.\n\n{table(head, rows)}\n"
        f"{table(['speed of `auto` over', *SPEEDS], gains)}"
    )


def gain(points: pd.DataFrame, name: str) -> str:
    """Speed of `auto` over another's where both make the same median error: median (range)."""
    ours, theirs = (front(points[points.model == one]) for one in ("auto", name))
    if not (ours.size and theirs.size):
        return DASH
    low = max(ours[0, 0], theirs[0, 0])
    high = min(ours[0, -1], theirs[0, -1]) if theirs.shape[1] > 1 else low
    errors = np.geomspace(low, max(low, high), 9)
    ours, theirs = (np.exp(np.interp(np.log(errors), *np.log(one))) for one in (ours, theirs))
    times = ours / theirs
    return f"{ratio(np.median(times))} ({ratio(times.min())} to {ratio(times.max())})"


def front(points: pd.DataFrame) -> np.ndarray:
    """Errors, ascending, and the highest speed with at most that error, (2, points)."""
    known = points.dropna(subset="median").sort_values("median")
    errors = known["median"].clip(lower=RESOLVED)  # what is refined no further may agree exactly
    return np.array([errors, known["simulations/s"].cummax()])


def draw(axes: Sequence[Axes], points: pd.DataFrame) -> None:
    """Draw slow and fast pulses on two axes, and a legend."""
    for ax, (speed, of_speed) in zip(axes, points.groupby("pulses", sort=False), strict=True):
        draw_speed(ax, of_speed)
        low, high = SPEEDS[speed]
        ax.set_title(f"{speed} pulses: $f_0$ = {low:g} to {high:g} of the device's own")
    axes[1].set_ylabel("")
    style.legend(axes[0].figure, style.labelled(axes), ncols=5)


def draw_speed(ax: Axes, points: pd.DataFrame) -> None:
    """Draw speed over error, medians with bars up to 90 % of the rows, of slow or fast pulses."""
    for name, of_model in points.groupby("model", sort=False):
        colour, marker = LOOKS[name]
        x, far = (100 * of_model[key] for key in ("median", "90 %"))
        y = of_model["simulations/s"]
        ax.plot(x, y, color=colour, marker=marker, label=name)
        ax.hlines(y, x, far, color=colour, alpha=0.35, linewidth=1.5)
    own = points[(points.model == HANDOUT) & (points.setting == "1")]
    ring = {"marker": "o", "markersize": 8, "fillstyle": "none", "linestyle": ""}
    ax.plot(
        100 * own["median"], own["simulations/s"], color="k", label="the handout's setting", **ring
    )
    error = 100 * points["reference"].iloc[0]
    ax.axvline(error, color="0.6", linewidth=0.6, label="error of the reference")
    ax.set(xscale="log", yscale="log", xlabel="error of the threshold (%)")
    ax.set_ylabel("simulations per second, one thread")
    ax.text(0.03, 0.04, "better: up and to the left", transform=ax.transAxes, color="0.4")


if __name__ == "__main__":
    main()
