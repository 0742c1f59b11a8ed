"""Thresholds of a device over ranges of its unknown values: a grid of them, and between."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.interpolate import RegularGridInterpolator
from scipy.stats import qmc

from ..axes import point_text
from ..device import batch, is_bistable
from ..solver.cells import to_rows
from ..study import Study
from ..tolerances.batch import choose_builder
from ..tolerances.regression import nominal_thresholds, thresholds_of_samples
from .shots import Kind

POINTS = {1: 33, 2: 17, 3: 9, 4: 6}
"""Values of each unknown on the grid, by how many unknowns there are."""
CHECKED = 64
"""Points within the ranges at which what stands between the grid's is held against the solver;
a power of two."""
TOLERANCE = 2e-4
"""Of each threshold, relative."""


class Surface:
    """Logarithms of thresholds, ln N, over the unknowns, each from 0 to 1 of its range.

    unknowns: ranges by name, internal units; logs: at the points of the grid, (..., kinds)
    error: of what stands between them, (kinds,), root mean square
    """

    def __init__(self, unknowns: Mapping, logs: np.ndarray):
        """Take logs of thresholds over an even grid."""
        self.unknowns, self.logs = dict(unknowns), logs
        self.axes = [np.linspace(0.0, 1.0, size) for size in logs.shape[:-1]]
        self._between = RegularGridInterpolator(self.axes, logs)
        self.error = np.zeros(logs.shape[-1])

    def at(self, u: np.ndarray) -> np.ndarray:
        """Logarithms of thresholds, (..., kinds), at shares of the ranges, (..., unknowns)."""
        return self._between(u)

    def values(self, u: np.ndarray) -> np.ndarray:
        """Values of the unknowns, internal units, at shares of their ranges."""
        low, high = np.array(list(self.unknowns.values()), float).T
        return low + np.asarray(u) * (high - low)


def surface_of(study: Study, kinds: Sequence[Kind], unknowns: Mapping, C: float | None) -> Surface:
    """Find the thresholds of a study's device over ranges of its unknowns, of all kinds at once.

    C: uN us/um, unless it is unknown
    Raises ValueError, one line, where there is no second stable shape, or no threshold.
    """
    size = POINTS[len(unknowns)]
    check = qmc.Sobol(len(unknowns), scramble=False).random_base2(CHECKED.bit_length() - 1)
    steps = np.meshgrid(*[np.linspace(0.0, 1.0, size)] * len(unknowns), indexing="ij")
    grid = np.stack(steps, axis=-1).reshape(-1, len(unknowns))
    low, high = np.array(list(unknowns.values()), float).T
    # Those that lie all over the ranges come first: they tell where to look for the others.
    points = low + np.concatenate([check, grid]) * (high - low)
    logs = np.log(_thresholds(study, kinds, dict(zip(unknowns, points.T, strict=True)), C))
    found = Surface(unknowns, logs[CHECKED:].reshape(*steps[0].shape, len(kinds)))
    apart = found.at(check) - logs[:CHECKED]
    found.error = np.sqrt((apart * apart).mean(axis=0)) + TOLERANCE
    return found


def _thresholds(study, kinds, values, C):
    """N_first, (points, kinds), at values of the unknowns by name, (points,)."""
    damping = values.get("C", np.full(len(next(iter(values.values()))), C))
    made = {key: column for key, column in values.items() if key != "C"}
    there = is_bistable(study.device, made, damping.size)
    if not there.all():
        place = _place(made, np.argmin(there))
        raise ValueError(f"unknowns: no second stable shape at {place}; write a narrower range")
    # The middle of the ranges stands for the nominal device.
    middle = {key: np.array([(c.min() + c.max()) / 2]) for key, c in made.items()}
    device = batch([study.device])
    centre = device.vary(middle)
    f0, pulse = np.array([kind.f0 for kind in kinds]), np.arange(len(kinds))
    pulses, settings = tuple(kind.pulse for kind in kinds), study.settings
    rows = to_rows(0, f0, (damping.min() + damping.max()) / 2, pulse, pulses)
    build = choose_builder(centre.pick(0), study.model, rows, settings)
    nominal = nominal_thresholds(build(centre), rows, settings, TOLERANCE / 10)
    model = build(device.pick(np.zeros(damping.size, int)).vary(made))
    rows = to_rows(np.arange(damping.size)[:, None], f0, damping[:, None], pulse, pulses)
    apart = np.column_stack([column - column.mean() for column in values.values()])
    found, _ = thresholds_of_samples(model, rows, apart, nominal, settings, TOLERANCE)
    if not np.isfinite(found).all():
        where, kind = np.argwhere(~np.isfinite(found))[0]
        raise ValueError(
            f"shots: outside the model's reach, no threshold of {kinds[kind]} at "
            f"{_place(values, where)}; leave such shots out, or write narrower ranges"
        )
    return found


def _place(values, where):
    return point_text({key: column[where] for key, column in values.items()})
