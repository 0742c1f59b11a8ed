"""Data with which the page follows a shock: beams in five cosines, their pulses, and time steps."""

import numpy as np

from ...solver.coefficients import coefficients
from ...solver.kernel import rows as R
from ...solver.models import build_model
from ...solver.options import Cosines
from ...solver.settings import Run
from ...study.axes import Grid, rows_of
from ...study.study import Study

COSINES = 5
MOST_PIECES = 20_000
"""Most pieces of a pulse that the page follows; a longer record would double its size."""
OWN = ("modes", "first", "second", "gravity", "factor", "held")
"""Numbers of a device before those of the kernel: C is `held` + `factor` times that of a shock."""
KERNEL = ("AXIAL", "RESIDUAL", "CONTACT", "M", "K", "TARGET", "BARRIER", "SADDLE", "Z0", "ALPHA")
OF_STOPS = "STOP_TOWARD", "STOP_AWAY", "RESTITUTION", "SIDE"
PLACES = {name: place for place, name in enumerate(OWN)}
PLACES |= {name: len(OWN) + getattr(R, name) for name in (*KERNEL, *OF_STOPS)}
PLACES["vectors"] = len(OWN) + R.SIDE + 1
"""Place of each number, and of the first vector, in a row of `forms`."""


def forms(grid: Grid, start: str) -> tuple[np.ndarray, np.ndarray]:
    """Tabulate the devices of a grid, and the time step of each of its points, us; start: of `Run`.

    The rows of the table, (devices, n), are OWN and then `coefficients`, and end in
    zeros if other devices have more modes. Steps are those of a history, NaN without a device.
    """
    model = build_model(grid.device, Cosines(modes=COSINES))
    cells = rows_of(grid).cells(grid.device, grid.axes["N"], horizon=0.0).flat()
    table, steps = np.zeros((len(grid.device), 0)), np.full(cells.device.size, np.nan)
    exists = np.flatnonzero(cells.device >= 0)
    for members, part in model.split(np.arange(len(grid.device))):
        rows = _rows(part, start)[members]
        more = max(0, rows.shape[1] - table.shape[1])
        table = np.pad(table, ((0, 0), (0, more)))
        table[members, : rows.shape[1]] = rows
        mine = exists[members[cells.device[exists]]]
        steps[mine] = part.time_steps(cells.take(mine), Run(start=start).but(until="moved"))
    return table, steps.reshape(grid.shape)


def _rows(model, start):
    device, barrier = model.device, model.barrier
    # Without a mass, a damper of 1 keeps the equation of y solvable.
    factor = np.where(device.is_alone, 0.0, device.damper_factor)
    own = model.modes, barrier.first, barrier.second, device.gravity, factor, device.is_alone
    columns = [np.broadcast_to(number, len(device)) for number in own]
    known = coefficients(model, model.snap_target(start), start)
    return np.hstack([np.stack(columns, axis=1), known])


def pulses(study: Study) -> list[dict]:
    """Describe each pulse of a study for the page; `pieces` is None if there are too many."""
    return [
        {
            "shape": shocks.pulse.name,
            "direction": shocks.direction,
            "pieces": pulse.pieces if len(pulse.pieces) <= MOST_PIECES else None,
            "ends": pulse.ends,
        }
        for shocks, pulse in zip(study.shocks.each(), study.shocks.pulses, strict=True)
    ]
