"""Design: the value of a device that gives a threshold or meets requirements."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, NamedTuple

import numpy as np
import xarray as xr

from ...device.device import VALUES
from ...files.text import plain
from ...pulse.shocks import Shocks
from ...study.arguments import Requirements, SingleStudy
from ...study.axes import KIND_OF, attributes_of, frequencies, unit_on
from ...study.shock import Shock
from ...study.study import ANY
from ...thresholds.population import thresholds_at
from ...thresholds.probe import near
from ...values.arguments import Reading
from ...values.faults import warn
from ...values.kinds import Fitting, Pair, Word, kind_of
from ...values.quantities import Damper, Frequency, Positive, PulseTime

POINTS, WINDOW_POINTS = 17, 33
"""Number of values on the first grid, for a threshold and for a window."""
PARTS = 512
"""Number of parts of an interval of the grid; an answer is refined to one part."""


class Design(NamedTuple):
    """A value at which N is the threshold, and its error by the threshold's error bar; internal
    units."""

    value: float
    error: float


NAME = "C or the name of a value of the device, such as thickness"
ValueName = Annotated[str, Word(("C", *VALUES), NAME)]
_PAIR = "a pair of numbers, low and high, such as (1.8, 2.2)"
Between = Annotated[Sequence[float | str], Fitting(_PAIR)]


def design(
    study: SingleStudy,
    value: ValueName,
    N: Positive | None = None,
    f0: Frequency | None = None,
    C: Damper | None = None,
    *,
    duration: PulseTime | None = None,
    between: Between | None = None,
    requirements: Requirements = (),
) -> Design | xr.Dataset:
    """Find the value of a device, or C, at which N is the threshold, or that meets requirements.

    Parameters
    ----------
    study
        Device, model and shock; or a Device.
    value
        Name of a value of the device, or "C".
    N
        Wanted threshold, multiples of g; None with requirements.
    f0
        Frequency of the pulse, Hz; None with requirements.
    C
        Damping of the mass, uN us/um; None where C is the value.
    duration
        Duration of the pulse, us, in place of f0.
    between
        Low and high end of the searched range, internal units.
    requirements
        Mappings of name, N, f0 (Hz) or duration (us), snaps and optionally pulse, direction; each
        must hold under all its shapes and directions.

    Returns
    -------
    Design or Dataset
        A Design; if several values are right, the lowest, and a warning. With requirements, a
        Dataset with the ends `low` and `high` of each `window`, their errors, and the requirements
        that set them (`low_from`, `high_from`), and whether each `requirement` is `met` at each
        value `tried`; if there is no window, a warning says where each requirement holds.

    Raises
    ------
    ValueError
        A line for each argument that is wrong.
        One line, if no value gives the threshold.

    Examples
    --------
    >>> device = snapmap.load_device("config/config.yaml")
    >>> study = snapmap.Study(device, model="cosines", horizon=0)
    >>> made = snapmap.design(study, "thickness", N=1100, f0=1500, C=25, between=(2.0, 2.2))
    >>> round(made.value, 1)
    2.1
    """
    start = study.start
    required = _single_shocks(goal.under(study.shocks, start) for goal in requirements)
    f0 = frequencies(f0, duration)
    shock = ({} if required else {"N": N, "f0": f0}) | {"C": C, "between": between}
    if value == "C" and shock.pop("C") is not None:
        raise ValueError("C: is the value that design searches; leave it out")
    for key, argument in shock.items():
        if argument is None:
            need = kind_of(design.__annotations__[key]).need
            raise ValueError(f"{key}: missing; write {need}")
    goals = required or [Shock(name="", N=N, f0=f0, shocks=study.shocks, snaps=True, start=start)]
    low, high = _searched_range(between, value, study.unit_of_C)
    look, searched = _threshold_finder(study, value, C, goals), (value, study.unit_of_C)
    grid = np.linspace(low, high, WINDOW_POINTS if required else POINTS)
    of_goals = np.tile(grid, (len(goals), 1))
    N_first, error, met = look(np.arange(len(goals)), of_goals, [grid])
    if required:
        return _windows(look, searched, grid, goals, N_first, error, met)
    known = np.isfinite(N_first[:, 1:] + N_first[:, :-1])
    *_, values, errors = _ends(look, grid, N_first, error, met, known, N)
    return _single(searched, N, grid, N_first, values, errors)


def _searched_range(between, value, unit_of_C):
    """Convert the ends of the searched range to internal units; ValueError unless they ascend."""
    try:
        low, high = Pair(KIND_OF[value]).convert(between, Reading(unit_of_C=unit_of_C))
    except ValueError as fault:
        raise ValueError(f"between: {fault}") from None
    if not low < high:
        raise ValueError(f"between: {low:g}, {high:g} do not ascend; write (low, high)")
    return low, high


def _single_shocks(requirements):
    """Split requirements into one for each shock; of several shocks the name tells which."""
    singles = []
    for required in requirements:
        if required.snaps == ANY:
            line = f"{required.name}: snaps: any has no threshold; write true or false"
            raise ValueError(f"requirements: {line}")
        several = required.shocks.each()
        for shocks in several:
            where = f", {shocks.pulse.name} {shocks.direction}" if len(several) > 1 else ""
            singles.append(replace(required, name=required.name + where, shocks=shocks))
    return singles


def _threshold_finder(study, value, C, goals) -> Callable:
    """Make a function of goals, by number (n,), and values, (n, m), as `look` below.

    It returns N_first, its error, and whether the goal is met, (n, m). Axes of a grid that the
    values form speed it up, as in `thresholds_at`.
    """
    pulses = {str(i): goal.shocks.pulses[0] for i, goal in enumerate(goals)}
    study = study.under(Shocks(pulses))
    N, f0 = np.array([goal.N for goal in goals]), np.array([goal.f0 for goal in goals])
    snaps = np.array([bool(goal.snaps) for goal in goals])  # ARRIVES snaps, too
    starts = np.array([goal.start for goal in goals])

    def look(row, tried, axes=()):
        i = np.repeat(row, tried.shape[1])
        N_first, error, exists = np.empty((3, i.size))
        for start in np.unique(starts[i]):
            mask = starts[i] == start
            started = study.but(start=str(start))
            values = {value: tried.ravel()[mask]}
            dampers = values.pop("C", C)
            N_first[mask], error[mask], exists[mask] = thresholds_at(
                started, values, f0[i[mask]], dampers, i[mask], axes
            )
        met = ((N_first <= N[i]) == snaps[i]) & (exists > 0)
        return [column.reshape(tried.shape) for column in (N_first, error, met)]

    return look


def _ends(look, grid, N_first, error, met, where, N):
    """Refine the values at which goals begin or end to be met.

    N_first, error, met: of all goals on the grid, (goals, n)
    where: intervals of the grid that count; N: (goals,)
    Returns number of the goal, number of the interval, value, and error, (ends,).
    """
    row, k = np.nonzero((met[:, 1:] != met[:, :-1]) & where)
    if not row.size:
        return row, k, grid[k], grid[k]
    N, which = np.broadcast_to(N, len(met))[row], np.arange(k.size)
    guess = _guess(N_first[row], k, N)
    thresholds = np.full((2, k.size, PARTS + 1), np.nan)
    for end in (0, 1):
        thresholds[:, which, end * PARTS] = N_first[row, k + end], error[row, k + end]

    def tried(which, places):
        return grid[k[which], np.newaxis] + places * ((grid[1] - grid[0]) / PARTS)

    def label(which, places):
        *threshold, is_met = look(row[which], tried(which, places))
        thresholds[:, which[:, np.newaxis], places] = threshold
        return is_met == met[row, k + 1][which, np.newaxis]

    last = np.maximum(near(label, which, guess, PARTS), 1)[:, np.newaxis]
    ends = np.hstack([last - 1, last])
    slope = (N_first[row, k + 1] - N_first[row, k]) / (grid[1] - grid[0])
    (low, high), (first, error) = tried(which, ends).T, thresholds[:, which[:, np.newaxis], ends]
    below, beyond = first.T
    slope = np.where(np.isfinite(slope), slope, (beyond - below) / (high - low))
    with np.errstate(invalid="ignore", divide="ignore"):
        inside = low + (N - below) * (high - low) / (beyond - below)
        left_open = (error.max(axis=1) + abs(beyond - below) / 2) / abs(slope)
    # Where nothing snaps beyond an end, the bar of a threshold tells nothing about it.
    crossed = ((below <= N) != (beyond <= N)) & np.isfinite(inside)
    value = np.where(crossed, inside, (low + high) / 2)
    return row, k, value, np.where(crossed, left_open, (high - low) / 2)


def _guess(N_first, k, N):
    """Guess the part of interval k of the grid in which N is the threshold, by a cubic; (ends,).

    N_first: on the grid, (ends, n)
    """
    at = np.clip(k - 1, 0, N_first.shape[1] - 4)[:, np.newaxis] + np.arange(4)
    first, place = np.take_along_axis(N_first, at, 1), 0.0
    with np.errstate(invalid="ignore", divide="ignore"):
        for j in range(4):
            others = np.delete(first, j, axis=1)
            shares = (N[:, np.newaxis] - others) / (first[:, [j]] - others)
            place = place + (at[:, j] - k) * np.prod(shares, axis=1)
    return np.clip(np.ceil(np.nan_to_num(PARTS * place, nan=PARTS / 2)), 1, PARTS).astype(int)


def _single(searched, N, grid, N_first, values, errors):
    value, unit, known = searched[0], unit_on(*searched), N_first[np.isfinite(N_first)]
    ends = f"from {grid[0]:g} to {grid[-1]:g} {unit}"
    if not values.size:
        runs = f"is {known.min():.5g} to {known.max():.5g}" if known.size else "does not exist"
        raise ValueError(f"{value}: no value {ends} gives N = {N:g}; the threshold {runs}")
    if values.size > 1:
        places = ", ".join(f"{place:.5g}" for place in values)
        line = f"{value}: thresholds {ends} are not monotone; at {places} {unit} they are {N:g}"
        warn(line)
    return Design(float(values[0]), float(errors[0]))


def _windows(look, searched, grid, goals, N_first, error, met):
    """The windows of a value, as `design` returns them.

    searched: its name, and the unit of C; N_first, error, met: (goals, n)
    """
    names, N, all_met = [goal.name for goal in goals], [goal.N for goal in goals], met.all(0)
    ends = _ends(look, grid, N_first, error, met, all_met[1:] != all_met[:-1], N)
    ends = sorted((at, error, names[row], k) for row, k, at, error in zip(*ends, strict=True))
    places = (grid[0], 0.0, "between", -1), *ends, (grid[-1], 0.0, "between", grid.size - 1)
    windows = [
        (low, high) for low, high in pairwise(places) if all_met[low[3] + 1 : high[3] + 1].any()
    ]
    if not windows:
        warn(_contradiction(searched, grid, names, met))
    attrs = attributes_of(*searched)
    data = {
        f"{side}{key}": ("window", [pair[j][k] for pair in windows], attrs if k < 2 else {})
        for j, side in enumerate(("low", "high"))
        for k, key in enumerate(("", "_error", "_from"))
    }
    data["met"] = ("requirement", "tried"), met
    return xr.Dataset(data, {"requirement": names, "tried": ("tried", grid, attrs)})


def _contradiction(searched, grid, names, met):
    """Write where each requirement is met, and where most are; met: (requirements, n)."""
    value, unit, count = searched[0], unit_on(*searched), met.sum(axis=0)
    lines = []
    for name, row in zip(names, met, strict=True):
        places = grid[row]
        where = f"from {plain(places.min())} to {plain(places.max())}" if row.any() else "nowhere"
        lines.append(f"{name} is met {where}")
    most = f"{count.max()} of {len(names)} at {plain(grid[np.argmax(count)])} {unit}"
    ends = f"{grid[0]:g} to {grid[-1]:g} {unit}"
    return f"{value}: none from {ends} meets all requirements, at most {most}: {', '.join(lines)}"
