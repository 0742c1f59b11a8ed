"""Cells followed to their end."""

import numpy as np

from ...numerics.arithmetic import widen_vectors
from ...numerics.kept_kernels import compiled
from .lanes import begin, look, make_room
from .pulse import BLOCK, no_pulse, set_out
from .rows import LANES
from .scheme import advance_block


@compiled
def follow_all(X, shape, scheme, task):
    """Follow every cell until its well is proven or t_end is past, refilling each free lane.

    A proof is looked for after the pulse. The explicit scheme's energy wobbles with modes near the
    step limit, and one look may miss it: there a proof must hold at two, by a margin over the
    largest residual of all of them. It is judged at the look before a snap that ends it, and
    believed only if its energy closes within GUARD at its very end, too, as it may have blown up
    meanwhile.

    X: work array; task: `Task`, whose facts are written
    """
    widen_vectors()
    X[:] = 0.0
    cell_in, state, shocks = np.full(LANES, -1), no_pulse(), np.zeros(BLOCK * LANES)
    instants = X.copy(), X.copy(), X.copy(), X.copy()
    next_cell, running, was_shocked = 0, 0, False
    while next_cell < task.dt.size or running > 0:
        is_shocked = False
        for l in range(LANES):
            if cell_in[l] < 0 and next_cell < task.dt.size:
                cell_in[l] = next_cell
                begin(X, shape, scheme, l, task, state, cell_in[l])
                next_cell += 1
                running += 1
            is_shocked |= state.steps[l] < state.lasts[l]
        if is_shocked or was_shocked:
            set_out(X, shocks, state, task.pulses)
        was_shocked = is_shocked
        last_before, last_after, before, after = instants
        instants = before, after, last_before, last_after
        advance_block(X, shape, scheme, shocks, before, after)
        for l in range(LANES):
            if cell_in[l] < 0:
                continue
            state.steps[l] += BLOCK
            if look(X, shape, scheme, l, cell_in[l], state, task, instants):
                make_room(X, l, state)
                cell_in[l] = -1
                running -= 1
