"""Sections of vibration and of shock response spectra among the requirements."""

from ...config.keys import Section, key, many, quantity, word
from ...config.shocks import PUSHED, PUSHES, PulseSection
from ...config.units import read, show
from ...study.study import ARRIVES
from ..requirements.sections import NAME, snaps
from .psd import REACH, Spectrum
from .required import RequiredSpectrum, RequiredVibration
from .srs import check_points


def _points(name, unit, such, what, example):
    """Make the type of a spectrum: pairs of a frequency and a density or level."""

    def level(value):
        number, _, written = str(value).strip().partition(" ")
        if written.replace("²", "^2").replace("**", "^") != unit:
            raise ValueError(f"{show(value)} is not a {name}; write one such as '{such} {unit}'")
        return read(number, "number")

    pair = tuple[quantity("frequency"), key(level, name)]
    need = f"a list of two pairs or more of a frequency and a {name}, ascending: {what}"
    return many(pair, need, example, least=2)


class VibrationSection(Section):
    """Random vibration that must, or must not, trip the device; `true` counts as `arrives`."""

    name: NAME
    snaps: snaps(ARRIVES)
    psd: _points(
        name="density",
        unit="g^2/Hz",
        such="0.04",
        what="random vibration",
        example="[[20 Hz, 0.01 g^2/Hz], [2000 Hz, 0.04 g^2/Hz]]",
    )
    duration: quantity("pulse", "duration of the vibration", "3 min")
    probability: quantity(
        "share", "largest probability of a wrong result", "1 %", f"`{100 * REACH:g} %`"
    )

    def make(self) -> None:
        """Nothing by itself; ValueError for what cannot be in any study."""
        try:
            Spectrum(self.points).require_record(1e-6 * self.duration)
        except ValueError as error:
            raise ValueError(f".{error}") from None

    @property
    def points(self) -> list[list[float]]:
        """Pairs of Hz and g^2/Hz."""
        return [list(pair) for pair in self.psd]

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredVibration:
        """Make the requirement; vibration depends on neither the study's pulse nor N."""
        duration, probability = 1e-6 * self.duration, self.probability or REACH
        return RequiredVibration(self.name, self.snaps, self.points, duration, probability)


class SpectrumSection(Section):
    """A shock response spectrum that must, or must not, trip it; `true` counts as `arrives`."""

    name: NAME
    snaps: snaps(ARRIVES)
    srs: _points(
        name="level",
        unit="g",
        such="1500",
        what="a shock response spectrum (quality factor 10)",
        example="[[100 Hz, 100 g], [1000 Hz, 1500 g], [10 kHz, 1500 g]]",
    )
    direction: word(*PUSHES, what=PUSHED, out="that of `pulse`")

    def make(self) -> None:
        """Nothing by itself; ValueError for what cannot be in any study."""
        try:
            check_points(self.points)
        except ValueError as error:
            raise ValueError(f".{error}") from None

    @property
    def points(self) -> list[list[float]]:
        """Pairs of Hz and multiples of g."""
        return [list(pair) for pair in self.srs]

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredSpectrum:
        """Make the requirement of a study, whose direction holds unless the section has its own."""
        direction = self.direction or (pulse and pulse.direction) or "+z"
        return RequiredSpectrum(self.name, self.snaps, self.points, direction)
