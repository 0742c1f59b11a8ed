"""The work array as rows, for kernels."""

import numpy as np
from numba import carray, int64, types
from numba.extending import intrinsic

from ...numerics.kernels import inlined
from . import rows as R
from .rows import Rows


@intrinsic
def address(context, array, first):
    """Return the address of element `first` of a flat array."""

    def build(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.gep(data, [arguments[1]])

    return types.CPointer(types.float64)(array, int64), build


@inlined
def numbers(work: np.ndarray) -> Rows:
    """Return X, the rows of single numbers.

    The compiler vectorises over lanes only because it knows the sizes of X and V, and thus that no
    two rows overlap.
    """
    return carray(address(work, 0), (R.VECTORS, R.LANES))


@inlined
def vectors(work: np.ndarray, modes: int) -> Rows:
    """Return V, the rows of vectors.

    Functions that loop over modes get their number as an argument: from the shape of V the compiler
    learns it too late to unroll.
    """
    return carray(address(work, R.VECTORS * R.LANES), (R.S + modes, modes, R.LANES))
