"""Cells followed to their end."""

import numpy as np

from ...numerics.arithmetic import widen_vectors
from ...numerics.kept_kernels import compiled
from .lanes import begin, look, make_room
from .pulse import BLOCK, no_pulse, set_out
from .rows import LANES, numbers, vectors
from .step import advance


@compiled
def follow_all(work, shape, task):
    """Follow every cell until its well is proven or t_end is past, refilling each free lane.

    work: the work array; task: `Task`, whose facts are written
    """
    widen_vectors()
    work[:] = 0.0
    X, V = numbers(work), vectors(work, len(shape))
    cell_in, state, shocks = np.full(LANES, -1), no_pulse(), np.zeros(BLOCK * LANES)
    next_cell, running, was_shocked = 0, 0, False
    while next_cell < task.dt.size or running > 0:
        is_shocked = False
        for l in range(LANES):
            if cell_in[l] < 0 and next_cell < task.dt.size:
                cell_in[l] = next_cell
                begin(work, shape, l, task, state, cell_in[l])
                next_cell += 1
                running += 1
            is_shocked |= state.steps[l] < state.lasts[l]
        if is_shocked or was_shocked:
            set_out(work, shocks, state, task.pulses)
        was_shocked = is_shocked
        advance(work, shape, shocks, 0, BLOCK)
        for l in range(LANES):
            if cell_in[l] < 0:
                continue
            state.steps[l] += BLOCK
            if look(X, V, len(shape), l, cell_in[l], state, task):
                make_room(work, l, state)
                cell_in[l] = -1
                running -= 1
