"""The section of required shocks that must close an electrode."""

from dataclasses import KW_ONLY, replace
from typing import ClassVar

from ...config.shocks import PulseSection
from ...solver.settings import SECOND
from ...study.study import ARRIVES
from ...values.quantities import PulseTime
from ...values.records import record
from ..requirements.required import RequiredShock
from ..requirements.sections import ShockSection
from .required import DEMANDS, RequiredClosing


@record
class ClosingSection(ShockSection):
    """A shock under which the device must close its electrode.

    `snaps: true` counts as `arrives`.
    """

    kind: ClassVar[type[RequiredShock]] = RequiredClosing
    _: KW_ONLY
    closes_within: PulseTime | None = None
    """longest time from the start of the shock until the beam closes"""
    stays_closed: PulseTime | None = None
    """least time until the beam opens again"""

    @property
    def demands(self) -> dict[str, float]:
        """Those of DEMANDS that are written, us."""
        demands = {key: getattr(self, key) for key in DEMANDS}
        return {key: value for key, value in demands.items() if value is not None}

    def __post_init__(self):
        """Raise ValueError for what cannot be in any study."""
        if self.snaps is False or self.start == SECOND:
            more = ", and no start" if self.start == SECOND else ""
            need = f"write snaps: true or any{more}"
            raise ValueError(f"{next(iter(self.demands))}: needs a device that must trip; {need}")
        if self.share:
            line = f"share: not known of {next(iter(self.demands))}; leave one of them out"
            raise ValueError(line)
        super().__post_init__()

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredShock:
        """Make the requirement of a study, as for any shock, with its DEMANDS."""
        required = super().under(pulse, gravity)
        # These say how long it must stay.
        snaps = ARRIVES if self.snaps is True else self.snaps
        return replace(required, snaps=snaps, **self.demands)
