"""What must, or must not, trip a device: an object that checks itself."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from ...study.study import Study


class Required(Protocol):
    """A requirement: a shock, a vibration, a spectrum.

    values: `name`, `snaps`, and what else its kind has
    """

    values: Mapping

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts on each device at each temperature and C (uN us/um), with what stands beside."""

    def require(self, study: Study) -> None:
        """Raise ValueError, one line, where a study cannot have it."""

    def plain(self) -> dict:
        """It in plain values, on which its verdicts depend."""


@dataclass(frozen=True, eq=False)
class RequiredShock:
    """A required shock; values: as `check.check` takes them, with survives and closing demands."""

    values: dict

    def check(self, study: Study, C: Sequence[float]) -> list[tuple]:
        """Verdicts, with strength and electrode, as `verdicts_of` has them."""
        from .verdicts import verdicts_of

        how = study.temperatures, study.threshold_tolerance
        return verdicts_of(study, [self.values], C, *how)

    def require(self, study: Study) -> None:
        """Raise ValueError where a device lacks the electrode, strength or frame that it needs."""
        from .needs import require_shock

        require_shock(study, self.values)

    def plain(self) -> dict:
        """All but the shocks themselves, which follow from `pulse`."""
        return {key: value for key, value in self.values.items() if key != "shocks"}
