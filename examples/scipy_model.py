"""A whole solver of your own: SciPy's solve_ivp as a model that follows cells."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp

from snapmap.device.device import Device
from snapmap.solver.cells import no_observations


@dataclass(frozen=True)
class Drop:
    """A device whose mass alone moves, on its spring; it "snaps" where it has fallen by `depth`."""

    device: Device
    depth: float
    rtol: float = 1e-6

    @property
    def levels(self):
        return (self,)

    def split(self, device):
        return [(np.ones(device.shape, bool), self)]

    def with_step(self, factor):
        return replace(self, rtol=self.rtol * factor**4)

    def pick(self, which):
        return replace(self, device=self.device.pick(which))

    def follow(self, cells, settings):
        observed = no_observations(cells.f0.shape)
        for at in np.ndindex(cells.f0.shape):
            observed.t_snap[at] = self.fall(cells, at)
            observed.energy_error[at] = 0.0  # believed as it is
        return observed

    def fall(self, cells, at):
        _, pulse, amplitude, f0, C, t_end = (column[at] for column in cells[:-1])
        M, K = (np.atleast_1d(v)[cells.device[at]] for v in (self.device.mass, self.device.spring))

        def rate(t, state):
            y, v = state
            a = amplitude * cells.pulses[pulse].at(np.array([f0 * t])).item()
            return v, -a - (K * y + C * v) / M

        def falls(t, state):
            return state[0] + self.depth

        falls.terminal = True
        step = 1 / (50 * f0)
        run = solve_ivp(rate, (0, t_end), (0, 0), rtol=self.rtol, events=falls, max_step=step)
        return run.t_events[0][0] if run.t_events[0].size else np.nan
