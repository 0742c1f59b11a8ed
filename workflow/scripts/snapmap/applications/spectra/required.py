"""Vibrations and spectra that must, or must not, trip a device."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...study.study import Study


@dataclass(frozen=True, eq=False)
class RequiredVibration:
    """A required vibration; values: name, psd, duration (s), snaps and probability."""

    values: dict

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts by the level at which it trips as likely as it may; nothing beside."""
        from .verdicts import check_vibrations

        verdicts = check_vibrations(study, [self.values], C, study.temperatures)
        return [(verdict, {}) for verdict in verdicts]

    def require(self, study: Study) -> None:
        """Raise ValueError where forces push the beam, and no frame is shaken."""
        study.require_frame("a spectrum among the requirements")

    def plain(self) -> dict:
        """All of it."""
        return self.values


class RequiredSpectrum(RequiredVibration):
    """A required shock response spectrum; values: name, srs, direction and snaps."""

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts by the factor from which a record of it trips; nothing beside."""
        from .verdicts import check_spectra

        return [
            (verdict, {}) for verdict in check_spectra(study, [self.values], C, study.temperatures)
        ]
