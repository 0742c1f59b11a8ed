"""Required vibration and required shock response spectra, and their verdicts."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any, ClassVar, Self

import numpy as np

from ...config.shocks import PulseSection, Push
from ...pulse.shocks import HANDOUT_SHOCK, Shocks, make_shocks
from ...solver.settings import FIRST
from ...study.shock import SnapsOrArrives
from ...study.study import ARRIVES, Study
from ...values.quantities import PulseTime, Share, Title
from ...values.records import record
from ..application import Config
from ..requirements.verdict import MET, UNCLEAR, VIOLATED, Verdict, each_device
from .psd import REACH, Density, Spectrum
from .srs import Levels, check_points


class Shaking:
    """What vibration and shock response spectra share: they begin in the first shape."""

    name: str
    snaps: bool | str
    start: ClassVar[str] = FIRST

    def under(self, pulse: PulseSection | None, gravity: float) -> Self:
        """Make the requirement of a study, whose N does not count."""
        return self

    def shaken(self, study: Study) -> Study:
        """Give a study of a beam at rest in its first shape."""
        return study.but(start=self.start)

    def check(self, study: Config, C: Sequence[float]) -> list[Verdict]:
        """Judge each device at each temperature by the level from which it trips."""
        each = each_device(self.shaken(study), study.temperatures)
        return [verdict for name, shaken in each for verdict in self.judged(shaken, name, C)]

    def judged(self, study: Study, device: str, C: Sequence[float]) -> Iterator[Verdict]:
        """Judge one device, of this name, at each C (uN us/um)."""
        raise NotImplementedError

    def require(self, study: Study) -> None:
        """Raise ValueError if a force pushes the beam, as then no frame is shaken."""
        study.require_frame("a spectrum among the requirements")

    def plain(self) -> dict[str, Any]:
        """All values, the points of a spectrum as lists."""
        return {key: np.array(value).tolist() for key, value in vars(self).items()}

    def _verdict(self, place, snapped, bounds):
        """Make a verdict.

        place: its fields of shock and corner; bounds: ends of its level, the level, and its error
        """
        low, high, level, error = bounds
        # ASSUME: a beam need only arrive, as vibration has no end after which it could stay.
        N, must, verdict = place["N"], bool(self.snaps), UNCLEAR
        if low > N or high < N:
            verdict = MET if (high < N) == must else VIOLATED
        return Verdict(
            **place,
            requirement=self.name,
            f0=np.nan,
            must_snap=must and ARRIVES,
            outcome="snapped" if snapped else "unsnapped",
            N_first=level,
            N_error=error,
            margin=level / N,
            margin_error=error / N,
            verdict=verdict,
        )


@record
class RequiredVibration(Shaking):
    """Random vibration that must, or must not, trip the device; `true` counts as `arrives`."""

    shocks: ClassVar[Shocks] = HANDOUT_SHOCK
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

    def judged(self, study: Study, device: str, C: Sequence[float]) -> Iterator[Verdict]:
        """Judge by the level of the vibration at which a trip is as probable as allowed.

        N, N_first, N_error are levels in g rms; N_error is the wider half of the bounds.
        """
        from .vibration import RECORDS, SEED, vibration_of  # late, as it takes long to import

        reach = 1 - self.probability if self.snaps else self.probability
        drawn = {"records": RECORDS, "seed": SEED, "reach": reach, "duration": 1e-6 * self.duration}
        rates = vibration_of(study, {"C": C}, Spectrum(self.psd), drawn)
        place = {"device": device, "temperature": study.device.temperature, "shape": "random"}
        place |= {"direction": "both", "N": rates.rms.item(), "duration": 1e-3 * self.duration}
        keys = "snaps", "level_low", "level_high", "level"
        columns = (rates[key].values.tolist() for key in keys)
        for damping, snaps, low, high, level in zip(C, *columns, strict=True):
            error = max(high - level, level - low) if np.isfinite(level) else np.nan
            yield self._verdict(place | {"C": damping}, snaps > 0, (low, high, level, error))


@record
class RequiredSpectrum(Shaking):
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

    def under(self, pulse: PulseSection | None, gravity: float) -> Self:
        """Make the requirement of a study, whose direction holds unless it has its own."""
        return replace(self, direction=self.direction or (pulse and pulse.direction) or "+z")

    @property
    def shocks(self) -> Shocks:
        """The directions."""
        return make_shocks(direction=self.direction)

    def judged(self, study: Study, device: str, C: Sequence[float]) -> Iterator[Verdict]:
        """Judge by the factor of the spectrum from which its records trip.

        If it must snap, all records snap it. N, N_first, N_error are factors of the spectrum;
        N_error is half a step of them.
        """
        from .trips import FACTORS, RECORDS, SEED, ends, trips_of

        must, drawn = self.snaps, {"records": RECORDS, "seed": SEED}
        for shocks in self.shocks.each():
            try:
                tested = trips_of(study.under(shocks), {"C": C}, self.srs, drawn)
            except ValueError as error:  # a spectrum that no record meets is seen only here
                raise ValueError(f"{self.name}: {error}") from None
            place = {"device": device, "temperature": study.device.temperature, "duration": np.nan}
            place |= {"shape": "spectrum", "direction": shocks.direction, "N": 1.0}
            for damping, snaps in zip(C, tested.snaps.values, strict=True):
                low, high = ends(snaps)[2:] if must else ends(snaps)[:2]
                snapped = (np.all if must else np.any)(snaps[:, FACTORS.index(1.0)] == 1)
                level = ((high + low) / 2, (high - low) / 2) if high < np.inf else (np.nan, np.nan)
                yield self._verdict(place | {"C": damping}, snapped, (low, high, *level))
