"""The scene: cells of a map, rows with their exact thresholds, and the search of a single one."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from snapmap import Study, threshold
from snapmap.device.device import Device
from snapmap.solver.cells import Cells, to_cells
from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Cosines, Elements

from ..common import asking, few, threshold_near
from .equations import Equations, Follow, equations_of
from .exact import by_short_steps

HORIZON = 300.0
"""Time followed after the pulse, us; short, as who has no proofs follows all of it."""
SIDE, N_RANGE, F0_RANGE = 32, (600.0, 2400.0), (300.0, 20e3)
ROWS, DAMPINGS = np.geomspace(500.0, 8000.0, 7), (25.0, 200.0)
"""f0, Hz, and C, uN us/um, of the rows; the map has both C in turns."""
COSINES, ELEMENTS = "3 cosines", "5 elements"
MODELS = {COSINES: Cosines(modes=3), ELEMENTS: Elements()}
NEAR, RESOLVED, STEP = 1.01, 1e-6, 0.016
"""Factor within which thresholds are sought; their relative tolerance; steps of the judge, us."""
LOWEST, HIGHEST, SCAN, TOLERANCE = 600.0, 1e4, 1.03, 1e-4
"""A single threshold is scanned between these N, by this factor, and refined to this width."""


class Scene(NamedTuple):
    """One model's map, and its rows f0 (Hz) and C (uN us/um), each (rows,).

    about: N within a factor NEAR of which thresholds are sought, (rows,); as all start there, a row
        of several edges gives everyone the same one
    N: exact thresholds, (rows,); error: relative, the change from steps twice as long
    """

    device: Device
    model: Model
    equations: Equations
    map: Cells
    f0: np.ndarray
    C: np.ndarray
    about: np.ndarray
    N: np.ndarray
    error: float = 0.0

    def take(self, which: slice) -> "Scene":
        """Return the scene with some of its rows."""
        rows = {name: getattr(self, name)[which] for name in ("f0", "C", "about", "N")}
        return self._replace(**rows)

    def asked(self, follow: Follow) -> Callable:
        """Make a function of N, (rows, n), that returns t_snap; NaN where N is NaN."""
        return asking(self.device, follow, (self.f0, self.C), HORIZON)

    def errors(self, follow: Follow) -> np.ndarray:
        """Return relative errors of the thresholds, (rows,); NaN without one within NEAR."""
        N = threshold_near(self.asked(follow), self.about, NEAR, RESOLVED)
        return np.abs(N / self.N - 1)


def make_scene(device: Device, name: str, f0_of_rows: np.ndarray) -> Scene:
    """Make the scene of the equations of MODELS, with rows at these f0, Hz, and both DAMPINGS."""
    side = few(SIDE, 3)
    N, f0 = np.meshgrid(np.linspace(*N_RANGE, side), np.geomspace(*F0_RANGE, side))
    cells = to_cells(device, 0, N, f0, np.resize(DAMPINGS, N.shape), HORIZON).flat()
    study = Study(device, Cosines(modes=3), horizon=HORIZON)
    first = threshold(study, f0_of_rows, DAMPINGS).N_first.stack(row=("C", "f0"))
    model = build_model(device, MODELS[name])
    rows = first.f0.values, first.C.values, first.values, first.values
    scene = Scene(device, model, equations_of(model), cells, *rows)
    coarse, fine = (
        threshold_near(
            scene.asked(by_short_steps(scene.equations, dt)), scene.about, NEAR, RESOLVED
        )
        for dt in (2 * STEP, STEP)
    )
    return scene._replace(N=fine, error=float(np.abs(coarse / fine - 1).max()))


def lowest_snap(ask: Callable, width: int) -> tuple[float, int]:
    """Find the lowest N that snaps as a user would; returns it, or NaN, and the number of runs.

    ask: function of N, (1, width), as of `Scene.asked`; width: number of N asked at once
    """
    low, high, runs, parts = LOWEST, np.inf, 0, np.arange(1, width + 1)
    while low < HIGHEST and high / low > 1 + TOLERANCE:
        scanning = np.isinf(high)
        N = low * SCAN**parts if scanning else low + (high - low) * parts / (width + 1)
        snaps, runs = np.isfinite(ask(N[np.newaxis])[0]), runs + width
        ends = np.concatenate([[low], N, [high]])
        first = int(np.argmax(snaps)) + 1 if snaps.any() else width + 1
        low, high = ends[first - 1], ends[first]
    return (low + high) / 2 if np.isfinite(high) else np.nan, runs
