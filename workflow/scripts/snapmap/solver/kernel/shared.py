"""What a step does beside its forces, of one lane; compiled into it."""

from ...numerics.arithmetic import fma
from ...numerics.kept_kernels import inlined
from . import rows as R
from .rows import LANES, row


@inlined
def take(X, shocks, step):
    """a of this step of every lane; apart, as only so the compiler keeps lanes side by side."""
    for l in range(LANES):
        X[row(R.SHOCK, l)] = shocks[step * LANES + l]


@inlined
def latch(X, l, w):
    """Latch w, with the value before, at the first instant at or below the target.

    Instants at which it is beyond the saddle are counted.
    """
    w_last = X[row(R.W, l)]
    above = w_last > X[row(R.TARGET, l)]
    X[row(R.W_BEFORE, l)] = w_last if above else X[row(R.W_BEFORE, l)]
    X[row(R.W, l)] = w if above else w_last
    X[row(R.COUNT, l)] += 1.0 if above else 0.0
    X[row(R.BEYOND, l)] += 1.0 if w < X[row(R.SADDLE, l)] else 0.0


@inlined
def move_mass(X, l, after, swept):
    """y+ = y + after, and the account of the step: work of the pulse, |y+ - y-|^2.

    swept: load.(p+ - p-)
    """
    before = X[row(R.Y_STEP, l)]
    X[row(R.Y_STEP, l)] = after
    X[row(R.Y, l)] += after
    work = -X[row(R.SHOCK, l)] * fma(X[row(R.MASS, l)], before + after, swept)
    X[row(R.WORK, l)] += work
    X[row(R.GROSS_WORK, l)] += abs(work)
    X[row(R.SWEPT, l)] = fma(before + after, before + after, X[row(R.SWEPT, l)])
