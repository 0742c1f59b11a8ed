"""A pulse, also a recorded one: the acceleration of the frame over time.

Only this room knows the shapes.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated

import numpy as np

from ..files.named import naming, read_named
from ..files.tables import read_table, require_rising
from ..files.text import NAME, is_name, plain, show
from ..numerics.portable import sines
from ..values.kinds import Fitting, Quantity, Word
from ..values.quantities import ExistingPath, Share, single
from ..values.records import record
from ..values.units import numbers_in, unit_of

VERSED_SINE = "versed sine"
DIRECTIONS = {"+z": 1.0, "-z": -1.0}
"""Sign of the frame's acceleration at N above 0; along +z it presses the mass on the beam."""


_ANY = "(-inf, inf)"


def _series(value):
    """Convert numbers, which stay in their unit."""
    return Quantity("a plain number", unit_of(value) or "", interval=_ANY).take(value)


Series = Annotated[Sequence[float] | np.ndarray, Fitting("numbers", by=_series)]
Times = Annotated[Sequence[float | str] | np.ndarray, Quantity("a time", "us", "1 ms", _ANY)]
LASTS, COLUMNS = single("a time", "us"), 6
G = 9.80665e-6
"""What a text means by g, um/us^2; N counts multiples of a device's own gravity."""
NEAR_G = 0.01
"""Relative distance of a gravity from G within which N counts multiples of g."""
NO_JUMP = 1e-12
"""Largest value over the peak at which the begin or end of a pulse is no jump."""
AT_REST, BASELINE = 0.05, 0.005
"""Share of the peak below which a recorded shock is over, and below which its offset should lie."""
NOISE = 0.01
"""Root mean square of a record's noise over its peak above which it is reported."""
FLAT, FLAT_SHARE, FEWEST_FLAT = 1e-3, 0.1, 4
"""A record is flat where samples are so near its peak, for so large a share of the time above half
of it, and at least so many steps; of an 8 bit record of a half sine the share is 0.08."""
PULLED = 0.05
"""Share of a pulse up to which it may point away from the beam and the mass still stays there."""
COARSE = 8.0
"""Fewest samples of a record in a period of the device."""
SHARES = ("rise", "fall")
"""Keys of a trapezoid: shares of its duration."""
TENTH = 0.1
"""Default rise and fall of a trapezoid over its duration."""


def N_of_g(gravity: float) -> float:
    """Give N of a shock of 1 g; gravity: the unit of N, um/us^2, 0 where N counts forces."""
    return 1.0 if not gravity or abs(gravity / G - 1) < NEAR_G else G / gravity


@dataclass(frozen=True, eq=False, repr=False)
class Pulse:
    """A shape of peak 1 over x = t/duration from 0 to 1; `sampled` and `read_pulse` make one.

    Parameters
    ----------
    name
        What stands in files and figures.
    pieces
        Lines and waves, (pieces, 6): begin, value, slope, turns per duration, lift and swing, as in
        `numerics.pieces`.
    duration
        Duration of a recorded shock, train or drop, us; None where f0 sets it.
    peak
        Peak of a recorded shock in known units, or of a drop from its height, um/us^2; else NaN.
    section
        What a config has under `pulse` for it.
    notes
        Warnings about a recorded shock.
    blows
        x at which each pulse of a train begins, ascending; empty for other pulses.
    swing
        Share of the duration that the fastest change of a train takes; 1 for other pulses.
    strongest
        The pulse of a train that changes the velocity most, in units of the train's peak.

    Examples
    --------
    >>> saw = snapmap.sampled([0.0, 100.0, 400.0], [0.0, 1.0, 0.0])
    >>> saw.at(0.125).item()
    0.5
    """

    name: str
    pieces: np.ndarray
    duration: float | None = None
    peak: float = np.nan
    section: Mapping = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    blows: np.ndarray = field(default_factory=lambda: np.empty(0))
    swing: float = 1.0
    strongest: "Pulse | None" = None

    def __post_init__(self):
        if not isinstance(self.name, str):
            raise ValueError(f"pulse: name {show(self.name)} is not text")
        pieces = numbers_in(self.pieces, "")
        if pieces is None or pieces.ndim != 2 or pieces.shape[1] != COLUMNS or not pieces.size:
            need = f"rows of {COLUMNS} numbers; sampled and read_pulse make them"
            raise ValueError(f"pulse: pieces {show(self.pieces)} are not {need}")
        if not np.isfinite(pieces).all():
            raise ValueError("pulse: pieces have a number that is not finite")
        begin = pieces[:, 0]
        if begin[0] != 0 or begin[-1] >= 1 or (np.diff(begin) <= 0).any():
            raise ValueError("pulse: pieces do not begin at 0 and ascend to below 1; sort them")
        try:
            duration = None if self.duration is None else LASTS.take(self.duration)
        except ValueError as error:
            raise ValueError(f"pulse: duration {error}, or None") from None
        object.__setattr__(self, "duration", duration)
        object.__setattr__(self, "pieces", pieces)

    def __eq__(self, other):
        """Compare by value."""
        return isinstance(other, Pulse) and self._key == other._key

    def __hash__(self):
        """Hash by value."""
        return hash(self._key)

    @property
    def _key(self):
        told = self.duration, self.notes, self.swing, self.strongest
        arrays = self.pieces.tobytes(), self.blows.tobytes()
        return self.name, *told, *arrays, repr(self.peak), repr(self.section)

    def __repr__(self):
        """Write the name, as signatures show a pulse as a default."""
        return f"<Pulse {self.name!r}>"

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Values at begin and end; 0 where the pulse does not jump, as a train never does."""
        if self.blows.size:
            return 0.0, 0.0
        begin, end = self.at(np.array([0.0, 1.0])).tolist()
        return begin if abs(begin) > NO_JUMP else 0.0, end if abs(end) > NO_JUMP else 0.0

    @property
    def curve(self) -> tuple[np.ndarray, tuple[float, float]]:
        """Pieces and ends, as kernels take them (`numerics.pieces`)."""
        return self.pieces, self.ends

    @cached_property
    def area(self) -> float:
        """Integral of the pulse over x: velocity change over (peak times duration)."""
        return float(np.sum(self._areas))

    @property
    def is_of_frame(self) -> bool:
        """Whether the amplitude is known: of a record in known units, or of a drop."""
        return bool(np.isfinite(self.peak))

    @property
    def words(self) -> str:
        """The pulse in words: its name, or height, shape and duration of a drop, and rebounds."""
        drop = self.section.get("drop")
        if not drop:
            return self.name
        height, lasts = plain(1e-4 * drop["height"]), plain(1e-3 * drop["duration"])
        shape, rebounds = drop.get("shape", VERSED_SINE), self.blows.size - 1
        again = f", {rebounds} rebound{'s' * (rebounds > 1)}" if rebounds else ""
        return f"drop from {height} cm, {shape} of {lasts} ms{again}"

    @property
    def is_record(self) -> bool:
        """Whether it is made of samples over time."""
        return self.duration is not None and not self.blows.size

    @property
    def alone(self) -> "Pulse":
        """The strongest blow of a train alone; other pulses as they are."""
        return self.strongest or self

    @property
    def impact(self) -> float:
        """Velocity change of the strongest blow over (peak times duration of the pulse)."""
        if self.strongest is None:
            return self.area
        return self.strongest.area * self.strongest.duration / self.duration

    @cached_property
    def gross_area(self) -> float:
        """Integral of |pulse| over x, or slightly more, as lines that change sign are bounded."""
        begin, value, slope, turns, _, _ = self.pieces.T
        length = np.diff(begin, append=1.0)
        lines = length * (abs(value) + abs(value + slope * length)) / 2
        # Waves in `SHAPES` keep their sign.
        return float(np.sum(np.where(turns > 0, abs(self._areas), lines)))

    @property
    def _areas(self):
        """Integral of each piece over x."""
        begin, value, slope, turns, lift, swing = self.pieces.T
        length = np.diff(begin, append=1.0)
        lines = length * (value + lift + slope * length / 2)
        phase = np.where(turns > 0, 2 * np.pi * turns, 1.0)
        sine, cosine = (sines(turns * length + turn) for turn in (0.0, 0.25))
        waves = (swing * (1 - cosine) - lift * sine) / phase
        return lines + np.where(turns > 0, waves, 0.0)

    @cached_property
    def variation(self) -> float:
        """Total variation over the peak, a bound on the response of an undamped oscillator."""
        values = np.concatenate([[0.0], self.at(self._places), [0.0]])
        return float(np.sum(abs(np.diff(values))))

    @cached_property
    def waits(self) -> np.ndarray:
        """Waits and flights between blows, over the duration, (waits,); kernels jump over them."""
        begin, value, slope, turns, _, _ = self.pieces.T
        is_flat = (slope == 0) & (turns == 0) & (abs(value) <= AT_REST)
        return np.diff(begin, append=1.0)[is_flat]

    @property
    def swings(self) -> float:
        """Duration over that of a swing, in a train of the fastest swing."""
        return max(1.0, self.variation / 2, 1 / self.swing)

    @cached_property
    def highest(self) -> float:
        """Largest value over the peak along +z; 0 for a pulse that only pulls."""
        return float(max(0.0, self.at(self._places).max()))

    @cached_property
    def is_smooth(self) -> bool:
        """Whether neither value nor slope jumps anywhere, which would make the beam ring."""
        begin, _, slope, turns, lift, swing = self.pieces.T
        ends = turns * np.diff(begin, append=1.0)
        sine, cosine = (sines(ends + turn) for turn in (0.0, 0.25))
        rate = 2 * np.pi * turns
        first, last = slope + rate * swing, slope + rate * (lift * sine + swing * cosine)
        jumps = np.append(first, 0.0) - np.insert(last, 0, 0.0)
        return not any(self.ends) and bool(abs(jumps).max() < NO_JUMP)

    @cached_property
    def is_flat(self) -> bool:
        """Whether it is constant, so that steps of any length sample it exactly."""
        return len(self.pieces) == 1 and not self.pieces[0, 2:].any()

    @property
    def pulls(self) -> bool:
        """Whether more than PULLED of the pulse points away from the beam."""
        return self.gross_area - self.area > 2 * PULLED * self.gross_area

    @property
    def strikes(self) -> bool:
        """Whether the mass may strike with a run-up: the pulse pulls, or has several blows."""
        return self.pulls or self.blows.size > 1

    @property
    def _places(self):
        """Values of x among which extremes are sought: ends and middles of pieces, and a grid."""
        ends = np.append(self.pieces[:, 0], 1.0)
        tops = ((ends[1:] + ends[:-1]) / 2)[self.pieces[:, 3] > 0]
        return np.union1d(np.append(ends, tops), np.linspace(0.0, 1.0, 1001))

    @cached_property
    def steepest(self) -> float:
        """Largest slope over that of the versed sine, pi; inf for a pulse that jumps."""
        _, _, slope, turns, lift, swing = self.pieces.T
        if any(self.ends):
            return np.inf
        waves = 2 * np.pi * turns * np.sqrt(lift * lift + swing * swing)
        return float(np.max(abs(slope) + waves) / np.pi)

    def at(self, x: np.ndarray) -> np.ndarray:
        """Return acceleration over peak at x, in the shape of x; 0 outside 0 to 1."""
        k = np.clip(np.searchsorted(self.pieces[:, 0], x, side="right") - 1, 0, None)
        begin, value, slope, turns, lift, swing = self.pieces[k].T
        s = np.asarray(x) - begin
        a = value + slope * s
        if turns.any():
            a = a + lift * (2 * sines(turns * s * 0.5) ** 2) + swing * sines(turns * s)
        return np.where((x >= 0) & (x <= 1), a, 0.0)

    def doubts(self, own_frequency: float, lasts: float, gravity: float) -> list[str]:
        """Return a line for each doubt whether a shock is good enough for a device.

        own_frequency, gravity: of the `Device`, rad/us and um/us^2; lasts: in the study, us
        """
        lines, period = [], 2 * np.pi / own_frequency
        if self.blows.size and self.is_of_frame:
            N = f"N = {self.peak / gravity:.5g}"
            lines.append(f"{N} is the fall from its height; another N scales the whole record")
        step = np.diff(self.pieces[:, 0], append=1.0).max() * lasts
        if self.is_record and step * COARSE > period:
            lines.append(f"samples {step:.3g} us apart are coarse for a period of {period:.3g} us")
        return [f"{self.name}: {line}" for line in lines]

    def reversed(self) -> "Pulse":
        """Return the pulse with the opposite sign."""
        flipped = self.pieces * [1.0, -1.0, -1.0, 1.0, -1.0, -1.0]
        strongest = self.strongest and self.strongest.reversed()
        return replace(self, pieces=flipped, strongest=strongest)


SHAPES = {
    VERSED_SINE: lambda: [[0.0, 0.0, 0.0, 1.0, 0.5, 0.0]],  # (1 - cos 2 pi x)/2, the handout's
    "half sine": lambda: [[0.0, 0.0, 0.0, 0.5, 0.0, 1.0]],  # sin pi x
    "sawtooth": lambda: [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]],  # x: terminal peak
    "trapezoid": lambda rise=TENTH, fall=TENTH: straight(
        np.array([0.0, rise, 1 - fall, 1.0]), np.array([0.0, 1.0, 1.0, 0.0])
    ),
}
"""Makers of the pieces of each shape (`numerics.pieces`); rise, fall: shares of the duration."""
ShapeName = Annotated[str, Word(tuple(SHAPES))]


@record
class Form:
    """A shape, with rise and fall of a trapezoid."""

    shape: ShapeName = VERSED_SINE
    """how the acceleration goes over time"""
    rise: Share | None = None
    """part of the duration in which a trapezoid rises or falls; 10 % if left out"""
    fall: Share | None = None
    """part of the duration in which a trapezoid rises or falls; 10 % if left out"""

    def __post_init__(self):
        """Raise ValueError for shares that do not fit."""
        for key in self.shares:
            if self.shape != "trapezoid":
                raise ValueError(f"{key}: is of a trapezoid alone; leave it out")
            if sum({"rise": TENTH, "fall": TENTH, **self.shares}.values()) > 1:
                raise ValueError(f"{key}: shares are more than the duration; write smaller ones")

    @property
    def shares(self) -> dict[str, float]:
        """Shares that are given, by key."""
        shares = {"rise": self.rise, "fall": self.fall}
        return {key: share for key, share in shares.items() if share is not None}

    def make(self) -> "Pulse":
        """Make the pulse."""
        return make_pulse(self.shape or VERSED_SINE, **self.shares)


def straight(x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Make pieces that join values, (points,), at ascending x, (points,), by straight lines."""
    kept = np.diff(x) > 0
    pieces = np.zeros((np.count_nonzero(kept), 6))
    pieces[:, 0], pieces[:, 1] = x[:-1][kept], values[:-1][kept]
    pieces[:, 2] = np.diff(values)[kept] / np.diff(x)[kept]
    return pieces


def sampled(time: Times, acceleration: Series, name: str = "recorded") -> Pulse:
    """Make a pulse of samples, linear between them; it keeps its duration.

    Parameters
    ----------
    time
        Times of the samples, us, ascending, (samples,).
    acceleration
        Acceleration along +z, (samples,), in any unit; N scales its largest absolute value.
    name
        What stands in files and figures.

    Returns
    -------
    Pulse
        The shock, for `Study(device, pulse=...)`; f0 is then None.

    Raises
    ------
    ValueError
        One line, for samples that are no shock from rest to rest.

    Examples
    --------
    >>> snapmap.sampled([0.0, 100.0, 400.0], [0.0, 1.0, 0.0]).duration
    400.0
    """
    masked = (np.ma.asarray(values, float) for values in (time, acceleration))
    time, acceleration = (values.filled(np.nan) for values in masked)
    if time.ndim != 1 or time.shape != acceleration.shape or time.size < 2:
        raise ValueError("time and acceleration are not two rows of two samples or more")
    if not (np.isfinite(time).all() and np.isfinite(acceleration).all()):
        raise ValueError("a sample is not a finite number")
    require_rising(time, "time", "sample", np.arange(1, time.size + 1))
    peak, lasts = abs(acceleration).max(), time[-1] - time[0]
    if peak == 0:
        raise ValueError("the acceleration is 0 throughout; record a shock")
    values = acceleration / peak
    if abs(values[-1]) > AT_REST:
        raise ValueError(
            f"the acceleration ends at {abs(values[-1]):.0%} of its peak; record until it is over"
        )
    pieces = straight((time - time[0]) / lasts, values)
    return Pulse(name, pieces, float(lasts), section={"shape": name}, notes=_notes(time, values))


def _notes(time, values):
    """Return warnings about a record, us and over its peak: a jump, a flat top, offset, noise."""
    notes = []
    if abs(values[0]) > AT_REST:
        notes.append(f"begins with a jump, at {values[0]:.0%} of its peak")
    if (lasts := _flat_top(time, values)) > 0:
        flat = f"is flat at its peak for {1e-3 * lasts:.2g} ms"
        notes.append(f"{flat}, as of a sensor beyond its range")
    shock = np.flatnonzero(abs(values) > AT_REST)
    rests = {"before": values[: shock[0]], "after": values[shock[-1] + 1 :]}
    for when, quiet in rests.items():
        low, baseline, high = np.percentile(quiet, [10, 50, 90]) if quiet.size else np.zeros(3)
        if abs(baseline) > max(BASELINE, high - low):
            notes.append(
                f"is offset by {baseline:.1%} of its peak {when} the shock; subtract the offset"
            )
    # The difference of a sample from the mean of its neighbours has 3/2 of the variance of white
    # noise, and changes sign from sample to sample; in a smooth record it keeps its sign.
    rough = values[1:-1] - (values[2:] + values[:-2]) / 2
    square = np.sum(rough * rough)
    noise = np.sqrt(square / (1.5 * max(1, rough.size)))
    if noise > NOISE and np.sum(rough[1:] * rough[:-1]) < -square / 3:
        notes.append(f"has noise of {noise:.1%} of its peak, and N scales that peak; filter it")
    return tuple(notes)


def _flat_top(time, values):
    """Return how long a record, us and over its peak, stays at its peak; 0 for a usual top."""
    values = values * np.sign(values[abs(values).argmax()])
    spans = []
    for level, fewest in ((1 - FLAT, FEWEST_FLAT), (0.5, 0)):
        above = np.concatenate([[0], values >= level, [0]])
        begins, ends = np.flatnonzero(np.diff(above) > 0), np.flatnonzero(np.diff(above) < 0) - 1
        spans.append(max(np.where(ends - begins >= fewest, time[ends] - time[begins], 0.0)))
    return spans[0] if spans[0] > FLAT_SHARE * spans[1] else 0.0


@cache
def make_pulse(shape: str = VERSED_SINE, **shares: float) -> Pulse:
    """Make a pulse of one of SHAPES, by name; shares: rise and fall of a trapezoid."""
    return Pulse(shape, np.array(SHAPES[shape](**shares)), section={"shape": shape, **shares})


def table(pulses: Sequence[Pulse]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Collect pulses in arrays for kernels.

    Returns all pieces, (pieces, 6); bounds, (pulses + 1,), as pieces bounds[i] up to before
    bounds[i + 1] are those of pulse i; and `ends`, (pulses, 2).
    """
    bounds = np.cumsum([0, *(len(pulse.pieces) for pulse in pulses)])
    pieces = np.concatenate([pulse.pieces for pulse in pulses])
    return pieces, bounds, np.array([pulse.ends for pulse in pulses])


def blow_at(pulses: Sequence[Pulse], which: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return the number, from 1, of the blow that began last before x; 0 for NaN, or no train.

    which: index of the pulse that each x belongs to; both any shape, which the int32 result has
    """
    number = np.zeros(np.shape(x), np.int32)
    for place, pulse in enumerate(pulses):
        rows = (which == place) & np.isfinite(x)
        number[rows] = np.searchsorted(pulse.blows, x[rows], side="right")
    return number


MOST_SAMPLES = 1_000_000
RECORD = 200_000_000, f"write at most {MOST_SAMPLES} samples"
"""Most bytes of a record, and the remedy for more: no shock needs so many samples."""
TIMES = {"s": 1e6, "ms": 1e3, "us": 1.0, "µs": 1.0, "μs": 1.0}
ACCELERATIONS = {"g": G, "m/s^2": 1e-6, "m/s2": 1e-6, "m/s²": 1e-6, "m/s**2": 1e-6}
"""Factors to us and um/us^2, by unit."""


def _is_hash(value):
    return isinstance(value, str) and re.fullmatch("([0-9a-f]{64})?", value)


_HASH = Fitting("the 64 hexadecimal digits of a SHA-256", _is_hash)
Hash = Annotated[str, _HASH]


def read_pulse(path: ExistingPath, sha256: Hash = "") -> Pulse:
    """Read a recorded shock; it keeps its duration, and N scales its largest acceleration.

    Parameters
    ----------
    path
        CSV of time (s, ms or us) and acceleration (g or m/s^2), with units in the header, as
        `time (ms),acceleration (g)`.
    sha256
        Expected hash of the file, 64 hexadecimal digits; empty for any.

    Returns
    -------
    Pulse
        The shock, for `Study(device, pulse=...)`; f0 is then None.

    Raises
    ------
    ValueError
        One line with the path, for a file that is no such record.

    Examples
    --------
    >>> snapmap.read_pulse("config/half_sine.csv").duration
    500.0
    """
    path = Path(path)
    with naming(path):
        content = read_named(path, *RECORD, sha256)
        columns = {"time": TIMES, "acceleration": ACCELERATIONS}
        table = read_table(content, columns, most=MOST_SAMPLES, rising="time")
        time, acceleration = table.values()
        if not is_name(path.stem):
            raise ValueError(f"its name stands in tables; rename it, in {NAME}")
        pulse = sampled(time, acceleration, path.stem)
        section = {"file": str(path)} | ({"sha256": sha256} if sha256 else {})
        return replace(pulse, peak=abs(acceleration).max(), section=section)
