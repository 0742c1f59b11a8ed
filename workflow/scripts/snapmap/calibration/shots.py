"""A table of shots: what the device was given, and whether it tripped."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..checks import numbers, show
from ..device import Device
from ..io.recorded import read_pulse
from ..io.tables import answers, shot_columns
from ..pulse import Pulse
from ..quantities import QUANTITIES
from ..shocks import Shocks, make_shocks

DIRECTIONS = "+z", "-z"
FEWEST = 3
MOST = 4
"""Unknowns: the grid of thresholds grows with the power of their number."""
MANY = 2
"""So many of either kind at one shock contradict each other if all that trip lie below."""


class Kind(NamedTuple):
    """A shock but for its level; f0: Hz; pulse: along its direction."""

    shape: str
    direction: str
    f0: float
    pulse: Pulse

    def __str__(self):
        """Where its threshold is looked for, in words."""
        return f"{self.shape} along {self.direction}, f0 = {self.f0:.6g} Hz"


class Shots(NamedTuple):
    """Shots of a campaign, arrays (shots,).

    N: multiples of g; tripped: bools; kind: index into kinds; unit: number of the specimen
    """

    N: np.ndarray
    tripped: np.ndarray
    kind: np.ndarray
    unit: np.ndarray
    kinds: tuple[Kind, ...]

    @property
    def f0(self) -> np.ndarray:
        """Frequency of each, Hz."""
        return np.array([self.kinds[i].f0 for i in self.kind])


def shots_from(table: str | Path | Mapping, shocks: Shocks, device: Device) -> Shots:
    """Take a table of shots as `calibrate` does; raises ValueError, one line.

    shocks: of one shape and direction, where the table names none; device: whose gravity N counts
    """
    columns = shot_columns(table)
    size = len(columns.get("tripped", ()))
    if size < FEWEST:
        raise ValueError(f"shots: {size} are too few; give {FEWEST} or more")
    kinds, places, levels = [], {}, []
    for i in range(size):
        row = {key: values[i] for key, values in columns.items() if not _is_empty(values[i])}
        key, kind = _kind(row, i, shocks, places)
        if key not in places:
            places[key] = len(kinds)
            kinds.append(kind)
        levels.append((places[key], _level(row, i, kinds[places[key]].pulse, device)))
    kind, N = np.array(levels).T
    units = np.asarray(columns.get("unit", np.arange(size)))
    unit = np.unique([str(one) for one in units], return_inverse=True)[1]
    shots = Shots(N, answers(columns["tripped"].tolist()), kind.astype(int), unit, tuple(kinds))
    _check(shots)
    return shots


def _is_empty(value):
    return value is None or value == "" or (isinstance(value, float) and math.isnan(value))


def _kind(row, place, shocks, known):
    """What tells a shot's shock from others, and the shock."""
    where = f"shots, row {place + 1}"
    if "file" in row and "shape" in row:
        raise ValueError(f"{where}: shape stands beside file; write one of them")
    direction = str(row.get("direction", shocks.direction))
    if direction not in DIRECTIONS:
        raise ValueError(
            f"{where}: direction: {show(direction)} is not one of {', '.join(DIRECTIONS)}"
        )
    named = str(row.get("file", row.get("shape", "")))
    given = {key: row[key] for key in ("f0", "duration") if key in row}
    key = named, direction, *given.items()
    if key in known:
        return key, None
    pulse = shocks.pulse
    try:
        if "file" in row:
            pulse = read_pulse(named)
        elif named:
            pulse = make_shocks(named).pulse
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    f0 = _frequency(given, pulse, where)
    pushed = pulse if direction == "+z" else pulse.reversed()
    return key, Kind(named or pulse.name, direction, f0, pushed)


def _frequency(given, pulse, where):
    if not given and pulse.duration:
        return 1e6 / pulse.duration
    if len(given) != 1:
        what = "both are there" if given else "missing"
        raise ValueError(f"{where}: f0 or duration: {what}; write f0 in Hz, or duration in us")
    ((key, value),) = given.items()
    value = _positive(value, f"{where}: {key}")
    return value if key == "f0" else 1e6 / value


def _level(row, place, pulse, device):
    if pulse.is_of_frame and device.force:
        told = "file: shakes the frame; write gravity in place of device.force"
        raise ValueError(f"shots, row {place + 1}: {told}")
    if "N" in row:
        return _positive(row["N"], f"shots, row {place + 1}: N")
    own = pulse.own_N or pulse.peak / device.gravity
    if math.isnan(own):
        raise ValueError(f"shots, row {place + 1}: N: missing; write a multiple of g")
    return own


def _positive(value, where):
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not 0 < number < math.inf:
        raise ValueError(f"{where}: {show(value)} is no number above 0")
    return number


def _check(shots):
    """Refuse shots of one kind, and those that contradict each other."""
    N, tripped = shots.N, shots.tripped
    if tripped.all() or not tripped.any():
        what = "all trip" if tripped.all() else "none trips"
        raise ValueError(f"shots: {what} of {tripped.size}; a threshold needs both")
    against = []
    for number, kind in enumerate(shots.kinds):
        trips, others = (N[(shots.kind == number) & (tripped == is_so)] for is_so in (True, False))
        if trips.size and others.size and trips.max() < others.min():
            against.append((min(trips.size, others.size) >= MANY, kind))
    all_are = len(against) == len(shots.kinds)
    wrong = [kind for surely, kind in against if surely or all_are]
    if wrong:
        raise ValueError(
            f"shots: they contradict each other, {wrong[0]}: all that trip lie below all that do "
            "not; is tripped the wrong way round?"
        )


def check_ranges(unknowns: Mapping, C: float | None) -> None:
    """Raise ValueError, one line, for ranges of unknowns, or a C beside them, that cannot be."""
    if not 1 <= len(unknowns) <= MOST:
        raise ValueError(f"unknowns: {len(unknowns)} of them; name 1 to {MOST}")
    for key, ends in unknowns.items():
        pair, within = numbers(ends), QUANTITIES[key].range
        if pair is None or pair.shape != (2,):
            raise ValueError(f"unknowns: {key}: {show(ends)} is no pair of low and high")
        low, high = pair
        if not (within.holds(pair).all() and -math.inf < low < high < math.inf):
            need = f" {within}".rstrip()
            raise ValueError(f"unknowns: {key}: {low:g} to {high:g} is no ascending range{need}")
    if ("C" in unknowns) != (C is None):
        what = "missing; write it, or its range" if C is None else "is unknown; leave it out"
        raise ValueError(f"C: {what}")
