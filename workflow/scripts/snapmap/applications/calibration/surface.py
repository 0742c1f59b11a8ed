"""Thresholds of a device over ranges of its unknown values, interpolated on a grid."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.stats import qmc

from ...device.device import batch, is_bistable
from ...solver.cells import to_rows
from ...study.axes import point_text
from ...study.study import Study
from ...thresholds.population import Batch, choose_levels
from .shots import Group

POINTS = {1: 33, 2: 17, 3: 9, 4: 6}
"""Values of each unknown on the grid, by the number of unknowns."""
CHECKED = 64
"""Number of points at which the solver checks the interpolation; a power of two."""
TOLERANCE = 2e-4
"""Relative tolerance of thresholds."""


class Surface:
    """Logarithms of thresholds, ln N_first, over the unknowns as shares of their ranges.

    unknowns: ranges by name, internal units; logs: at the points of the grid, (..., groups)
    at: interpolates `logs` at shares of the ranges, (..., unknowns)
    error: root mean square error of the interpolation, (groups,)
    """

    def __init__(self, unknowns: Mapping, logs: np.ndarray):
        """Take logs of thresholds over an even grid."""
        self.unknowns, self.logs = dict(unknowns), logs
        axes = [np.linspace(0.0, 1.0, size) for size in logs.shape[:-1]]
        self.at, self.error = RegularGridInterpolator(axes, logs), np.zeros(logs.shape[-1])

    def values(self, u: np.ndarray) -> np.ndarray:
        """Return the unknowns, internal units, at shares of their ranges."""
        low, high = np.array(list(self.unknowns.values()), float).T
        return low + np.asarray(u) * (high - low)


def surface_of(
    study: Study, groups: Sequence[Group], unknowns: Mapping, C: float | None
) -> Surface:
    """Find the thresholds of a study's device under all groups of shots, over its unknowns.

    unknowns: ranges by name, internal units; C: uN us/um, or None if it is unknown
    Raises ValueError, one line, if a point has no second stable shape, or no threshold.
    """
    size = POINTS[len(unknowns)]
    check = qmc.Sobol(len(unknowns), scramble=False).random_base2(CHECKED.bit_length() - 1)
    steps = np.meshgrid(*[np.linspace(0.0, 1.0, size)] * len(unknowns), indexing="ij")
    grid = np.stack(steps, axis=-1).reshape(-1, len(unknowns))
    low, high = np.array(list(unknowns.values()), float).T
    # Points all over the ranges come first: they narrow the search for the others.
    points = low + np.concatenate([check, grid]) * (high - low)
    logs = log_thresholds(study, groups, dict(zip(unknowns, points.T, strict=True)), C)
    surface = Surface(unknowns, logs[CHECKED:].reshape(*steps[0].shape, len(groups)))
    apart = surface.at(check) - logs[:CHECKED]
    surface.error = np.sqrt((apart * apart).mean(axis=0)) + TOLERANCE
    return surface


def log_thresholds(
    study: Study, groups: Sequence[Group], values: Mapping[str, np.ndarray], C: float
) -> np.ndarray:
    """Find ln N_first, (points, groups), at values of the unknowns by name, (points,)."""
    of_device = {key: column for key, column in values.items() if key != "C"}
    bistable = is_bistable(study.device, of_device, len(next(iter(values.values()))))
    if not bistable.all():
        place = _place(of_device, np.argmin(bistable))
        raise ValueError(f"unknowns: no second stable shape at {place}; write a narrower range")
    # The middle of the ranges stands for the nominal device.
    middle = {key: np.array([(c.min() + c.max()) / 2]) for key, c in values.items()}
    C = middle.pop("C", C)
    device = batch([study.device]).vary(middle).pick(0)
    f0, pulses = [group.f0 for group in groups], tuple(group.pulse for group in groups)
    rows = to_rows(0, f0, C, np.arange(len(pulses)), pulses)
    settings = study.run
    levels = choose_levels(device, study.model, rows, settings)
    shares = {key: column / C if key == "C" else column for key, column in values.items()}
    scattered = Batch(device, shares, study.model, levels, settings.start)
    N_first, *_ = scattered.thresholds(rows, settings, TOLERANCE)
    if not np.isfinite(N_first).all():
        where, group = np.argwhere(~np.isfinite(N_first))[0]
        raise ValueError(
            f"shots: the model has no threshold for {groups[group]} at "
            f"{_place(study, values, where)}; leave such shots out, or write narrower ranges"
        )
    return np.log(N_first)


def _place(study, values, where):
    point = {key: column[where] for key, column in values.items()}
    return point_text(point, study.unit_of_C)
