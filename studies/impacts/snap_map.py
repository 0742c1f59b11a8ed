"""The fifth problem of README.md: snap or no snap on a map of the handout's device."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from snapmap.device.device import Device
from snapmap.solver.cells import Cells
from snapmap.solver.models import Model, build_model
from snapmap.solver.options import Cosines

from ..scipy_solver import by_scipy, compile_rate, snap_target
from ..speed import by_model, map_cells, without_settling
from .problems import Problem
from .solvers import Solve, plain_loop

SNAP = "snap or no snap"
FINE = 0.1
"""Step of the plain loop that gives the labels, us."""
NEAR = -0.002, -0.001, 0.0, 0.001, 0.002
"""Relative changes of N that do not change the label of any cell of the problem."""


@dataclass(frozen=True, eq=False)
class SnapMap:
    """Cells of a model of one device, and whether each snaps before its end."""

    model: Model
    cells: Cells
    exact: np.ndarray
    name: str = SNAP
    allowed: tuple[float, float] = (0.01, 0.0)

    def some(self, which: slice | np.ndarray) -> "SnapMap":
        """Return the map of some cells."""
        return replace(self, cells=self.cells.take(which), exact=self.exact[which])

    def wrong(self, labels: np.ndarray, level: int) -> int:
        """Count the labels that differ; the level does not matter."""
        return int(np.sum(labels != self.exact))


def make_map(device: Device) -> SnapMap:
    """Make workload A in three cosines, without cells whose label changes within NEAR."""
    cells = map_cells(device)
    blank = SnapMap(build_model(device, Cosines(modes=3)), cells, np.zeros(cells.f0.size, bool))
    many = [cells._replace(amplitude=cells.amplitude * (1 + change)) for change in NEAR]
    columns = zip(*(cells[:-1] for cells in many), strict=True)
    joined = Cells(*map(np.concatenate, columns), many[0].pulses)
    labels = map_by_plain_loop(replace(blank, cells=joined))(FINE).reshape(len(NEAR), -1)
    return replace(blank, exact=labels[0]).some(labels.all(axis=0) | ~labels.any(axis=0))


def map_by_scipy(snaps: SnapMap) -> Solve:
    """Label by `solve_ivp`, in the pulse and after it; the snap is an event."""
    system = snaps.model.device, snaps.model.modal, "DOP853"
    follow = cache(lambda tolerance: by_scipy(*system, tolerance))
    return lambda tolerance: np.isfinite(follow(tolerance)(snaps.cells))


def map_by_plain_loop(snaps: SnapMap) -> Solve:
    """Label by the plain loop, which ends at w2."""
    model, cells = snaps.model, snaps.cells
    rate, w = compile_rate(model.device, model.modal)
    target = snap_target(model.device)

    def shaken(t, x, q):
        return rate(t, x, q[0] if q[1] * t < 1.0 else 0.0, q[1], q[2])

    problem = Problem(
        SNAP,
        rate=lambda math: shaken,
        guard=lambda x, q: w(x) - target,
        reset=lambda x, q: (x, q),
        start=np.zeros((cells.f0.size, 2 * model.modes + 2)),
        q=np.stack([cells.amplitude, cells.f0, cells.damping], axis=1),
        t_end=cells.t_end,
        exact=snaps.exact,
        rest=np.inf,
    )
    follow = plain_loop(problem)
    return lambda dt: follow(problem.start, problem.q, problem.t_end, dt)[1] < problem.t_end


def map_by_kernel(snaps: SnapMap) -> Solve:
    """Label by our kernel, which follows every cell to its snap or end."""
    open_end = without_settling(snaps.model)
    return lambda step: np.isfinite(by_model(open_end.with_step(step))(snaps.cells))


def map_until_settled(snaps: SnapMap) -> Solve:
    """Label as a sweep does: a cell also ends when it has settled without a snap."""
    return lambda step: np.isfinite(by_model(snaps.model.with_step(step))(snaps.cells))
