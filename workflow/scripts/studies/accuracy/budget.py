"""How much of a plan a device affords within SECONDS, so that no study takes for ever."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from snapmap.device import Device
from snapmap.shocks import Shocks
from snapmap.solver.cells import to_cells
from snapmap.solver.cost import steps_and_seconds
from snapmap.solver.models import build_model
from snapmap.solver.settings import Settings

from .cases import list_cases
from .converged import FINE_STEP
from .plans import Plan
from .probe import MOST_ROWS

SECONDS = 300.0
"""Expected time of all runs together, each to its horizon, in one thread."""
LEAST_SIDE = 6
ASKED = 30
"""Cells of a threshold, about."""
REPEATED = 1.5
"""A converged run is followed again with twice the step."""


class Affordable(NamedTuple):
    """What is measured: axes, settings and plan, and a line on each thing that was cut down.

    slowest: least f0, Hz
    """

    axes: dict[str, np.ndarray]
    settings: Settings
    plan: Plan
    left_out: tuple[str, ...]
    slowest: float


class Cost(NamedTuple):
    """Seconds for each us that one cell is followed: on the map, and for a threshold."""

    of_map: float
    of_row: float
    maps: int

    def seconds(self, side: int, length: float) -> float:
        """Of everything, with maps of side x side cells and runs of this length, us."""
        cells = self.maps * side * side
        return (self.of_map * cells + self.of_row * MOST_ROWS * ASKED) * length


def afford(
    device: Device,
    axes: Mapping[str, Sequence[float]],
    settings: Settings,
    plan: Plan,
    shocks: Shocks,
) -> Affordable:
    """Cut down the slowest pulses, the horizon and the cells of the map to what is affordable.

    axes: C, f0 (Hz) and N of the sweep
    """
    axes = {key: np.sort(np.asarray(axes[key], float)) for key in ("C", "f0", "N")}
    maps = np.unique(axes["C"][[0, -1]]).size * len(shocks.pulses)
    cost = _cost(device, axes["f0"], settings, plan, maps)
    longest = SECONDS / cost.seconds(min(plan.side, LEAST_SIDE), 1.0)
    slowest = 2e6 / longest
    f0 = np.unique(np.maximum(axes["f0"], slowest))
    horizon = min(settings.horizon, longest / 2)
    length = float(np.mean(1e6 / f0)) + horizon
    sides = range(plan.side, 0, -1)
    side = next(s for s in sides if s <= LEAST_SIDE or cost.seconds(s, length) <= SECONDS)
    told = []
    if f0[0] > axes["f0"][0]:
        told.append(f"pulses from {f0[0]:.3g} Hz, not {axes['f0'][0]:.3g}")
    if horizon < settings.horizon:
        told.append(f"{horizon:.3g} us after the pulse, not {settings.horizon:.6g}")
    if side < plan.side:
        told.append(f"maps of {side} x {side} cells, not {plan.side} x {plan.side}")
    settings, plan = settings._replace(horizon=horizon), plan._replace(side=side)
    return Affordable(axes | {"f0": f0}, settings, plan, tuple(told), slowest)


def _cost(device, f0, settings, plan, maps):
    def seconds(model):
        """Expected time to follow one cell for 1 us, of the shortest pulse: it asks for most."""
        cells = to_cells(model.device, [0], 0.0, f0.max(), 0.0, 0.0)
        return (steps_and_seconds(model, cells, settings)[1] / cells.t_end).item()

    def fine(one, name, **options):
        return seconds(build_model(one, name, step=FINE_STEP, **options))

    of_cases = sum(seconds(case.model) for case in list_cases(device, settings, plan))
    of_map, of_row = of_cases, of_cases
    runs = [(device, plan.converged)]
    if math.isfinite(device.contact):
        runs.append((replace(device, contact=math.inf), plan.hard))
    for one, refinement in runs:
        cosines = [fine(one, "cosines", modes=modes) for modes in refinement.cosines]
        meshes = [
            fine(one, "elements", modes=refinement.modes[0], elements=elements)
            for elements in refinement.meshes
        ]
        of_map += REPEATED * cosines[0]
        of_row += REPEATED * sum(cosines) + 2 * sum(meshes)
    return Cost(of_map, of_row, maps)
