"""The section `calibration`: a table of shots, whether each tripped, and the unknowns."""

import math
from collections.abc import Mapping, Sequence
from numbers import Number
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from ...config.kinds import StudyPath
from ...device.device import VALUES, Device, is_bistable
from ...files.named import inside, naming, read_named, sha256_of
from ...files.tables import ANSWERS, ROWS, SHOCKS, read_table, shocks_in
from ...files.text import show
from ...pulse.pulse import DIRECTIONS, RECORD, N_of_g, Pulse, read_pulse
from ...pulse.shocks import Shocks, make_shocks
from ...study.axes import KIND_OF
from ...values.kinds import Pair
from ...values.quantities import Damper
from ...values.records import record, row_of_kinds, told
from ...values.units import numbers_in, unit_of

SHOTS = {"tripped": ANSWERS, **dict.fromkeys(("direction", "shape", "file"))}
"""Columns of words in a table of shots, with the meanings of words; None accepts any word."""
FEWEST = 3
"""Least number of shots."""
MOST = 4
"""Largest number of unknowns, as the grid of thresholds grows exponentially with it."""
MANY = 2
"""Least number of shots of either outcome that contradict each other if all that trip are lower."""


class Group(NamedTuple):
    """Shots that differ in level only; f0: Hz; pulse: with its direction."""

    shape: str
    direction: str
    f0: float
    pulse: Pulse

    def __str__(self):
        """Write shape, direction and f0."""
        return f"{self.shape} along {self.direction}, f0 = {self.f0:.6g} Hz"


class Shots(NamedTuple):
    """Shots of a campaign, arrays (shots,).

    N: multiples of g; tripped: bools; group: index into groups
    """

    N: np.ndarray
    tripped: np.ndarray
    group: np.ndarray
    groups: tuple[Group, ...]

    @property
    def f0(self) -> np.ndarray:
        """Frequency of each shot, Hz."""
        return np.array([self.groups[i].f0 for i in self.group])


def read_shots(path: str | Path, sha256: str = "", N_of_g: float = 1.0) -> dict[str, np.ndarray]:
    """Read shots from CSV as columns by name; raises ValueError, one line, for invalid files.

    The header names the columns: N, or N (g); f0 (Hz, kHz) or duration (us, ms, s); tripped (yes
    or no); optionally direction, shape and file. An empty number is NaN.
    sha256: of the file when the run was planned, hex digits; empty for any
    N_of_g: N of a shock of 1 g
    """
    with naming(path):
        content = read_named(path, *ROWS, sha256)
        return read_table(content, shocks_in(N_of_g), SHOTS, above=0.0, gaps=True)


def shot_columns(table: Mapping[str, Sequence]) -> dict[str, np.ndarray]:
    """Check columns of shots by name; raises ValueError, one line, for invalid ones.

    Returns N, f0 (Hz) and duration (us) above 0, or NaN; tripped as bools; the others as text.
    Shots with a file need no N.
    """
    known, columns = f"columns are {', '.join([*SHOCKS, *SHOTS])}", {}
    for key in table:
        if key not in SHOCKS | SHOTS:
            raise ValueError(f"shots: column {show(key)} is unknown; {known}")
        column, kind = table[key], bool if key == "tripped" else float if key in SHOCKS else object
        if np.ma.is_masked(column):
            column = column.astype(object).filled(np.nan)
        column = _without_units(key, column) if key in SHOCKS else column
        column = np.array(None if isinstance(column, str) else column, object)
        if column.ndim != 1:
            raise ValueError(f"shots: {key}: {show(table[key])} is not a row")
        columns[key] = np.empty(column.size, kind)
        for row, value in enumerate(column.tolist()):
            try:
                columns[key][row] = _entry(key, value)
            except ValueError as error:
                raise ValueError(f"shots, row {row + 1}: {key}: {error}") from None
    for key in ("tripped",) if "file" in columns else ("N", "tripped"):
        if key not in columns:
            raise ValueError(f"shots: column {key} is missing; {known}")
    sizes = {key: values.size for key, values in columns.items()}
    if len(set(sizes.values())) > 1:
        raise ValueError(f"shots: columns differ in length, {sizes}; write a row for each shot")
    return columns


def _without_units(key, column):
    """Convert a column, or its entries, that have a unit."""
    unit = KIND_OF[key].unit
    try:
        if unit_of(column) is not None:
            return numbers_in(column, unit)
        if not isinstance(column, list | tuple):
            return column
        return [item if unit_of(item) is None else numbers_in(item, unit) for item in column]
    except ValueError as error:
        raise ValueError(f"shots: {key}: {show(column)} {error}") from None


def _entry(key, value):
    """Convert a value of a column of shots, to a bool, text, or a number or NaN."""
    is_empty = value is None or value == "" or value != value
    if key == "tripped":
        word = value.strip().lower() if isinstance(value, str) else value
        if not isinstance(word, str | Number | np.bool_) or word not in ANSWERS:
            raise ValueError(f"{show(value)} is not true or false")
        return ANSWERS[word]
    if key in SHOTS:
        return "" if is_empty else str(value)
    try:
        number = math.nan if is_empty else float(value)
    except (TypeError, ValueError, OverflowError):
        number = KIND_OF[key].take(value)  # text with a unit
    if not (is_empty or 0 < number < math.inf):
        raise ValueError(f"{show(value)} is not a number above 0")
    return number


def shots_from(table: str | Path | Mapping, shocks: Shocks, device: Device) -> Shots:
    """Take a table of shots as `calibrate` does; raises ValueError, one line, for an invalid one.

    shocks: default shape and direction of shots; device: its gravity is the unit of N
    """
    if isinstance(table, str | Path):
        table = read_shots(table, N_of_g=N_of_g(device.gravity))
    columns = shot_columns(table)
    tripped = columns["tripped"]
    if tripped.size < FEWEST:
        raise ValueError(f"shots: {tripped.size} rows are too few; write {FEWEST} or more")
    if tripped.all() or not tripped.any():
        what = "tripped" if tripped.all() else "did not trip"
        raise ValueError(
            f"shots: all {tripped.size} {what}; a threshold needs shots of both outcomes"
        )
    known: dict[tuple, Group] = {}
    keys, levels = [], []
    for i in range(tripped.size):
        row = {key: values[i] for key, values in columns.items()}
        row = {key: value for key, value in row.items() if value == value and value != ""}
        try:
            keys.append(_group(row, shocks, known))
            levels.append(_level(row, known[keys[-1]].pulse, device))
        except ValueError as error:
            raise ValueError(f"shots, row {i + 1}: {error}") from None
    N, group = np.array(levels), np.array([list(known).index(key) for key in keys])
    shots = Shots(N, tripped, group, tuple(known.values()))
    against = []
    for number in range(len(known)):
        trips, others = (N[(group == number) & (tripped == is_so)] for is_so in (True, False))
        if trips.size and others.size and trips.max() < others.min():
            against.append((min(trips.size, others.size) >= MANY, shots.groups[number]))
    if wrong := [group for surely, group in against if surely or len(against) == len(known)]:
        raise ValueError(
            f"shots: contradict each other at {wrong[0]}: every N that tripped is below every "
            "N that did not; is tripped the wrong way round?"
        )
    return shots


def _group(row, shocks, known):
    """The key of a row's group in `known`, groups by their keys; adds a new group."""
    if "file" in row and "shape" in row:
        raise ValueError("shape: excludes file; write one of them")
    direction = row.get("direction", shocks.direction)
    if direction not in DIRECTIONS:
        raise ValueError(f"direction: {show(direction)} is not one of {', '.join(DIRECTIONS)}")
    name = row.get("file", row.get("shape", ""))
    times = {key: row[key] for key in ("f0", "duration") if key in row}
    key = name, direction, *times.items()
    if key in known:
        return key
    of_name = read_pulse if "file" in row else lambda shape: make_shocks(shape).pulse
    pulse = of_name(name) if name else shocks.pulse
    if len(times) > 1 or not (times or pulse.duration):
        what = "both written" if times else "missing"
        raise ValueError(f"f0 or duration: {what}; write one: f0 in Hz, or duration in us")
    f0 = times.get("f0") or 1e6 / times.get("duration", pulse.duration)
    pushed = pulse if direction == "+z" else pulse.reversed()
    known[key] = Group(name or pulse.name, direction, f0, pushed)
    return key


def _level(row, pulse, device):
    if pulse.is_of_frame and device.force:
        raise ValueError("file: a record shakes the frame; write gravity, not device.force")
    N = row.get("N") or pulse.peak / device.gravity
    if math.isnan(N):
        raise ValueError("N: missing; write multiples of g")
    return N


def check_ranges(unknowns: Mapping, C: float | None, device: Device) -> None:
    """Raise ValueError, one line, for invalid ranges of unknowns, or an invalid C beside them.

    The device must have a second stable shape at both ends of each range.
    """
    if not 1 <= len(unknowns) <= MOST:
        raise ValueError(f"unknowns: has {len(unknowns)} values; write 1 to {MOST}")
    for key, (low, high) in unknowns.items():
        if not -math.inf < low < high < math.inf:
            need = f" {KIND_OF[key].bounds}".rstrip()
            raise ValueError(f"unknowns: {key}: {low:g} to {high:g} does not ascend{need}")
    if ("C" in unknowns) != (C is None):
        what = "missing; write it, or its range" if C is None else "is an unknown; leave it out"
        raise ValueError(f"C: {what}")
    middle = {key: np.full(1, sum(ends) / 2) for key, ends in unknowns.items() if key != "C"}
    for key in middle:
        for end, side in zip(unknowns[key], ("low", "high"), strict=True):
            if not is_bistable(device, middle | {key: np.full(1, end)}, 1).all():
                remedy = "higher" if side == "low" else "lower"
                where = f"its {side} end, {end:g} {KIND_OF[key].unit}; write a {remedy} one"
                raise ValueError(f"unknowns: {key}: no second stable shape at {where}")


def _range(key):
    return Annotated[
        tuple, Pair(KIND_OF[key])
    ], "range of an unknown, a pair of values; known if left out"


@record
class UnknownsSection(row_of_kinds("Ranges", {key: _range(key) for key in (*VALUES, "C")})):
    """One to four values of the device, or C, with the range of each."""


@record
class CalibrationSection:
    """Values estimated from measured shots."""

    shots: StudyPath
    """a CSV table: N, f0 (Hz) or duration (ms), tripped (yes, no), optionally direction, shape,
    file (a record)"""
    unknowns: UnknownsSection
    """one to four values of the device, or C, with the range of each"""
    C: Damper | None = None
    """damping of the mass in the shots; unknown, or that of `sweep`, if left out"""


class Calibration(NamedTuple):
    """Measured shots and the unknowns to estimate from them.

    files: SHA-256 of the table of shots and of the records that it names, by path
    unknowns: ranges by name, internal units; C: uN us/um, or None if it is unknown
    """

    shots: Shots
    files: dict[str, str]
    unknowns: dict[str, list[float]]
    C: float | None


def read_calibration(
    section: CalibrationSection, device: Device | Mapping, shocks: Shocks, C: np.ndarray
) -> Calibration:
    """Take the section; raises ValueError, one line, for invalid ones.

    shocks: the first is the default of shots; C: of the sweep; a single value is the default
    """
    unknowns = {key: list(ends) for key, ends in told(section.unknowns).items()}
    damping = section.C
    if damping is None and "C" not in unknowns and C.size == 1:
        damping = float(C[0])
    if isinstance(device, Mapping):
        raise ValueError("needs a single device; write device instead of devices")
    check_ranges(unknowns, damping, device)
    files = {section.shots: sha256_of(section.shots, *ROWS)}
    table = read_shots(section.shots, files[section.shots], N_of_g(device.gravity))
    for file in table.get("file", []):
        if file and file not in files:
            files[file] = sha256_of(inside(file), *RECORD)
    shots = shots_from(table, shocks.first(), device)
    return Calibration(shots, files, unknowns, damping)
