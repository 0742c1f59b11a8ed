"""Required shocks that must close an electrode in time, or for long enough."""

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from ...config.shocks import PulseSection
from ...solver.settings import SECOND
from ...study.study import ARRIVES, Study
from ...values.quantities import PulseTime
from ...values.records import record
from ..application import Config
from ..requirements.sections import RequiredShock, ShockSection
from ..requirements.verdict import MET, UNCLEAR, VIOLATED, Verdict

DEMANDS = "closes_within", "stays_closed"
"""Keys of a required closing."""


@dataclass(frozen=True, eq=False, kw_only=True)
class RequiredClosing(RequiredShock):
    """A required shock that must close the electrode; demands: one or both of DEMANDS, us."""

    more: ClassVar[str] = "closing"
    demands: Mapping[str, float] = field(default_factory=dict)

    def check(self, study: Config, C: Sequence[float]) -> list[Verdict]:
        """Judge the shock, then its closures; `more` holds these with their margins."""
        return [judge_closing(verdict, **self.demands) for verdict in super().check(study, C)]

    def require(self, study: Study) -> None:
        """Raise ValueError if the devices lack an electrode, strength or frame."""
        if not any(device.has_electrode for device in study.devices().values()):
            need = "write the place of the electrode, such as '-5 um'"
            key = next(iter(self.demands))
            raise ValueError(f"device.contact_at: missing, but {key} needs it; {need}")
        super().require(study)


def judge_closing(
    verdict: Verdict, closes_within: float | None = None, stays_closed: float | None = None
) -> Verdict:
    """Judge the closures of an electrode, which are in `more`, too.

    closes_within, stays_closed: one or both of DEMANDS, us
    Adds `closes_margin`, closes_within over t_closed, and `stays_margin`, closed_for over
    stays_closed; NaN if the electrode never closes.
    """
    outcomes, more = [verdict.verdict], {**verdict.more}
    if closes_within:
        closed = more["t_closed"]
        outcomes.append(_kept(closes_within - closed, more["t_closed_error"], verdict))
        more["closes_margin"] = closes_within / closed
    if stays_closed:
        closed = more["closed_for"]
        kept = _kept(closed - stays_closed, more["closed_for_error"], verdict)
        # A contact that is closed at the end of the run may stay closed beyond it.
        outcomes.append(UNCLEAR if kept == VIOLATED and more["openings"] == 0 else kept)
        more["stays_margin"] = closed / stays_closed
    worst = max(outcomes, key=(MET, UNCLEAR, VIOLATED).index)
    return replace(verdict, verdict=worst, more=more)


def _kept(slack, error, verdict):
    """Judge a demand by its slack and its error, us; the slack is NaN if nothing closes."""
    if np.isnan(slack):
        return UNCLEAR if verdict.verdict == UNCLEAR else VIOLATED
    return MET if slack > error else VIOLATED if slack < -error else UNCLEAR


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
        required: Any = super().under(pulse, gravity)
        # These say how long it must stay.
        snaps = ARRIVES if self.snaps is True else self.snaps
        return replace(required, snaps=snaps, demands=self.demands)
