"""A pulse: the acceleration of the frame over time. The only room that knows its shapes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated

import numpy as np

from ..device.argument import Argument, of_type
from ..device.checks import numbers
from ..numerics import portable

VERSED_SINE = "versed sine"
DIRECTIONS = {"+z": 1.0, "-z": -1.0}
"""The frame's acceleration at N above 0; along +z it presses the mass down on the beam."""
Series = Annotated[
    np.ndarray, Argument("a row of numbers", lambda value: numbers(value) is not None, numbers)
]
NO_JUMP = 1e-12
"""Value over the peak up to which the begin or end of a pulse is no jump."""
AT_REST, BASELINE = 0.05, 0.005
"""Shares of the peak below which a recorded shock is over, and its level at rest should lie."""
NOISE = 0.01
"""Root mean square of a record's noise over its peak, from which on it is reported."""
PULLED = 0.05
"""Share of a pulse that points back up to which the mass stays on the beam."""
COARSE = 8.0
"""Samples in a period of the device below which a record is too coarse for it."""
SHARES = ("rise", "fall")
"""What a trapezoid takes, as shares of its duration."""
TENTH = 0.1
"""Rise and fall of a trapezoid over its duration, unless given."""


@dataclass(frozen=True, eq=False)
class Pulse:
    """A shape of peak 1 over x = t/duration from 0 to 1; `sampled` and `read_pulse` make one.

    duration: us, of a recorded shock or a train; None where f0 sets it
    peak: um/us^2, of a recorded shock in known units, else NaN
    notes: warnings about a recorded shock
    own_N: amplitude of a drop from its height, multiples of g

    >>> saw = snapmap.sampled([0.0, 100.0, 400.0], [0.0, 1.0, 0.0])
    """

    name: str
    pieces: np.ndarray
    """(pieces, 6), as in `numerics.pieces`."""
    duration: float | None = None
    peak: float = np.nan
    given: Mapping = field(default_factory=dict)
    """The section `pulse` of a config that makes it."""
    notes: tuple[str, ...] = ()
    blows: np.ndarray = field(default_factory=lambda: np.empty(0))
    """x at which each blow of a train begins, ascending; empty for other pulses."""
    swing: float = 1.0
    """Share of the duration that the shortest blow takes."""
    strongest: "Pulse | None" = None
    """The blow of a train that changes the velocity most, over the train's peak."""
    own_N: float | None = None

    @cached_property
    def ends(self) -> tuple[float, float]:
        """Values at its begin and end; 0 where it does not jump there, as a train never does."""
        if self.blows.size:
            return 0.0, 0.0
        begin, end = self.at(np.array([0.0, 1.0])).tolist()
        return begin if abs(begin) > NO_JUMP else 0.0, end if abs(end) > NO_JUMP else 0.0

    @property
    def curve(self) -> tuple[np.ndarray, tuple[float, float]]:
        """Pieces and ends, as `numerics.pieces` takes them."""
        return self.pieces, self.ends

    @cached_property
    def area(self) -> float:
        """Velocity change over peak times duration."""
        return float(np.sum(self._areas))

    @property
    def is_of_frame(self) -> bool:
        """Whether it is an acceleration in units of its own: a record, or a drop."""
        return self.own_N is not None or bool(np.isfinite(self.peak))

    @property
    def alone(self) -> "Pulse":
        """The strongest blow of a train, alone; else itself."""
        return self.strongest or self

    @property
    def impact(self) -> float:
        """Velocity change of the strongest blow over peak times the pulse's duration."""
        if self.strongest is None:
            return self.area
        return self.strongest.area * self.strongest.duration / self.duration

    @cached_property
    def gross_area(self) -> float:
        """Integral of its absolute value, or a little more, over peak times duration."""
        begin, value, slope, turns, _, _ = self.pieces.T
        length = np.diff(begin, append=1.0)
        straight = length * (abs(value) + abs(value + slope * length)) / 2
        # The sines of `SHAPES` keep their sign.
        return float(np.sum(np.where(turns > 0, abs(self._areas), straight)))

    @property
    def _areas(self):
        """Integral of each piece over x."""
        begin, value, slope, turns, lift, swing = self.pieces.T
        length = np.diff(begin, append=1.0)
        straight = length * (value + lift + slope * length / 2)
        phase = np.where(turns > 0, 2 * np.pi * turns, 1.0)
        turned = phase * length
        waves = (swing * (1 - np.cos(turned)) - lift * np.sin(turned)) / phase
        return straight + np.where(turns > 0, waves, 0.0)

    @cached_property
    def variation(self) -> float:
        """All its ups and downs, over the peak: no undamped linear oscillator answers by more."""
        values = np.concatenate([[0.0], self.at(self._places), [0.0]])
        return float(np.sum(abs(np.diff(values))))

    @property
    def swings(self) -> float:
        """Its duration over that of a swing, the fastest of a train."""
        return max(1.0, self.variation / 2, 1 / self.swing)

    @cached_property
    def highest(self) -> float:
        """Its highest value along +z; 0 where it only pulls."""
        return float(max(0.0, self.at(self._places).max()))

    @cached_property
    def is_smooth(self) -> bool:
        """Whether its slope has no jump, within or at its ends, that would ring the beam."""
        begin, _, slope, turns, lift, swing = self.pieces.T
        ends, place = np.unique(turns * np.diff(begin, append=1.0), return_inverse=True)
        sine, cosine = (np.vectorize(portable.sine)(ends + turn)[place] for turn in (0.0, 0.25))
        rate = 2 * np.pi * turns
        first, last = slope + rate * swing, slope + rate * (lift * sine + swing * cosine)
        jumps = np.append(first, 0.0) - np.insert(last, 0, 0.0)
        return not any(self.ends) and bool(abs(jumps).max() < NO_JUMP)

    @property
    def pulls(self) -> bool:
        """Whether more than PULLED of it points away from the beam, and the mass comes back."""
        return self.gross_area - self.area > 2 * PULLED * self.gross_area

    @property
    def strikes(self) -> bool:
        """Whether it leaves the mass to strike with a run-up: it pulls, or blows again."""
        return self.pulls or self.blows.size > 1

    @property
    def _places(self):
        """Its x for extremes: the ends of all pieces, the tops of half turns, and 1001 others."""
        ends = np.append(self.pieces[:, 0], 1.0)
        tops = ((ends[1:] + ends[:-1]) / 2)[self.pieces[:, 3] > 0]
        return np.union1d(np.append(ends, tops), np.linspace(0.0, 1.0, 1001))

    @cached_property
    def steepest(self) -> float:
        """Largest slope over that of the versed sine, pi; inf where it jumps."""
        _, _, slope, turns, lift, swing = self.pieces.T
        if any(self.ends):
            return np.inf
        return float(np.max(abs(slope) + 2 * np.pi * turns * np.hypot(lift, swing)) / np.pi)

    def at(self, x: np.ndarray) -> np.ndarray:
        """Acceleration over peak at x, any shape; 0 outside 0 to 1."""
        k = np.clip(np.searchsorted(self.pieces[:, 0], x, side="right") - 1, 0, None)
        begin, value, slope, turns, lift, swing = self.pieces[k].T
        s = np.asarray(x) - begin
        a, sine = value + slope * s, np.vectorize(portable.sine)
        if turns.any():
            a = a + lift * (2 * sine(turns * s * 0.5) ** 2) + swing * sine(turns * s)
        return np.where((x >= 0) & (x <= 1), a, 0.0)

    def doubts(self, own_frequency: float, lasts: float) -> list[str]:
        """Lines on what a recorded shock may leave out of a device's answer.

        own_frequency: the device's, rad/us; lasts: us, as it is used
        """
        lines, period = list(self.notes), 2 * np.pi / own_frequency
        step = np.diff(self.pieces[:, 0], append=1.0).max() * lasts
        if self.duration is not None and not self.blows.size and step * COARSE > period:
            lines.append(f"samples {step:.3g} us apart are coarse for a period of {period:.3g} us")
        return [f"{self.name}: {line}" for line in lines]

    def reversed(self) -> "Pulse":
        """The same along the other direction."""
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
"""Pieces, as in `numerics.pieces`, of each shape by name; rise, fall: shares of the duration."""


def straight(x: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Pieces that join values, (points,), at ascending x from 0 to 1, by straight lines."""
    kept = np.diff(x) > 0
    pieces = np.zeros((np.count_nonzero(kept), 6))
    pieces[:, 0], pieces[:, 1] = x[:-1][kept], values[:-1][kept]
    pieces[:, 2] = np.diff(values)[kept] / np.diff(x)[kept]
    return pieces


def sampled(
    time: Series, acceleration: Series, name: Annotated[str, of_type("a name", str)] = "recorded"
) -> Pulse:
    """Make a pulse of samples, which keeps its duration and is linear between them.

    time: us, ascending, (samples,)
    acceleration: along +z, (samples,), in any unit; N scales its largest value

    >>> snapmap.sampled([0.0, 100.0, 400.0], [0.0, 1.0, 0.0]).duration
    400.0
    """
    time, acceleration = (np.asarray(values, float) for values in (time, acceleration))
    if time.ndim != 1 or time.shape != acceleration.shape or time.size < 2:
        raise ValueError("time and acceleration are not two rows of two samples or more")
    if not (np.isfinite(time).all() and np.isfinite(acceleration).all()):
        raise ValueError("a sample is not a finite number")
    if (wrong := np.flatnonzero(np.diff(time) <= 0)).size:
        raise ValueError(f"time of sample {wrong[0] + 2} is not after the one before; sort them")
    peak, lasts = abs(acceleration).max(), time[-1] - time[0]
    if peak == 0:
        raise ValueError("the acceleration is 0 throughout; record a shock")
    values = acceleration / peak
    if abs(values[-1]) > AT_REST:
        raise ValueError(
            f"the acceleration ends at {abs(values[-1]):.0%} of its peak; record until it is over"
        )
    pieces = straight((time - time[0]) / lasts, values)
    return Pulse(name, pieces, float(lasts), given={"shape": name}, notes=_notes(values))


def _notes(values):
    """Lines on a record over its peak: a jump, an offset, noise."""
    notes = []
    if abs(values[0]) > AT_REST:
        notes.append(f"begins with a jump, at {values[0]:.0%} of its peak")
    shock = np.flatnonzero(abs(values) > AT_REST)
    rests = {"before": values[: shock[0]], "after": values[shock[-1] + 1 :]}
    for when, quiet in rests.items():
        low, baseline, high = np.percentile(quiet, [10, 50, 90]) if quiet.size else np.zeros(3)
        if abs(baseline) > max(BASELINE, high - low):
            notes.append(
                f"is offset by {baseline:.1%} of its peak {when} the shock; subtract the offset"
            )
    # White noise leaves 3/2 of its square in what a sample differs from the mean of its neighbours,
    # and that turns its sign from one to the next; of a smooth record it keeps its sign.
    rough = values[1:-1] - (values[2:] + values[:-2]) / 2
    square = np.sum(rough * rough)
    noise = np.sqrt(square / (1.5 * max(1, rough.size)))
    if noise > NOISE and np.sum(rough[1:] * rough[:-1]) < -square / 3:
        notes.append(f"has noise of {noise:.1%} of its peak, and N scales that peak; filter it")
    return tuple(notes)


def make_pulse(shape: str = VERSED_SINE, **shares: float) -> Pulse:
    """Make a pulse of a shape known by name; shares: a trapezoid's rise and fall."""
    return Pulse(shape, np.array(SHAPES[shape](**shares)), given={"shape": shape, **shares})


def table(pulses: Sequence[Pulse]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Collect pulses for kernels.

    Returns all pieces, (pieces, 6); bounds, (pulses + 1,): those of pulse i are bounds[i] up to
    before bounds[i + 1]; and the `ends`, (pulses, 2).
    """
    bounds = np.cumsum([0, *(len(pulse.pieces) for pulse in pulses)])
    pieces = np.concatenate([pulse.pieces for pulse in pulses])
    return pieces, bounds, np.array([pulse.ends for pulse in pulses])


def blow_at(pulses: Sequence[Pulse], which: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Number from 1 of the blow of a train that began last before x, int32; 0 where x is NaN.

    which: index of the pulse of each, in the shape of x
    """
    number = np.zeros(np.shape(x), np.int32)
    for place, pulse in enumerate(pulses):
        rows = (which == place) & np.isfinite(x)
        number[rows] = np.searchsorted(pulse.blows, x[rows], side="right")
    return number
