"""Random vibration: its spectrum, and seeded records of it."""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ...files.text import describe
from ...numerics.portable import sines
from ...pulse.pulse import G, Pulse, straight
from ...values.arguments import Reading
from ...values.faults import Faults, few
from ...values.kinds import Kind, Whole, kind_of
from ...values.quantities import Frequency, Value, single
from ...values.units import is_plain, plain_numbers

LEAST = 2
"""Least number of points."""
MS2 = 1e-6 / G
LEVELS = {"g": 1.0, "gn": 1.0, "m/s^2": MS2}
DENSITIES = {"g^2/Hz": 1.0, "g2/Hz": 1.0, "gn^2/Hz": 1.0}
DENSITIES |= dict.fromkeys(("(m/s^2)^2/Hz", "m^2/s^4/Hz", "m^2/s^3"), MS2 * MS2)
"""Factors to multiples of standard gravity, and to their squares in 1 Hz, by unit."""
_LEVEL = re.compile(r"(\S*[\d.]) *([gm(].*)")


def _listed(value):
    """List the numbers of an array; leave anything else as it is."""
    array = None if isinstance(value, list | tuple) else plain_numbers(value)
    return value if array is None or not array.ndim else array.tolist()


@dataclass(frozen=True)
class Points(Kind):
    """Points of a spectrum, which ascend; levels are numbers in the first of the units, or text."""

    noun: str
    units: Mapping[str, float]
    example: str
    type = list[tuple[float, float]]

    @property
    def need(self) -> str:  # type: ignore[override]
        """What is right in Python, in words that follow "is not"."""
        of = "Hz and multiples of g" if "g" in self.units else "Hz and g^2/Hz"
        return f"two pairs or more of {of}, above 0 and ascending, such as {self.example}"

    @property
    def asks(self) -> str:
        """What is right in a config, in words that follow "write"."""
        return f"a list of two pairs or more of a frequency and a {self.noun}, above 0, ascending"

    def convert(self, value: object, reading: Reading) -> np.ndarray:
        """Convert pairs to an array, (points, 2); of Python also an array."""
        pairs = _listed(value)
        if not isinstance(pairs, list | tuple) or len(pairs) < LEAST:
            raise self.refuse(value, reading)
        points, faults = [], []
        for place, item in enumerate(map(_listed, pairs)):
            if not (isinstance(item, list | tuple) and len(item) == 2):
                faults.append(f"[{place}]: {describe(item)} is not a pair")
                continue
            for inner, convert in enumerate((kind_of(Frequency).convert, self._level)):
                try:
                    points.append(convert(item[inner], reading))
                except ValueError as error:
                    faults.append(f"[{place}][{inner}]: {error}")
        if faults:
            raise Faults(*few(faults))
        made: np.ndarray = np.reshape(points, (-1, 2))
        if not (np.diff(made[:, 0]) > 0).all():
            raise ValueError(f"frequencies and values are not {self.wants(reading)}")
        return made

    def schema(self) -> dict:
        """Describe a list of pairs."""
        pair = {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2}
        return {"type": "array", "items": pair, "minItems": LEAST}

    def _level(self, value, reading):
        """Convert text with a unit, or a number of Python."""
        if not (reading.written or isinstance(value, str)):
            return single(f"a {self.noun}").take(value)
        match = _LEVEL.fullmatch(value.strip()) if isinstance(value, str) else None
        number, unit = match.groups() if match else ("", "")
        unit = unit.replace("**", "^").replace("²", "^2").replace(" ", "")
        if not is_plain(number) or unit not in self.units:
            lacks = "has no unit" if is_plain(value) else "is not a number with a unit"
            such = ", ".join(self.units)
            raise ValueError(f"{describe(value)} {lacks}; write a {self.noun} in one of {such}")
        return float(number) * self.units[unit]


REACH = 0.01
"""Default probability of a snap within the duration of the vibration."""
SECONDS, PERIODS = 1.0, 10.0
"""A record lasts SECONDS, s, or PERIODS of the lowest frequency if these are longer."""
PER_PERIOD = 16
"""Samples in a period of the highest frequency. Straight lines between them lower its amplitude by
1.3 %, which `record` corrects, and add images of 0.4 %."""
MOST_SAMPLES = 2**21
"""Most samples of a record, 100 MB; a record of 1 Hz to 10 kHz has as many."""

Density = Annotated[Value, Points("density", DENSITIES, "[(20, 0.04), (2000, 0.04)]")]
Records = Annotated[int, Whole(1, 10_000)]


class Spectrum:
    """One-sided density of the frame's acceleration, straight between points on logarithmic scales.

    points: pairs of frequency (Hz) and density (g^2/Hz), ascending; ValueError for invalid ones
    """

    def __init__(self, points: Sequence[Sequence[float]]):
        """Take the points."""
        self.f, self.density = np.asarray(points, float).T
        ratios = zip(self.density[1:] / self.density[:-1], self.f[1:] / self.f[:-1], strict=True)
        self._slopes = np.array([math.log(S) / math.log(f) for S, f in ratios])

    def at(self, f: np.ndarray) -> np.ndarray:
        """Density at frequencies, g^2/Hz; 0 outside the points."""
        k = np.clip(np.searchsorted(self.f, f, side="right") - 1, 0, self.f.size - 2)
        within = (f >= self.f[0]) & (f <= self.f[-1])
        # Of single numbers: numpy's powers of arrays round by the processor.
        powers = zip((f / self.f[k]).tolist(), self._slopes[k].tolist(), strict=True)
        rises = np.array([ratio**slope for ratio, slope in powers])
        return np.where(within, self.density[k] * rises, 0.0)

    @property
    def rms(self) -> float:
        """Root mean square of the acceleration, multiples of g."""
        total, ratios = 0.0, self.f[1:] / self.f[:-1]
        for f, S, ratio, slope in zip(self.f, self.density, ratios, self._slopes, strict=False):
            power = slope + 1
            share = math.log(ratio) if abs(power) < 1e-9 else (ratio**power - 1) / power
            total += f * S * share
        return math.sqrt(total)

    def record_length(self, duration: float) -> float:
        """Return the length of one record, s, of a vibration; duration: s."""
        return min(duration, max(SECONDS, PERIODS / self.f[0]))

    def require_record(self, duration: float) -> None:
        """Raise ValueError, one line, if a record is too long or has no sine; duration: s."""
        length, (low, high) = self.record_length(duration), self.f[[0, -1]]
        samples = PER_PERIOD * high * length
        if samples > MOST_SAMPLES:
            raise ValueError(
                f"psd: a record of {length:.4g} s, from {low:g} to {high:g} Hz, has {samples:.2g} "
                f"samples, more than {MOST_SAMPLES:.2g}; write a higher lowest frequency, or a "
                "lower highest"
            )
        if math.floor(high * length) / length < low:
            line = f"of {length:.4g} s has no sine between {low:g} and {high:g} Hz; write"
            if length < SECONDS:
                raise ValueError(f"duration: a record {line} a longer time")
            raise ValueError(f"psd: a record {line} frequencies that are farther apart")

    def record(self, length: float, seed: Sequence[int]) -> tuple[Pulse, float]:
        """Draw a stationary Gaussian record, linear between samples.

        a = sum sqrt(2 S df) cos(2 pi f t + phase), over f = df, 2 df, ..., with df = 1/length and
        uniformly distributed phases. The first and the last sample are set to 0.
        length: s; seed: of the phases
        Returns the record over its peak, and the peak, multiples of g.
        """
        samples = 1 << math.ceil(math.log2(PER_PERIOD * self.f[-1] * length))
        lines = np.arange(1, math.floor(self.f[-1] * length) + 1)
        f, share = lines / length, lines / samples
        # Straight lines between samples keep this share of an amplitude.
        kept = (sines(share / 2) / (np.pi * share)) ** 2
        amplitude = np.sqrt(2 * self.at(f) / length) / kept
        turns = np.random.default_rng(seed).random(f.size)
        bins = np.zeros(samples // 2 + 1, complex)
        bins[lines] = amplitude * (sines(turns + 0.25) + 1j * sines(turns)) * samples / 2
        acceleration = np.append(np.fft.irfft(bins, samples), 0.0)
        acceleration[0] = 0.0
        peak = float(abs(acceleration).max())
        x = np.arange(samples + 1) / samples
        return Pulse("vibration", straight(x, acceleration / peak), 1e6 * length), peak
