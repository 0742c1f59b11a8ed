"""Required vibration and required shock response spectra."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from ...solver.settings import FIRST
from ...study.study import Study
from ..application import Config
from ..requirements.required import Judged


@dataclass(frozen=True, eq=False)
class Shaking:
    """What vibration and shock response spectra share; snaps: false, or true for ARRIVES."""

    name: str
    snaps: bool | str
    start: ClassVar[str] = FIRST

    def shaken(self, study: Study) -> Study:
        """Give a study of a beam at rest in its first shape."""
        return replace(study, run=study.run.but(start=self.start))

    def require(self, study: Study) -> None:
        """Raise ValueError if a force pushes the beam, as then no frame is shaken."""
        study.require_frame("a spectrum among the requirements")

    def plain(self) -> dict[str, Any]:
        """All values; they are plain."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class RequiredVibration(Shaking):
    """A required vibration; psd: Hz, g^2/Hz; duration: s; probability: of a wrong result."""

    psd: list[list[float]]
    duration: float
    probability: float

    def check(self, study: Config, C: Sequence[float]) -> Judged:
        """Judge by the level at which a trip is as probable as allowed; no further columns."""
        from .verdicts import check_vibration

        return [(verdict, {}) for verdict in check_vibration(study, self, C, study.temperatures)]


@dataclass(frozen=True, eq=False)
class RequiredSpectrum(Shaking):
    """A required shock response spectrum; srs: pairs of Hz and multiples of g."""

    srs: list[list[float]]
    direction: str

    def check(self, study: Config, C: Sequence[float]) -> Judged:
        """Judge by the factor of the spectrum from which its records trip; no further columns."""
        from .verdicts import check_spectrum

        return [(verdict, {}) for verdict in check_spectrum(study, self, C, study.temperatures)]
