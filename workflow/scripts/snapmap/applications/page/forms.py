"""Data with which the page follows a shock itself: beams in five cosines, pulses, and steps."""

import numpy as np

from ...beam.modal import contact_stiffness
from ...solver.models import build_model
from ...solver.options import Cosines
from ...solver.settings import MOVE, SECOND
from ...solver.steps import FEWEST_STEPS, PER_SWING, STRIKE_TURN
from ...study.axes import Grid
from ...study.study import Study

COSINES = 5
MOST_PIECES = 20_000
"""Most pieces of a pulse that the page follows; a longer record would double its size."""
LIMITS = {"few": FEWEST_STEPS, "perSwing": PER_SWING, "turn": STRIKE_TURN}
"""Limits of the time step, as `simulate.js` calls them."""
NUMBERS = (
    *("modes", "axial", "residual", "contact", "M", "K", "z0", "alpha", "toward", "away"),
    *("restitution", "target", "barrier", "saddle", "first", "second", "gravity", "warmth"),
    *("held", "longest", "shortest", "tightening", "ownTightening", "omega", "arch", "isBack"),
)
"""Numbers of a beam and its mass, as `simulate.js` calls them; vectors and a matrix follow."""


def forms(grid: Grid, start: str) -> np.ndarray:
    """Tabulate the coefficients of the devices of a grid, (devices, coefficients).

    A row holds NUMBERS, then kappa, S q0, f, e, the modes at the start, and S, in the names of
    docs/theory.md, then zeros.
    """
    model = build_model(grid.device, Cosines(modes=COSINES))
    table = np.zeros((len(grid.device), 0))
    for members, part in model.split(np.arange(len(grid.device))):
        rows = _rows(part, start)[members]
        more = max(0, rows.shape[1] - table.shape[1])
        table = np.pad(table, ((0, 0), (0, more)))
        table[members, : rows.shape[1]] = rows
    return table


def _rows(model, start):
    device, modal, barrier, steps = model.device, model.modal, model.barrier, model.steps
    n, k = len(device), model.modes
    omega = np.where(device.is_alone, np.inf, device.mass_frequency)
    numbers = (
        *(k, modal.axial, modal.residual, contact_stiffness(device, modal.residual)),
        *(device.mass, device.spring, device.gap, device.beam.damping),
        *(device.stop_toward, device.stop_away, device.restitution),
        *(model.snap_target(start), barrier.energy, barrier.midpoint),
        *(barrier.first, barrier.second, device.gravity),
        # Without a mass, a damper of 1 keeps the equation of y solvable.
        *(np.where(device.is_alone, 0.0, device.damper_factor), device.is_alone),
        *(steps.longest[MOVE], steps.shortest),
        np.where(device.has_stops | (start == SECOND), steps.tightening, 0.0),
        *(steps.own_tightening, omega, steps.arch, start == SECOND),
    )
    columns = [np.broadcast_to(number, n)[:, np.newaxis] for number in numbers]
    vectors = modal.stiffness, *modal[2:5], model.rest(start), modal.geometric
    return np.hstack([*columns, *(np.reshape(vector, (n, -1)) for vector in vectors)])


def pulses(study: Study) -> list[dict]:
    """Describe each pulse of a study for the page; `pieces` is None if there are too many."""
    return [
        {
            "shape": shocks.pulse.name,
            "direction": shocks.direction,
            "pieces": pulse.pieces if len(pulse.pieces) <= MOST_PIECES else None,
            "ends": pulse.ends,
            "swings": pulse.swings,
            "strikes": pulse.strikes,
            "grossArea": pulse.gross_area,
            "variation": pulse.variation,
        }
        for shocks, pulse in zip(study.shocks.each(), study.shocks.pulses, strict=True)
    ]
