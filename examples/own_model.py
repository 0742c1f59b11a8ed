"""A model of your own, which follows cells as those of snapmap do: the mass on its spring."""

import numpy as np
from scipy.integrate import solve_ivp

from snapmap.solver.cells import no_observations

DEPTH = 20.0  # um below its rest, where the mass is caught, which counts as the snap


class MassAlone:
    def __init__(self, device):
        self.device = device  # in um, ng and us

    def follow(self, cells, settings):
        """Tell when each cell snaps, us; NaN if it does not. A run without energy_error failed."""
        observed = no_observations(cells.f0.shape)
        for place in np.ndindex(cells.f0.shape):
            cell = cells.take(place)
            observed.t_snap[place] = self.t_snap(cell, cell.pulses[cell.pulse])
            observed.energy_error[place] = 0.0
        return observed

    def t_snap(self, cell, pulse):
        def rate(t, state):
            y, v = state
            acceleration = cell.amplitude * pulse.at(cell.f0 * t)  # of the frame along +z, um/us^2
            return v, -acceleration - (self.device.spring * y + cell.damping * v) / self.device.mass

        times = np.arange(0.0, cell.t_end)  # every us, as an event of SciPy's may miss a short fall
        how = {"rtol": 1e-6, "max_step": 0.1 / cell.f0, "t_eval": times}
        is_caught = solve_ivp(rate, (0, cell.t_end), (0, 0), **how).y[0] <= -DEPTH
        return times[is_caught.argmax()] if is_caught.any() else np.nan
