"""The arithmetic: what a step of the kernel takes, and what one core can do."""

import re

import numpy as np
from numba import njit
from timing import take_turns

from snapmap.numerics.kernels import widen_vectors
from snapmap.solver.kernel.lanes import load
from snapmap.solver.kernel.pulse import BLOCK
from snapmap.solver.kernel.rows import LANES
from snapmap.solver.kernel.step import advance
from snapmap.solver.models import Model
from snapmap.solver.settings import MOVE
from snapmap.solver.simd_loop import coefficients, empty_lanes
from studies.few import few

HANDOUT, FOUR = "handout (9 modes)", "cosines, 4 modes"
KERNELS = {
    HANDOUT: {"name": "handout"},
    "cosines, 3 modes": {"name": "cosines", "modes": 3},
    FOUR: {"name": "cosines", "modes": 4},
    "cosines, 6 modes": {"name": "cosines", "modes": 6},
}
"""Name and options of the models whose speed is told, by what tables call them."""
CHAIN = 10
"""Long enough to hide loads and stores, short enough for several to be under way."""
ROUNDS = 1000
"""Of half a millisecond or so: on a busy machine one in a thousand is left alone."""


@njit(fastmath={"contract"}, error_model="numpy")
def multiply_add(x, factor, term, rounds):
    """Every number of x through a chain of CHAIN multiply-adds; the chains are independent."""
    widen_vectors()
    for _ in range(rounds):
        for l in range(x.size):
            number = x[l]
            for _ in range(CHAIN):
                number = number * factor + term
            x[l] = number


def peak_flops(numbers: int = 256, rounds: int = 15_000) -> float:
    """Most multiply-adds that this core was seen to do in a second, times two."""
    x = np.zeros(numbers)
    multiply_add(x, 0.5, 0.5, 1)
    runs = take_turns({"all": lambda: multiply_add(x, 0.5, 0.5, rounds)}, few(ROUNDS))
    return 2 * CHAIN * numbers * rounds / runs["all"].seconds


def vector_bits() -> int:
    """Widest vectors that the compiler uses here, after `multiply_add` has run."""
    code = "".join(multiply_add.inspect_asm().values())
    widths = {"z": 512, "y": 256, "x": 128}
    return max(widths[name] for name in re.findall(r"vfmadd\w+\s.*%([xyz])mm", code) or "x")


def step_flops(model: Model) -> int:
    """Additions and multiplications of one lane-step of a model with k modes.

    u, free and five sums k (2 k + 17), y 9, the overlap without a force 20,
    the force 9, r and q 7, gap 2, latch 3, p 10 k + 3, ledger 8: together 2 k^2 + 27 k + 61. The
    division counts as one; lanes in which a contact opens or closes take some 20 more.
    What is written twice, such as before + after, counts once; comparisons and signs count nothing.
    """
    k = model.modes
    return 2 * k**2 + 27 * k + 61


def block_seconds(model: Model, steps: int = 50 * BLOCK) -> float:
    """Time of the steps alone per lane-step, all lanes full, s."""
    dt = model.steps.longest[MOVE].item()
    lanes = _filled(model, dt)
    shocks = np.ones(BLOCK * LANES) * model.device.gravity * dt**2

    def advance_blocks():
        for _ in range(steps // BLOCK):
            advance(*lanes, shocks, 0, BLOCK)

    advance(*lanes, shocks, 0, 1)
    runs = take_turns({"all": advance_blocks}, few(ROUNDS))
    return runs["all"].seconds / (steps * LANES)


def _filled(model, dt):
    lanes, row = empty_lanes(model), coefficients(model, target=-np.inf)[0]
    for l in range(LANES):
        load(*lanes, l, row, 0.025, 900 * model.device.gravity, dt)
    return lanes
