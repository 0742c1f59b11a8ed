"""Cells followed to their end."""

import numpy as np

from ...numerics.arithmetic import widen_vectors
from ...numerics.kept_kernels import compiled
from .lanes import begin, look, make_room
from .pulse import BLOCK, no_pulse, set_out
from .rows import LANES
from .step import advance


@compiled
def follow_all(X, shape, task):
    """Follow every cell until its well is proven or t_end is past, refilling each free lane.

    X: work array; task: `Task`, whose facts are written
    """
    widen_vectors()
    X[:] = 0.0
    cell_in, state, shocks = np.full(LANES, -1), no_pulse(), np.zeros(BLOCK * LANES)
    next_cell, running, was_shocked = 0, 0, False
    while next_cell < task.dt.size or running > 0:
        is_shocked = False
        for l in range(LANES):
            if cell_in[l] < 0 and next_cell < task.dt.size:
                cell_in[l] = next_cell
                begin(X, shape, l, task, state, cell_in[l])
                next_cell += 1
                running += 1
            is_shocked |= state.steps[l] < state.lasts[l]
        if is_shocked or was_shocked:
            set_out(X, shocks, state, task.pulses)
        was_shocked = is_shocked
        advance(X, shape, shocks, 0, BLOCK)
        for l in range(LANES):
            if cell_in[l] < 0:
                continue
            state.steps[l] += BLOCK
            if look(X, shape, l, cell_in[l], state, task):
                make_room(X, l, state)
                cell_in[l] = -1
                running -= 1
