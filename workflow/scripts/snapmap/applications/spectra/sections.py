"""Sections of vibration and of shock response spectra among the requirements."""

from ...config.kinds import Title
from ...config.shocks import PulseSection, Push
from ...study.shock import SnapsOrArrives
from ...values.quantities import PulseTime, Share
from ...values.records import record
from .psd import REACH, Density, Spectrum
from .required import RequiredSpectrum, RequiredVibration
from .srs import Levels, check_points


@record
class VibrationSection:
    """Random vibration that must, or must not, trip the device; `true` counts as `arrives`."""

    name: Title
    """unique name"""
    snaps: SnapsOrArrives
    """whether the device must trip"""
    psd: Density
    """one-sided density, as [[20 Hz, 0.01 g^2/Hz], [2000 Hz, 0.04 g^2/Hz]]"""
    duration: PulseTime
    """duration of the vibration, such as 3 min"""
    probability: Share = REACH
    """largest allowed probability that it trips, or, where it must trip, that it does not"""

    def __post_init__(self):
        """Raise ValueError for what cannot be in any study."""
        Spectrum(self.psd).require_record(1e-6 * self.duration)

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredVibration:
        """Make the requirement; vibration depends on neither the study's pulse nor N."""
        points, duration = self.psd.tolist(), 1e-6 * self.duration
        return RequiredVibration(self.name, self.snaps, points, duration, self.probability)


@record
class SpectrumSection:
    """A shock response spectrum that must, or must not, trip it; `true` counts as `arrives`."""

    name: Title
    """unique name"""
    snaps: SnapsOrArrives
    """whether the device must trip"""
    srs: Levels
    """a spectrum (quality factor 10), as [[100 Hz, 100 g], [1 kHz, 1500 g]]"""
    direction: Push | None = None
    """+z presses the mass on the beam; that of `pulse` if left out"""

    def __post_init__(self):
        """Raise ValueError for what cannot be in any study."""
        check_points(self.srs)

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredSpectrum:
        """Make the requirement of a study, whose direction holds unless the section has its own."""
        direction = self.direction or (pulse and pulse.direction) or "+z"
        return RequiredSpectrum(self.name, self.snaps, self.srs.tolist(), direction)
