"""The section of a required shock that must close the electrode."""

from dataclasses import replace

from ...config.keys import quantity
from ...config.shocks import PulseSection
from ...solver.settings import SECOND
from ...study.study import ARRIVES
from ..requirements.sections import ShockSection
from .required import DEMANDS, RequiredClosing


class ClosingSection(ShockSection):
    """A shock under which the device must close its electrode.

    `snaps: true` counts as `arrives`.
    """

    kind = RequiredClosing
    closes_within: quantity(
        "pulse", "longest time from the start of the shock until the beam closes", out="any time"
    )
    stays_closed: quantity("pulse", "least time until the beam opens again", out="any time")

    def make(self) -> None:
        """Nothing by itself; ValueError for what cannot be in any study."""
        if self.snaps is False or self.start == SECOND:
            closing = next(key for key in DEMANDS if self.has(key))
            more = ", and no start" if self.start else ""
            need = f"write snaps: true or any{more}"
            raise ValueError(f".{closing}: needs a device that must trip; {need}")
        super().make()

    def under(self, pulse: PulseSection | None, gravity: float) -> RequiredClosing:
        """Make the requirement of a study, as for any shock, with its DEMANDS."""
        required = super().under(pulse, gravity)
        demands = {key: self.given[key] for key in DEMANDS if self.has(key)}
        # These say how long it must stay.
        return replace(required, snaps=ARRIVES if self.snaps is True else self.snaps, **demands)
