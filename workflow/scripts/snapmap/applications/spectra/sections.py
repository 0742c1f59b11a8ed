"""Sections of vibration and of shock response spectra among the requirements."""

from ...config.keys import Section, key, many, quantity, word
from ...config.shocks import PUSHED, PUSHES, PulseSection
from ...config.units import read, show
from ..requirements.sections import NAME, snaps
from .psd import REACH, Spectrum
from .required import RequiredSpectrum, RequiredVibration
from .srs import check_points


def _points(name, unit, such, what, example):
    """Pairs of a frequency and what a spectrum has there."""

    def level(value):
        number, _, written = str(value).strip().partition(" ")
        if written.replace("²", "^2").replace("**", "^") != unit:
            raise ValueError(f"{show(value)} is no {name}; write one such as '{such} {unit}'")
        return read(number, "number")

    pair = tuple[quantity("frequency"), key(level, name)]
    need = f"a list of two pairs or more of a frequency and a {name}, ascending: {what}"
    return many(pair, need, example, least=2)


class VibrationSection(Section):
    """Random vibration that must, or must not, trip the device."""

    name: NAME
    snaps: snaps()
    psd: _points(
        "density",
        "g^2/Hz",
        "0.04",
        "random vibration",
        "[[20 Hz, 0.01 g^2/Hz], [2000 Hz, 0.04 g^2/Hz]]",
    )
    duration: quantity("pulse", "of the vibration", "3 min")
    probability: quantity(
        "share", "that vibration may trip the device, or miss it", "1 %", f"`{100 * REACH:g} %`"
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

    def under(self, pulse: PulseSection | None) -> RequiredVibration:
        """The requirement in a study; vibration has no pulse."""
        over = {"duration": 1e-6 * self.duration, "probability": self.probability or REACH}
        return RequiredVibration(
            {"name": self.name, "snaps": self.snaps, "psd": self.points} | over
        )


class SpectrumSection(Section):
    """A shock response spectrum that must, or must not, trip the device."""

    name: NAME
    snaps: snaps()
    srs: _points(
        "level",
        "g",
        "1500",
        "a shock response spectrum (quality factor 10)",
        "[[100 Hz, 100 g], [1000 Hz, 1500 g], [10 kHz, 1500 g]]",
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

    def under(self, pulse: PulseSection | None) -> RequiredSpectrum:
        """The requirement in a study, whose direction holds unless it has its own."""
        direction = self.direction or (pulse and pulse.direction) or "+z"
        return RequiredSpectrum(
            {"name": self.name, "snaps": self.snaps, "srs": self.points, "direction": direction}
        )
