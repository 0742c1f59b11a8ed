"""A model whose thresholds are known: C f0 (Hz) times the beam's thickness."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from snapmap.device.device import Device
from snapmap.solver.cells import no_observations

STAYS = 1.5
"""N over the threshold from which its runs end in the second well, in the usual step."""


@dataclass(frozen=True)
class Known:
    """Stretches of N snap, whose ends are multiples of the threshold.

    off: errors of the threshold at f0 = 1, 2... Hz, constant and of the step's square; or at all
    """

    device: Device
    ends: Sequence[float] = (1.0, np.inf)
    off: Sequence = (0.0, 0.0)
    step: float = 1.0

    def with_step(self, factor):
        return replace(self, step=factor * self.step)

    def follow(self, cells, settings):
        f0, off = 1e6 * cells.f0, np.transpose(self.off)
        constant, of_step = off[:, np.round(f0).astype(int) - 1] if off.ndim > 1 else off
        exact = self.device.beam.thickness[cells.device] * cells.damping * f0
        N = cells.amplitude / self.device.gravity[cells.device]
        at = N / exact / (1 + constant + of_step * self.step**2)
        snaps = np.searchsorted(self.ends, at, "right") % 2 == 1
        well, t_snap = np.where(at >= STAYS * self.step, 2, 1), np.where(snaps, 1.0, np.nan)
        seen = no_observations(at.shape)._replace(t_snap=t_snap, well=well, energy_error=0 * at)
        return seen._replace(t_settled=0 * at)
